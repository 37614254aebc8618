"""Routines of BLAS and LAPACK that let other threads run meanwhile.

SciPy's wrappers keep Python's lock while they compute, so that threads that call them gain nothing. Here the routines
that SciPy offers to Cython are called through ctypes, which lets go of the lock: the same libraries, the same numbers.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

from kirigami.primitives.kernel import Array

Routine = Callable[..., None]


@cache
def address(module: str, name: str) -> int:
    """Where a routine that SciPy offers to Cython begins, as ("cython_blas", "dgemm")."""
    import importlib

    capsule = importlib.import_module(f"scipy.linalg.{module}").__pyx_capi__[name]
    api = ctypes.pythonapi
    api.PyCapsule_GetName.restype, api.PyCapsule_GetName.argtypes = ctypes.c_char_p, [ctypes.py_object]
    api.PyCapsule_GetPointer.restype = ctypes.c_void_p
    api.PyCapsule_GetPointer.argtypes = [ctypes.py_object, ctypes.c_char_p]
    found: int = api.PyCapsule_GetPointer(capsule, api.PyCapsule_GetName(capsule))
    return found


@cache
def _routine(module: str, name: str) -> Routine:
    found: Routine = ctypes.CFUNCTYPE(None)(address(module, name))
    return found


def _whole(number: int) -> Any:
    return ctypes.byref(ctypes.c_int(number))


def _real(number: float) -> Any:
    return ctypes.byref(ctypes.c_double(number))


def _at(values: Array) -> Any:
    return ctypes.c_void_p(values.ctypes.data)


def _row(block: Array) -> Any:
    """Numbers from one row of a block to the next; it may be part of a larger one."""
    return _whole(block.strides[0] // block.itemsize)


def pack(square: Array, packed: Array) -> None:
    """The half that counts of a block (p, p), column by column, into an array (p (p + 1) / 2,)."""
    info, p = ctypes.c_int(0), len(square)
    _routine("cython_lapack", "dtrttp")(b"L", _whole(p), _at(square), _whole(p), _at(packed), ctypes.byref(info))


def unpack(packed: Array, square: Array) -> None:
    """The way back; the other half is left as it is."""
    info, p = ctypes.c_int(0), len(square)
    _routine("cython_lapack", "dtpttr")(b"L", _whole(p), _at(packed), _at(square), _whole(p), ctypes.byref(info))


def divide(pivot: Array, outer: Array) -> None:
    """L^-1 times a block (p, q), or some columns of one, in its place, with L in `pivot`."""
    p, q = outer.shape
    _routine("cython_blas", "dtrsm")(
        b"R", b"L", b"T", b"N", _whole(q), _whole(p), _real(1.0), _at(pivot), _whole(p), _at(outer), _row(outer)
    )


def take_off(outer: Array, kept: float, rest: Array) -> None:
    """`kept` times a block (q, q) less outer' outer, in its place; as `pivot` for the half that counts."""
    p, q = outer.shape
    _routine("cython_blas", "dsyrk")(
        b"L", b"N", _whole(q), _whole(p), _real(-1.0), _at(outer), _row(outer), _real(kept), _at(rest), _row(rest)
    )


def take_off_product(first: Array, second: Array, kept: float, rest: Array) -> None:
    """`kept` times a block (q, r) less first' second, in its place; `first` (p, q) lies in either order."""
    (p, q), r = first.shape, second.shape[1]
    turned, row = (b"N", _whole(p)) if first.flags.f_contiguous else (b"T", _row(first))
    _routine("cython_blas", "dgemm")(
        b"N", turned, _whole(r), _whole(q), _whole(p), _real(-1.0), _at(second), _row(second), _at(first), row,
        _real(kept), _at(rest), _row(rest),
    )  # fmt: skip


def eliminate(pivot: Array, outer: Array, kept: float, rest: Array, each: Callable[..., Any]) -> None:
    """:func:`divide` and :func:`take_off` in two halves, which `each`, a map, may do side by side.

    The halves are the same whoever does them, and so is what comes out, bit by bit. The block that is left over is
    halved into two triangles and the square between them.
    """
    half = outer.shape[1] // 2
    one, two = outer[:, :half], outer[:, half:]

    def triangles() -> None:
        take_off(one, kept, rest[:half, :half])
        take_off(two, kept, rest[half:, half:])

    def square() -> None:
        take_off_product(one, two, kept, rest[:half, half:])

    list(each(divide, (pivot, pivot), (one, two)))
    list(each(lambda part: part(), (square, triangles)))
