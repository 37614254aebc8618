"""Whole files or none, and libraries that are asked for by name."""

from __future__ import annotations

import errno
import importlib
import itertools
import json
import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from kirigami.errors import GeometryError, KirigamiError
from kirigami.primitives.checks import require_path

_counter = itertools.count()


@contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A path to write to; its contents get to `path` when the block ends well and vanish when it fails.

    Under the name `path` there is the old file or the new one, never half of one. What is no plain file is written
    through and stays what it is: a symbolic link goes on pointing to the file behind it, a pipe or a terminal is fed,
    a file with further names (hard links) keeps them.

    Parameters
    ----------
    path : path
        The file wanted; missing folders are made.

    Yields
    ------
    Path
        An unfinished file with the same ending.

    Raises
    ------
    KirigamiError
        `path` is a folder, a disk or a pipe that nobody reads, or lies where nothing can be written, or the disk is
        full.

    Examples
    --------
    >>> from pathlib import Path
    >>> from kirigami.files import whole_file
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> with whole_file(folder / "curve.csv") as unfinished:
    ...     written = unfinished.write_text("x,y")
    >>> [entry.name for entry in folder.iterdir()]
    ['curve.csv']
    """
    target = require_path(path, "path", "a file", KirigamiError)
    unfinished: Path | None = None
    try:
        through = _written_through(target)
        home = Path(tempfile.gettempdir()) if through else Path(os.path.realpath(target)).parent
        home.mkdir(parents=True, exist_ok=True)
        # A short name, unlike any other of this or another process, with the ending that some writers go by.
        unfinished = home / f".{os.getpid()}-{next(_counter)}.part{target.suffix}"
        yield unfinished
        _hand_over(unfinished, target, through)
    except OSError as error:
        raise KirigamiError(f"cannot write {target}: {error.strerror or error}") from error
    finally:
        if unfinished is not None:
            with suppress(OSError):
                unfinished.unlink(missing_ok=True)


def make_folder(path: Path) -> None:
    """Make a folder to write to, with those it lies in.

    Parameters
    ----------
    path : Path
        The folder; it may be there already.

    Raises
    ------
    KirigamiError
        A file has its name, or it lies where nothing can be written.

    Examples
    --------
    >>> from pathlib import Path
    >>> from kirigami.files import make_folder
    >>> import tempfile
    >>> report = Path(tempfile.mkdtemp()) / "reports" / "first"
    >>> make_folder(report)
    >>> report.is_dir()
    True
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        inside = next((part for part in (path, *path.parents) if part.exists() and not part.is_dir()), None)
        why = f"{inside} is a file" if inside else error.strerror or str(error)
        raise KirigamiError(f"cannot make the folder {path}: {why}") from error


def _written_through(target: Path) -> bool:
    """Whether a path names something that must be fed instead of replaced; raises where it can be neither."""
    if target.is_dir():
        raise KirigamiError(f"{str(target)!r} is a folder: give the name of a file")
    try:
        found = os.stat(target)
    except FileNotFoundError:  # nothing there yet, or a link to nothing, behind which the file is made
        return False
    if stat.S_ISBLK(found.st_mode) or stat.S_ISSOCK(found.st_mode):
        raise KirigamiError(f"{target} is a disk or a socket: give the name of a file")
    if not os.access(target, os.W_OK):
        raise KirigamiError(f"cannot write {target}: it is write-protected")
    plain = stat.S_ISREG(found.st_mode)
    # What /dev/stdout and its like lead to is held open by others: replacing it would hide the contents from them.
    return not plain or found.st_nlink > 1 or os.path.abspath(target).startswith(("/dev/", "/proc/"))


def _hand_over(unfinished: Path, target: Path, through: bool) -> None:
    with open(unfinished, "r+b") as file:
        os.fsync(file.fileno())
    if not through:
        final = Path(os.path.realpath(target))
        if final.exists():
            shutil.copymode(final, unfinished)
        os.replace(unfinished, final)
        return
    fifo = stat.S_ISFIFO(os.stat(target).st_mode)
    try:
        handle = os.open(target, os.O_WRONLY | os.O_TRUNC | (os.O_NONBLOCK if fifo else 0))
    except OSError as error:
        if fifo and error.errno == errno.ENXIO:
            raise KirigamiError(f"{target} is a pipe that nobody reads: start its reader first") from None
        raise
    if fifo:
        os.set_blocking(handle, True)
    with open(handle, "wb") as there, open(unfinished, "rb") as here:
        shutil.copyfileobj(here, there)


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
    >>> from kirigami.files import library
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
