"""Elements: one file each, holding the object, its kernel and its closed-form derivatives."""
