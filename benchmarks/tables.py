"""Tables of benchmarks in CSV files: each row is kept as soon as it is made, and is the memory of what is done."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any


def read(table: Path) -> list[dict[str, str]]:
    """Rows done so far; none where there is no file."""
    if not table.exists():
        return []
    with table.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def add(table: Path, row: dict[str, Any]) -> None:
    """Append a row; the first one brings the head."""
    new = not table.exists()
    table.parent.mkdir(exist_ok=True)
    with table.open("a", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(row))
        if new:
            writer.writeheader()
        writer.writerow(row)
