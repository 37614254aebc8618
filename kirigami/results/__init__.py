"""What comes out of an analysis: steps, results, their files, stress and fields."""

from kirigami.moved import forward

__getattr__ = forward("results", ("results.results",))  # names of version 0.1, when this was a module
