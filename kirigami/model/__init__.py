"""The model: nodes, constraints, loads, and sheet models from meshes."""
