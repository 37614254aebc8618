"""What the in-plane tests share: examples as modules, nearest vertices."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import kirigami as kg

ROOT = Path(__file__).parents[2]


def script(folder: str, name: str) -> Any:
    """An example or tutorial as a module."""
    specification = importlib.util.spec_from_file_location(name, ROOT / folder / f"{name}.py")
    assert specification is not None and specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def nearest(points: NDArray[np.float64], place: Any) -> int:
    return int(np.argmin(np.linalg.norm(points[:, :2] - np.asarray(place)[:2], axis=1)))


def node_at(model: kg.Model, place: Any) -> kg.Node:
    return model.nodes[nearest(model.positions(), place)]
