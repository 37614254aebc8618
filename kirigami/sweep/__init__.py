"""Many designs of any function: samples, workers, a resumable table."""

from kirigami.moved import forward

__getattr__ = forward("sweep", ("sweep.sweep",))  # names of version 0.1, when this was a module
