"""Tables of a parameter study: a log that only ever grows, and the tidy table that is made from it."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import AnalysisError, ModelError, nearest_name
from kirigami.files import whole_file
from kirigami.primitives.checks import require_instance, require_items, require_path, require_text
from kirigami.words import counted

RESERVED = ("design", "status", "error", "seconds", "version")
Row = dict[str, Any]


class SweepTable:
    """What a sweep found: one row for each design, in the order of the designs.

    Columns are ``design`` (its number), the parameters, ``seed``, what the function returned, ``status`` ("done",
    "failed" or "missing"), ``error``, ``seconds`` and ``version`` (of this package).

    Attributes
    ----------
    rows : list of dict
        The rows; a cell without a value is None.
    columns : list of str
        The names of the columns.

    Examples
    --------
    >>> import kirigami as kg
    >>> table = kg.SweepTable([{"design": 0, "status": "done", "k": 2.0}, {"design": 1, "status": "failed", "k": None}])
    >>> table.done["k"].tolist(), len(table.failed)
    ([2.0], 1)
    >>> table["k"]
    Traceback (most recent call last):
    ...
    kirigami.errors.ModelError: column 'k' has no value in 1 of 2 rows, the first of design 1: take .done first
    """

    def __init__(self, rows: Sequence[Row], columns: Sequence[str] | None = None) -> None:
        owner = "SweepTable"
        self.rows = [require_instance(row, dict, "rows", owner) for row in require_items(rows, "rows", owner)]
        first = self.rows[0] if self.rows else {}
        named = list(first) if columns is None else require_items(columns, "columns", owner)
        self.columns = [require_text(name, "columns", "SweepTable") for name in named]

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> SweepTable:
        """The table of a sweep, finished or not, from the log that it writes.

        Parameters
        ----------
        path : path
            The path given to the sweep, with or without an ending.

        Raises
        ------
        AnalysisError
            There is no log, or it is damaged.
        """
        header, records, _ = read_log(log_path(path))
        return make_table(header, records)

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows)

    def __getitem__(self, name: str) -> NDArray[Any]:
        """One column as an array."""
        if name not in self.columns:
            near = nearest_name(str(name), self.columns)
            hint = f": did you mean {near!r}?" if near else f"; there are {', '.join(self.columns)}"
            raise ModelError(f"the table has no column {name!r}{hint}")
        empty = [row for row in self.rows if row.get(name) is None]
        if empty:
            raise ModelError(
                f"column {name!r} has no value in {len(empty)} of {counted(len(self.rows), 'row')}, the first of "
                f"design {empty[0].get('design')}: take .done first"
            )
        return np.array([row[name] for row in self.rows])

    def _with_status(self, status: str) -> SweepTable:
        return SweepTable([row for row in self.rows if row.get("status") == status], self.columns)

    @property
    def done(self) -> SweepTable:
        """The rows of the designs that went well."""
        return self._with_status("done")

    @property
    def failed(self) -> SweepTable:
        """The rows of the designs whose function raised an error, or that ended their process."""
        return self._with_status("failed")

    @property
    def missing(self) -> SweepTable:
        """The rows of the designs that have not been computed yet."""
        return self._with_status("missing")

    def summary(self) -> str:
        """How many designs went well, the seconds they took, and each failure in a line, as text."""
        seconds = [row["seconds"] for row in self.rows if row.get("seconds") is not None]
        counts = f"{len(self.done)} done, {len(self.failed)} failed, {len(self.missing)} missing"
        lines = [f"{counted(len(self), 'design')}: {counts}"]
        if seconds:
            lines[0] += f"; {sum(seconds):.1f} s of computing, at most {max(seconds):.1f} s for a design"
        lines += [f"design {row.get('design')} failed: {row.get('error') or 'no reason told'}" for row in self.failed]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"<SweepTable: {self.summary().splitlines()[0]}>"

    def write(self, path: str | os.PathLike[str]) -> list[Path]:
        """Write the table as CSV, and as Parquet where pyarrow is installed; never a partial file.

        Parameters
        ----------
        path : path
            Where to; an ending .csv or .parquet is left out and put on again.

        Returns
        -------
        list of Path
            The files.
        """
        target = log_path(path).with_suffix(".csv")
        with whole_file(target) as unfinished, open(unfinished, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(self.columns)
            for row in self.rows:
                writer.writerow("" if row.get(name) is None else row[name] for name in self.columns)
        try:
            import pyarrow  # type: ignore[import-not-found,import-untyped,unused-ignore]
            import pyarrow.parquet  # type: ignore[import-not-found,import-untyped,unused-ignore]
        except ImportError:
            return [target]
        other = target.with_suffix(".parquet")
        with whole_file(other) as unfinished:
            cells = {name: _arrow(pyarrow, [row.get(name) for row in self.rows]) for name in self.columns}
            pyarrow.parquet.write_table(pyarrow.table(cells), unfinished)
        return [target, other]


def _arrow(pyarrow: Any, cells: list[Any]) -> Any:
    """A column for Parquet, which knows one kind of value in each: numbers among words become words."""
    try:
        return pyarrow.array(cells)
    except (pyarrow.ArrowException, OverflowError):
        return pyarrow.array([None if cell is None else str(cell) for cell in cells])


class SweepLog:
    """The log of a sweep, open for more: a line of JSON that describes the sweep, then one for each finished design.

    Lines are written whole and forced to the disk, and never changed. A last line that an interruption cut off is
    removed. One process at a time can hold the log, where the system can tell (not on Windows).
    """

    def __init__(self, path: Path, header: Row) -> None:
        self.path, self.header = path, header
        self.repaired = False
        self.records: dict[int, Row] = {}
        self._file: Any = None

    def __enter__(self) -> SweepLog:
        if self.path.exists() and not self.path.is_file():
            raise AnalysisError(f"{self.path} is no plain file: the log of a sweep is read back, so it must be one")
        if not self.path.exists():
            with whole_file(self.path) as unfinished:
                unfinished.write_text(json.dumps(self.header) + "\n", encoding="utf-8")
        try:
            self._file = open(self.path, "r+b", buffering=0)
        except OSError as error:
            raise AnalysisError(f"cannot write {self.path}: {error.strerror or error}") from error
        try:
            self._lock()
            found, self.records, length = read_log(self.path)
            check_same(self.path, found, self.header)
            self.header = found
            self.repaired = length < self._file.seek(0, os.SEEK_END)
            self._file.truncate(length)
        except BaseException:
            self._file.close()
            raise
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._file.close()

    def _lock(self) -> None:
        try:
            import fcntl
        except ImportError:
            return
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise AnalysisError(
                f"{self.path} is in use by another process that runs this sweep: wait for it or stop it (a script that "
                "runs a sweep must do so under `if __name__ == '__main__':`, or its workers run the sweep again)"
            ) from None
        except OSError:  # a file system without locks
            return

    def append(self, record: Row) -> None:
        """Add the record of one design, on the disk when this returns."""
        line = json.dumps(record).encode() + b"\n"
        try:
            self._file.seek(0, os.SEEK_END)
            written = self._file.write(line)
            os.fsync(self._file.fileno())
        except OSError as error:
            raise AnalysisError(f"cannot write {self.path}: {error.strerror or error}") from error
        if written < len(line):
            raise AnalysisError(f"cannot write {self.path}: the disk is full")
        self.records[record["design"]] = record

    def table(self) -> SweepTable:
        """The table of what is in the log."""
        return make_table(self.header, self.records)


def log_path(path: str | os.PathLike[str]) -> Path:
    """The path of the log that goes with a table."""
    stem = require_path(path, "path", "Sweep")
    if stem.suffix in (".csv", ".jsonl", ".parquet"):
        stem = stem.with_suffix("")
    if not stem.name:
        raise ModelError(f"a sweep needs the name of a file to write to, got {str(path)!r}")
    return stem.with_name(stem.name + ".jsonl")


def read_log(path: Path) -> tuple[Row, dict[int, Row], int]:
    """Header, records by number of the design, and the number of bytes in whole lines."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise AnalysisError(f"cannot read the log of a sweep at {path}: {error.strerror or error}") from error
    *lines, rest = content.split(b"\n")
    rows: list[Row] = []
    for number, line in enumerate(lines, start=1):
        try:
            row = json.loads(line)
        except ValueError:
            row = None
        if not isinstance(row, dict) or not _makes_sense(row, number, rows):
            if number == 1:
                break
            raise AnalysisError(
                f"{path} is damaged: line {number} is not the record of a design. Delete that line to compute its "
                "design again, or the file to begin anew"
            )
        rows.append(row)
    if not rows:
        raise AnalysisError(f"{path} is not the log of a sweep: give another path, or delete the file")
    return rows[0], {row["design"]: row for row in rows[1:]}, len(content) - len(rest)


def _makes_sense(row: Row, number: int, rows: list[Row]) -> bool:
    if number == 1:
        return isinstance(row.get("designs"), list) and isinstance(row.get("function"), str) and "seeds" in row
    design = row.get("design")
    return (
        isinstance(design, int) and 0 <= design < len(rows[0]["designs"])
        and row.get("status") in ("done", "failed") and isinstance(row.get("values"), dict)
    )  # fmt: skip


def check_same(path: Path, found: Row, wanted: Row) -> None:
    """Refuse to go on with the log of another sweep."""
    advice = "give another path, or delete the file to begin anew"
    if found["function"] != wanted["function"]:
        raise AnalysisError(f"{path} belongs to {found['function']}, not to {wanted['function']}: {advice}")
    old, new = found["designs"], wanted["designs"]
    if len(old) != len(new):
        raise AnalysisError(f"{path} holds a sweep of {counted(len(old), 'design')}, not of {len(new)}: {advice}")
    for number, (one, other) in enumerate(zip(old, new)):
        if one != other:
            name = next(name for name in {**one, **other} if one.get(name) != other.get(name))
            raise AnalysisError(
                f"{path} holds other designs: design {number} has {name} = {one.get(name)!r} there and "
                f"{other.get(name)!r} here: {advice}"
            )
    if found["seeds"] != wanted["seeds"]:
        raise AnalysisError(f"{path} holds a sweep with another seed: {advice}")


def make_table(header: Row, records: Mapping[int, Row]) -> SweepTable:
    """Rows in the order of the designs; a design without a record is missing."""
    outcome: dict[str, None] = {}
    for design in sorted(records):
        outcome.update(dict.fromkeys(records[design]["values"]))
    blank: Row = {"values": {}, "status": "missing", "error": None, "seconds": None, "version": None}
    rows: list[Row] = []
    for number, (parameters, seed) in enumerate(zip(header["designs"], header["seeds"])):
        record = records.get(number, blank)
        values = {name: record["values"].get(name) for name in outcome}
        row = {"design": number, **parameters, "seed": seed, **values}
        rows.append(row | {name: record[name] for name in RESERVED[1:]})
    return SweepTable(rows, list(rows[0]) if rows else ["design", "seed", *RESERVED[1:]])
