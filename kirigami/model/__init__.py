"""The model: nodes, constraints, loads, and sheet models from meshes."""

from kirigami.moved import forward

__getattr__ = forward("model", ("model.model",))  # names of version 0.1, when this was a module
