"""Path following: load control, displacement control, arc length."""

from kirigami.moved import forward

__getattr__ = forward("analysis.path", ("analysis.path.methods",))  # names of version 0.1, when this was a module
