"""Modules of version 0.1 under their old names: an import of one warns and names the new home."""

from __future__ import annotations

import importlib
import sys
import warnings
from collections.abc import Callable, Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

# Old module, and where its names are now, all below ``kirigami.``.
MOVED: dict[str, tuple[str, ...]] = {
    "assembly": ("system.assembly",),
    "clock": ("system.clock",),
    "compiled": ("elements.compiled",),
    "compiled_loops": ("elements.compiled_loops",),
    "constraints": ("model.constraints", "primitives.node"),
    "effective": ("study.effective",),
    "framework": ("lattice.framework",),
    "kernel": ("primitives.kernel", "primitives.check_kernel"),
    "loads": ("model.loads",),
    "mechanism": ("system.supports", "primitives.rigid"),
    "objects": ("primitives.parts", "primitives.node", "primitives.material", "primitives.checks"),
    "periodic": ("lattice.periodic",),
    "plot_lattice": ("lattice.picture",),
    "recorders": ("progress",),
    "sampling": ("sweep.sampling",),
    "sheet_model": ("model.from_mesh",),
    "step": ("results.step",),
    "storage": ("results.archive",),
    "sweep_table": ("sweep.table",),
    "sweep_workers": ("sweep.workers",),
    "unknowns": ("system.unknowns",),
    "analysis.branch": ("analysis.path.branching",),
    "analysis.checkpoint": ("analysis.path.checkpoint",),
    "analysis.control": ("analysis.path.controls",),
    "analysis.descent": ("analysis.path.descent",),
    "analysis.events": ("analysis.path.events", "analysis.path.release", "analysis.modes"),
    "analysis.increments": ("analysis.path.increments",),
    "analysis.newton": ("analysis.path.newton",),
    "analysis.state": ("analysis.path.points",),
    "analysis.walk": ("analysis.path.follow",),
    "io.drawing": ("drawing.drawing",),
    "io.dxf": ("drawing.dxf", "drawing.drawing"),
    "io.fields": ("results.fields",),
    "io.files": ("files",),
    "io.fold": ("drawing.fold",),
    "io.geojson": ("drawing.geojson", "files"),
    "io.svg": ("drawing.svg",),
    "post.stress": ("results.stress",),
    "study.picture": ("study.imperfection_picture",),
}

# Public modules, which are the same module under their old name too.
PUBLIC = {"bloch": "lattice.bloch", "stiffness": "elements.stiffness", "tilings": "lattice.tilings"}


def forward(old: str, homes: Sequence[str], stacklevel: int = 2) -> Callable[[str], Any]:
    """A module's ``__getattr__`` that finds names where they have moved to, and says so."""

    def find(name: str) -> Any:
        if not name.startswith("__"):
            for home in homes:
                module = importlib.import_module(f"kirigami.{home}")
                if hasattr(module, name):
                    warnings.warn(
                        f"kirigami.{old}.{name} has moved to kirigami.{home}.{name}; use the public names of kirigami",
                        DeprecationWarning,
                        stacklevel=stacklevel,
                    )
                    return getattr(module, name)
        raise AttributeError(f"module 'kirigami.{old}' has no attribute {name!r}")

    return find


class _OldModules(MetaPathFinder, Loader):
    """Finds the old modules after everything else has failed to."""

    def find_spec(self, fullname: str, path: Any, target: Any = None) -> ModuleSpec | None:
        old = fullname.removeprefix("kirigami.")
        known = old != fullname and (old in MOVED or old in PUBLIC)
        return ModuleSpec(fullname, self) if known else None

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        home = PUBLIC.get(spec.name.removeprefix("kirigami."))
        return importlib.import_module(f"kirigami.{home}") if home else None

    def exec_module(self, module: ModuleType) -> None:
        old = module.__name__.removeprefix("kirigami.")
        if old in MOVED:
            module.__getattr__ = forward(old, MOVED[old])  # type: ignore[method-assign]


def install() -> None:
    """Make the old names importable."""
    if not any(isinstance(finder, _OldModules) for finder in sys.meta_path):
        sys.meta_path.append(_OldModules())
