"""The architecture: a package imports packages on lower floors only, and itself; lazy and type-only imports count too.

The list of floors below is the architecture. A name handed to ``deferred("kirigami.io.table:to_csv")`` is no import: it
is a promise of what a method will call, held by ``test_deferred_names_exist``.
"""

import ast
import importlib
from pathlib import Path

import pytest

import kirigami

FLOORS = [
    {"words"},
    {"errors", "progress", "version", "moved"},
    {"primitives"},
    {"files", "units"},
    {"linalg", "sweep", "deferred", "scale"},
    {"geometry"},
    {"elements", "post", "drawing"},
    {"model", "effects"},
    {"system"},
    {"results"},
    {"analysis", "plot", "io"},
    {"lattice", "study"},
    {"design"},
    {"__init__"},
    {"cli"},
]
FLOOR = {package: floor for floor, packages in enumerate(FLOORS) for package in packages}
ROOT = Path(kirigami.__file__).parent
FILES = sorted(ROOT.rglob("*.py"))


def package_of(file):
    parts = file.relative_to(ROOT).parts
    return parts[0] if len(parts) > 1 else parts[0].removesuffix(".py")


def imported_packages(file):
    """Line and package of every import of this package's own, wherever in the file it stands."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}:{node.lineno}: relative import"
            names = [node.module]
            if node.module == "kirigami":
                names = [f"kirigami.{alias.name}" for alias in node.names]
        else:
            continue
        for name in names:
            first, *rest = name.split(".")
            if first == "kirigami":
                known = rest and (rest[0] in FLOOR)
                yield node.lineno, rest[0] if known else "__init__"


def test_every_package_has_a_floor():
    assert {package_of(file) for file in FILES} == set(FLOOR)


@pytest.mark.parametrize("file", FILES, ids=lambda file: str(file.relative_to(ROOT)))
def test_imports_go_down(file):
    own = package_of(file)
    if own == "__init__":
        return  # the table of public names knows everything
    up = [
        f"{file.relative_to(ROOT)}:{line} imports {package}"
        for line, package in imported_packages(file)
        if package != own and FLOOR[package] >= FLOOR[own]
    ]
    assert not up, up


def deferred_methods():
    for module in ("geometry.sheet", "model.model", "results.results"):
        for cls in vars(importlib.import_module(f"kirigami.{module}")).values():
            if isinstance(cls, type) and cls.__module__ == f"kirigami.{module}":
                for name, value in vars(cls).items():
                    if type(value).__name__ == "_Deferred":
                        yield cls, name


@pytest.mark.parametrize("cls, name", list(deferred_methods()))
def test_deferred_names_exist(cls, name):
    assert callable(getattr(cls, name)) and getattr(cls, name).__doc__
