"""A model lowered into kernels, numbered, constrained and ready to be assembled."""

from kirigami.moved import forward

__getattr__ = forward("system", ("system.system",))  # names of version 0.1, when this was a module
