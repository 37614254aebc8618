"""Checks of what users hand in: each names the argument and its owner, and says what would be right.

Everything public checks its arguments where they arrive, with these functions; what they let through is a plain
Python or numpy value that the rest of the package may trust. ``error`` is the class to raise: ModelError, unless the
owner belongs to geometry or is an analysis.
"""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import KirigamiError, ModelError, nearest_name

T = TypeVar("T")
Error = type[KirigamiError]
Shape = tuple[int | None, ...]  # None stands for any number of rows, at least one

LARGEST = 1e100  # squares and cubes of what is larger, or smaller than its inverse, are no numbers
_NO_NUMBERS = (bool, np.bool_, str, bytes, bytearray, complex, np.complexfloating)


def shown(value: Any) -> str:
    """`value` as a message shows it: one line of at most some 80 characters, whatever it is."""
    try:
        text = " ".join(repr(value).split())
    except Exception:  # a foreign object may fail in any way, and the largest integers have no repr
        return f"an object of type {type(value).__name__}"
    return text if len(text) <= 80 else f"{text[:60]} ... {text[-15:]}"


def require_finite(value: Any, name: str, owner: str, error: Error = ModelError) -> float:
    """`value` as a finite float: neither text nor a truth value nor a complex number."""
    if type(value) is float and -LARGEST < value < LARGEST:
        return value
    try:
        if isinstance(value, _NO_NUMBERS) or (
            isinstance(value, np.ndarray) and (value.ndim or value.dtype.kind in "bcSU")
        ):
            raise TypeError
        number = float(value)
    except OverflowError:
        number = math.inf
    except (TypeError, ValueError):
        raise error(f"{owner}: {name} must be a number, got {shown(value)}") from None
    if not math.isfinite(number):
        raise error(f"{owner}: {name} must be finite, got {shown(value)}")
    if abs(number) > LARGEST:
        raise error(f"{owner}: {name} must be less than {LARGEST:g}, got {shown(value)}")
    return number


def require_positive(value: Any, name: str, owner: str, error: Error = ModelError) -> float:
    """`value` as a positive float."""
    number = require_finite(value, name, owner, error)
    if number <= 0:
        raise error(f"{owner}: {name} must be positive, got {number}")
    if number < 1 / LARGEST:
        raise error(f"{owner}: {name} must be more than {1 / LARGEST:g}, got {number}")
    return number


def require_not_negative(value: Any, name: str, owner: str, error: Error = ModelError) -> float:
    """`value` as a float of zero or more."""
    number = require_finite(value, name, owner, error)
    if number < 0:
        raise error(f"{owner}: {name} must not be negative, got {number}")
    return number


def require_between(value: Any, low: float, high: float, name: str, owner: str, error: Error = ModelError) -> float:
    """`value` as a float strictly between `low` and `high`."""
    number = require_finite(value, name, owner, error)
    if not low < number < high:
        raise error(f"{owner}: {name} must lie between {low:g} and {high:g}, got {number}")
    return number


def require_whole(value: Any, name: str, owner: str, least: int | None = None, error: Error = ModelError) -> int:
    """`value` as an int, not below `least`; a truth value and a float are none."""
    kind = "a whole number" if least is None else f"a whole number of at least {least}"
    try:
        if isinstance(value, (bool, np.bool_)) or (isinstance(value, np.ndarray) and value.ndim):
            raise TypeError
        number = operator.index(value)
    except TypeError:
        number = None
    if number is None or abs(number) >= 2**63 or (least is not None and number < least):
        raise error(f"{owner}: {name} must be {kind}, got {shown(value)}")
    return number


def require_boolean(value: Any, name: str, owner: str, error: Error = ModelError) -> bool:
    """`value` as True or False, which nothing else stands for: a text like "no" would be true."""
    if not isinstance(value, (bool, np.bool_)):
        raise error(f"{owner}: {name} must be True or False, got {shown(value)}")
    return bool(value)


def require_array(
    value: Any, *shapes: Shape, name: str, owner: str, error: Error = ModelError, finite: bool = True
) -> NDArray[np.float64]:
    """`value` as a new array of finite numbers in one of the `shapes`; without shapes, any that is not empty."""
    wanted = " or ".join(_shape_in_words(shape) for shape in shapes)
    kind = f"numbers of shape {wanted}" if wanted else "numbers"
    array = _as_array(value, "iuf", float)
    if array is None:
        raise error(f"{owner}: {name} must be {kind}, got {shown(value)}")
    _require_shape(array, shapes, kind, name, owner, error)
    if finite and not np.isfinite(array).all():
        bad = np.argwhere(~np.isfinite(array))[0].tolist()
        place = f" at {bad}" if bad else ""
        raise error(f"{owner}: {name} must be finite, got {array[tuple(bad)]}{place}")
    if finite and np.abs(array).max() > LARGEST:
        raise error(f"{owner}: {name} must be less than {LARGEST:g}, got {np.abs(array).max():g}")
    return array


def require_whole_array(
    value: Any, *shapes: Shape, name: str, owner: str, error: Error = ModelError
) -> NDArray[np.int64]:
    """`value` as a new array of whole numbers in one of the `shapes`."""
    wanted = " or ".join(_shape_in_words(shape) for shape in shapes)
    kind = f"whole numbers of shape {wanted}" if wanted else "whole numbers"
    array = _as_array(value, "iu", np.int64)
    if array is None:
        raise error(f"{owner}: {name} must be {kind}, got {shown(value)}")
    _require_shape(array, shapes, kind, name, owner, error)
    return array


def require_axis(value: Any, owner: str, name: str = "axis", axes: str = "xyz") -> str:
    """One axis letter."""
    if not isinstance(value, str) or len(value) != 1 or value not in axes:
        raise ModelError(f"{owner}: {name} must be one of {', '.join(map(repr, axes))}, got {shown(value)}")
    return value


def require_axes(value: Any, owner: str, name: str = "dofs") -> str:
    """Axis letters, each once."""
    if not isinstance(value, str) or not value or set(value) - set("xyz") or len(set(value)) != len(value):
        raise ModelError(f"{owner}: {name} must be letters out of 'xyz', each once, got {shown(value)}")
    return value


def require_choice(
    value: Any, choices: Iterable[str], name: str, owner: str, error: Error = ModelError, or_else: str = ""
) -> str:
    """One of several names, with the nearest one in the message."""
    known = [*choices]
    if not isinstance(value, str) or value not in known:
        near = nearest_name(value, known) if isinstance(value, str) else None
        hint = f"; did you mean {near!r}?" if near else ""
        other = f", or {or_else}" if or_else else ""
        raise error(f"{owner}: {name} must be one of {', '.join(map(repr, known))}{other}, got {shown(value)}{hint}")
    return value


def require_text(value: Any, name: str, owner: str, error: Error = ModelError) -> str:
    """`value` as text."""
    if not isinstance(value, str):
        raise error(f"{owner}: {name} must be text, got {shown(value)}")
    return value


def require_instance(
    value: Any, kind: type[T] | tuple[type[T], ...], name: str, owner: str, remedy: str = "", error: Error = ModelError
) -> T:
    """`value` as an object of one of the classes `kind`; `remedy` says where such an object comes from."""
    if not isinstance(value, kind):
        kinds = kind if isinstance(kind, tuple) else (kind,)
        names = " or ".join(f"a {one.__name__}" for one in kinds)
        raise error(f"{owner}: {name} must be {names}, got {shown(value)}" + (f": {remedy}" if remedy else ""))
    return value


def require_callable(value: Any, name: str, owner: str, error: Error = ModelError) -> Callable[..., Any]:
    """`value` as something that can be called."""
    if not callable(value):
        raise error(f"{owner}: {name} must be a function, got {shown(value)}")
    function: Callable[..., Any] = value
    return function


def require_executor(value: Any, owner: str) -> Any:
    """`value` as something that runs functions elsewhere, or None."""
    if value is not None and not hasattr(value, "submit"):
        raise ModelError(
            f"{owner}: executor must be a concurrent.futures.Executor or a Dask client, got {shown(value)}"
        )
    return value


def require_mapping(value: Any, name: str, owner: str, error: Error = ModelError) -> Mapping[str, Any]:
    """`value` as a mapping whose keys are text."""
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise error(f"{owner}: {name} must map names to values, got {shown(value)}")
    return value


def require_items(value: Any, name: str, owner: str, error: Error = ModelError) -> list[Any]:
    """What `value` lists, as a list; text and a mapping are no lists."""
    try:
        if isinstance(value, (str, bytes, Mapping)):
            raise TypeError
        return list(value)
    except TypeError:
        raise error(f"{owner}: {name} must be a list, got {shown(value)}") from None


def require_path(value: Any, name: str, owner: str, error: Error = ModelError) -> Path:
    """`value` as a path of a file or folder."""
    if not isinstance(value, (str, os.PathLike)) or not os.fspath(value) or "\0" in os.fsdecode(value):
        raise error(f"{owner}: {name} must be the path, with the name of a file or folder, got {shown(value)}")
    return Path(os.fsdecode(value))


def _as_array(value: Any, kinds: str, dtype: type) -> NDArray[Any] | None:
    """`value` as a new array of numbers, None where it holds anything else, is ragged or no number fits."""
    try:
        array = np.array(value)
        if array.dtype.kind == "O":  # whole numbers beyond 64 bits, fractions and the like; never text or truth values
            if any(isinstance(item, _NO_NUMBERS) or item is None for item in array.flat):
                return None
            if dtype is not float:
                return None
        elif array.size and array.dtype.kind not in kinds:
            return None
        return array.astype(dtype)
    except Exception:  # an object may offer itself as an array and fail in any way
        return None


def _require_shape(
    array: NDArray[Any], shapes: tuple[Shape, ...], kind: str, name: str, owner: str, error: Error
) -> None:
    if not array.size and array.ndim:
        raise error(f"{owner}: {name} must be {kind}, and is empty")
    fits = [
        len(shape) == array.ndim and all(one is None or one == size for one, size in zip(shape, array.shape))
        for shape in shapes
    ]
    if shapes and not any(fits):
        raise error(f"{owner}: {name} must be {kind}, got shape {_shape_in_words(array.shape)}")


def _shape_in_words(shape: Shape) -> str:
    sizes = ["n" if size is None else str(size) for size in shape]
    return f"({', '.join(sizes)}{',' if len(sizes) == 1 else ''})"
