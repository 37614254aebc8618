"""A model lowered into kernels, numbered, constrained and ready to be assembled."""
