"""Reading and writing: drawings, tables, pictures that turn, and models for other programs.

Each module needs at most one library beyond the package's own; ``pip install "kirigami-mechanics[io]"`` brings all of
them.
"""
