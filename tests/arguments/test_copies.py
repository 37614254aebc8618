"""Whatever a model holds is copied whole: studies and other rungs work on copies."""

from __future__ import annotations

import copy
import inspect
import pickle
from typing import Any

import numpy as np
import pytest
from public_calls import CALLS

import kirigami as kg

PARTS = [
    name for name in CALLS
    if inspect.isclass(getattr(kg, name, None)) and issubclass(getattr(kg, name), kg.ModelObject)
]  # fmt: skip


def parts_of(item: Any) -> dict[str, Any]:
    names = {name for cls in type(item).__mro__ for name in getattr(cls, "__slots__", ())}
    names |= set(getattr(item, "__dict__", ()))
    return {name: getattr(item, name) for name in names if hasattr(item, name)}


@pytest.mark.parametrize("name", PARTS)
def test_a_copy_has_all_that_the_original_has(name: str) -> None:
    function, given = CALLS[name]()
    item = function(*given.get("*", ()), **{key: value for key, value in given.items() if not key.startswith("*")})
    for twin in (copy.copy(item), copy.deepcopy(item), pickle.loads(pickle.dumps(item))):
        before, after = parts_of(item), parts_of(twin)
        assert set(after) == set(before)
        for key, value in before.items():
            if isinstance(value, (int, float, str, np.ndarray)) or value is None:
                np.testing.assert_array_equal(after[key], value)
        assert repr(twin) == repr(item)
