"""What holds for the whole suite."""

from __future__ import annotations

import gc

collect_ignore_glob = ["*conftest.py"]  # as modules with examples they would be mistaken for one another


def pytest_configure() -> None:
    """Ten thousand tests are found without a search for garbage, of which finding makes none."""
    gc.disable()


def pytest_collection_finish() -> None:
    """What was found stays to the end: no search for garbage looks at it again."""
    gc.collect()
    gc.freeze()
    gc.enable()
