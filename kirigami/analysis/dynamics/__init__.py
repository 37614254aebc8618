"""Motion in time: implicit steps that keep energy, and damped ones."""
