"""Whole files or none, and libraries that are asked for by name."""

from __future__ import annotations

import importlib
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from kirigami.errors import GeometryError, KirigamiError


@contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A path to write to; it takes the name `path` when the block ends well and vanishes when it fails.

    Parameters
    ----------
    path : path
        The file wanted; missing folders are made.

    Yields
    ------
    Path
        An unfinished neighbour of `path` with the same ending.

    Raises
    ------
    KirigamiError
        `path` is a folder, or lies where nothing can be written.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> with whole_file(folder / "curve.csv") as unfinished:
    ...     written = unfinished.write_text("x,y")
    >>> [entry.name for entry in folder.iterdir()]
    ['curve.csv']
    """
    target = Path(path)
    if target.is_dir():
        raise KirigamiError(f"{target} is a folder: give the name of a file")
    unfinished = target.with_name(f".{target.stem}.{os.getpid()}.part{target.suffix}")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        yield unfinished
        os.replace(unfinished, target)
    except OSError as error:
        raise KirigamiError(f"cannot write {target}: {error.strerror or error}") from error
    finally:
        unfinished.unlink(missing_ok=True) if unfinished.parent.is_dir() else None


def library(name: str, purpose: str, extra: str = "io") -> Any:
    """Import an optional library, or say what it is needed for and how to get it.

    Parameters
    ----------
    name : str
        Name of the module.
    purpose : str
        What it is needed for, as the start of a sentence: "reading DXF drawings".
    extra : str
        The extra of this package that brings it.

    Raises
    ------
    KirigamiError
        The library is not installed.

    Examples
    --------
    >>> library("json", "nothing at all").dumps([1])
    '[1]'
    """
    try:
        return importlib.import_module(name)
    except ImportError as error:
        package = name.partition(".")[0]
        raise KirigamiError(
            f'{purpose} needs {package}: pip install {package}, or pip install "kirigami-mechanics[{extra}]" ({error})'
        ) from error


def read_json(path: Path, kind: str) -> Any:
    """The contents of a JSON file, or a GeometryError that names file and line."""
    if not path.is_file():
        raise GeometryError(f"there is no file {path}")
    try:
        text = path.read_text(encoding="utf-8-sig")
        if not text.strip():
            raise GeometryError(f"{path} is empty")
        return json.loads(text)
    except json.JSONDecodeError as error:
        raise GeometryError(f"{path} is no {kind} file: {error.msg} in line {error.lineno}") from None
    except UnicodeDecodeError:
        raise GeometryError(f"{path} is no {kind} file: it is not text") from None
