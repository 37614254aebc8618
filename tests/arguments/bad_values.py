"""Values that are wrong nearly everywhere, and where the annotation of a parameter says that they are right."""

from __future__ import annotations

import math
from typing import Any

import numpy as np


class Foreign:
    """An object that has nothing to do with the package."""

    def __repr__(self) -> str:
        return "<foreign>"


# Name: the value, and the parts of an annotation under which it may pass.
BAD: dict[str, tuple[Any, set[str]]] = {
    "text": ("abc", {"path"}),
    "number as text": ("1.0", {"path"}),
    "complex": (1j, set()),
    "ragged": ([[1], [2, 3]], set()),
    "dict": ({}, {"mapping"}),
    "overflow": (10**400, set()),
    "vast int": (10**6000, set()),  # has no repr
    "nan": (math.nan, set()),
    "infinity": (math.inf, set()),
    "None": (None, {"None"}),
    "bool": (True, {"bool"}),
    "object": (Foreign(), set()),
    "empty list": ([], {"list", "mapping"}),
    "empty array": (np.zeros((0, 3)), {"list"}),
    "array of nan": (np.full(3, math.nan), set()),
    "bytes": (b"abc", set()),
}
# Numbers that may be right or wrong: only foreign exceptions and answers of nan are refused here.
ODD: dict[str, Any] = {
    "zero": 0,
    "one": 1,
    "negative": -1.0,
    "huge": 1e300,
    "tiny": 1e-300,
    "share": 0.5,
    "array": np.ones(3),
}


def kinds(annotation: Any) -> set[str]:
    """What an annotation lets in, in the words of ``BAD``."""
    found = set()
    for part in str(annotation).split(" | "):
        head = part.strip().split("[")[0]
        if head == "None":
            found.add("None")
        elif head == "bool":
            found.add("bool")
        elif head in ("Path", "PathLike", "os.PathLike"):
            found.add("path")
        elif head == "Mapping":
            found.add("mapping")
        elif head == "Names":  # of drawing: one name, several or none
            found |= {"None", "list"}
        elif head in ("Iterable", "Sequence", "list", "tuple"):
            found.add("list")
    return found
