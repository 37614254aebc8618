"""The names that scripts are written against: they exist, take what they promise to take, and explain themselves."""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

import kirigami as kg

# An ellipsis stands for a default that may be anything.
SIGNATURES = {
    "Material": "(E, nu=1 / 3, density=None)",
    "Node": "(x, y, z=0.0, *, name=None)",
    "Bar": "(i, j, EA, *, rest_length=None, strain='green', law='linear', mass_per_length=0.0)",
    "BendHinge": "(i, j, k, l, stiffness, *, rest_angle=None)",
    "TorsionSpring3": "(i, j, k, stiffness, *, rest_angle=None)",
    "Fix": "(nodes, dofs='xyz', clamp=False)",
    "Prescribe": "(nodes, x=None, y=None, z=None, clamp=False)",
    "Tie": "(followers, leaders, dofs='xyz')",
    "Symmetry": "(nodes, normal='x')",
    "NodalLoad": "(nodes, force, constant=False)",
    "Calibration": "(F_s, c)",
    "Model": "(dim=3, name='')",
    "Model.add": "(self, *objects)",
    "Model.select": "(self, box=None, where=None, boundary=None, index=None)",
    "Model.perturb": "(self, shape, amplitude=None)",
    "Model.plot": "(self, ax=None)",
    "Model.from_mesh": "(mesh, thickness=None, material=None, stiffness='plate', dim=3)",
    "Sheet": "(outline, cuts=(), thickness=..., material=..., folds=())",
    "Fold": "(line, angle=0.0, stiffness=None)",
    "Sheet.mesh": "(self, max_edge=None, cut_edge=None, min_angle=28)",
    "TriMesh": "(nodes, triangles, sets=None)",
    "LinearStatic": "(model)",
    "LinearStatic.run": "(self)",
    "Eigen": "(model, n=6, about=None, mass='unit')",
    "Eigen.run": "(self)",
    "Mass": "(nodes, mass)",
    "Dynamics": "(model, end, step, damping=0.0, scheme='conserving', start=None)",
    "Dynamics.run": "(self, progress=False, recorders=(), on_failure='raise')",
    "LoadControl": "(model, to=1.0, targets=None, step=None, tol=1e-8)",
    "LoadControl.run": "(self, progress=False, recorders=(), on_failure='raise')",
    "DisplacementControl": "(model, to=1.0, control=None, targets=None, step=None, tol=1e-8, start=None)",
    "DisplacementControl.run": "(self, progress=False, recorders=(), on_failure='raise')",
    "ArcLength": "(model, step, stop=None, max_steps=500, tol=1e-8, start=None)",
    "ArcLength.run": "(self, progress=False, recorders=(), on_failure='raise')",
    "Results.position": "(self, nodes=...)",
    "Results.reaction": "(self, nodes, axis=...)",
    "Results.summary": "(self)",
    "Results.open_area": "(self, union=False)",
    "Results.plot": "(self, step=-1, ax=None)",
    "Results.animate": "(self, path)",
    "Results.save": "(self, path)",
    "Results.to_vtk": "(self, folder)",
    "Results.to_xarray": "(self)",
    "load": "(path)",
    "stretch": "(sheet, strain=0.2, direction='y', accuracy='standard')",
    "check_kernel": "(kernel, x)",
    "Kernel.evaluate": "(self, x, lam=..., need=...)",
    "Kernel.commit": "(self, x)",
    "Kernel.revert": "(self)",
    "Kernel.update": "(self, x)",
}
UNSTATED = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)


def resolve(name: str) -> Any:
    found: Any = kg
    for part in name.split("."):
        found = getattr(found, part)
    return found


def stated(signature: str) -> list[inspect.Parameter]:
    space: dict[str, Any] = {}
    exec(f"def example{signature}: ...", space)
    return list(inspect.signature(space["example"]).parameters.values())


@pytest.mark.parametrize("name", SIGNATURES)
def test_signature(name: str) -> None:
    """The stated parameters come first, in order, by kind and default; others may follow if they can be left out."""
    actual = list(inspect.signature(resolve(name)).parameters.values())
    wanted = stated(SIGNATURES[name])
    if wanted[0].name == "self":  # a deferred method shows the function's own word for the object
        actual, wanted = actual[1:], wanted[1:]
    positional = [p for p in wanted if p.kind is inspect.Parameter.POSITIONAL_OR_KEYWORD]
    assert [p.name for p in actual[: len(positional)]] == [p.name for p in positional]
    by_name = {p.name: p for p in actual}
    for parameter in wanted:
        if parameter.kind in UNSTATED:
            assert any(p.kind is parameter.kind for p in actual), parameter
            continue
        found = by_name[parameter.name]
        assert found.kind is parameter.kind
        if parameter.default is not ...:
            assert found.default == parameter.default, parameter
    names = {p.name for p in wanted}
    for extra in actual:
        assert extra.name in names or extra.kind in UNSTATED or extra.default is not extra.empty, extra


@pytest.mark.parametrize("name", kg.__all__)
def test_every_name_explains_itself_and_shows_an_example(name: str) -> None:
    found = getattr(kg, name)
    if name == "__version__":
        assert found.count(".") == 2
        return
    assert found.__doc__ and found.__doc__.strip(), f"{name} has no docstring"
    if inspect.isclass(found) or inspect.isfunction(found):
        assert ">>> " in found.__doc__, f"the docstring of {name} has no example"
        # An inherited docstring describes another class.
        assert inspect.isfunction(found) or "__doc__" in vars(found), name


@pytest.mark.parametrize("name", [name for name in kg.__all__ if inspect.isclass(getattr(kg, name))])
def test_public_methods_have_docstrings(name: str) -> None:
    cls = getattr(kg, name)
    bare = [
        method
        for method, found in inspect.getmembers(cls)
        if not method.startswith("_")
        and (inspect.isfunction(found) or inspect.ismethod(found) or isinstance(found, property))
        and not inspect.getdoc(found)
    ]
    assert not bare, f"{name} has methods without a docstring: {bare}"


def test_completion_lists_public_names_only() -> None:
    """Also in a fresh process, where nothing has been loaded yet, and after everything has."""
    for name in kg.__all__:
        getattr(kg, name)
    assert dir(kg) == sorted(kg.__all__)
    assert len(set(kg.__all__)) == len(kg.__all__)
    assert not [name for name in kg.__all__ if name.startswith("_") and name != "__version__"]
    code = "import kirigami; print(*dir(kirigami))"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert shown.split() == sorted(kg.__all__)


def test_editors_see_the_names_that_load_on_first_use() -> None:
    """Names are loaded by `__getattr__`; the imports under TYPE_CHECKING tell type checkers and editors the same."""
    tree = ast.parse(Path(kg.__file__).read_text())
    blocks = [
        node for node in tree.body if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING")
    ]
    seen = {alias.asname for block in blocks for line in block.body for alias in line.names}  # type: ignore[attr-defined]
    assert seen | {"__version__"} == set(kg.__all__)


def test_import_is_light_and_silent() -> None:
    """Nothing but the package itself and the standard library is loaded, and no warning is given."""
    code = (
        "import sys, kirigami; "
        "print(*sorted({m.split('.')[0] for m in sys.modules} & {'scipy', 'shapely', 'matplotlib', 'triangle'}))"
    )
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout.strip(), done.stderr) == (0, "", "")


def test_every_module_imports_without_a_warning() -> None:
    code = (
        "import importlib, pkgutil, kirigami\n"
        "for module in pkgutil.walk_packages(kirigami.__path__, 'kirigami.'):\n"
        "    if not module.name.endswith('__main__'):\n"
        "        importlib.import_module(module.name)"
    )
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'Baar'"):
        kg.Baar  # noqa: B018


def test_package_is_marked_as_typed() -> None:
    assert files("kirigami").joinpath("py.typed").is_file()


def test_errors_form_one_family() -> None:
    for error in (kg.GeometryError, kg.ModelError):
        assert issubclass(error, kg.KirigamiError) and issubclass(error, ValueError)
    assert issubclass(kg.MechanismError, kg.KirigamiError)
    assert issubclass(kg.ConvergenceError, kg.AnalysisError) and issubclass(kg.AnalysisError, kg.KirigamiError)
    error = kg.ConvergenceError("no equilibrium found", hint="smaller step")
    for name in ("results", "history", "worst_nodes", "hint"):
        assert hasattr(error, name)


def test_results_have_the_promised_shapes() -> None:
    """A sheet of two facets, lifted at one corner: every stored quantity by its shape."""
    mesh = kg.TriMesh([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]])
    m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e9))
    m.add(kg.Fix(m.nodes[:3]), kg.Prescribe(m.nodes[3], z=0.1))
    res = kg.DisplacementControl(m).run()
    s, n = len(res.lam), len(m.nodes)
    assert s > 2
    assert res.lam.shape == res.stable.shape == (s,) and res.stable.dtype == bool
    assert res.u.shape == res.position().shape == (s, n, 3)
    assert res.position(m.nodes[3]).shape == (s, 3) and res.position(m.nodes[:3]).shape == (s, 3, 3)
    assert res.reaction(m.nodes[3], "z").shape == (s,)
    assert res.bar_force.shape == res.bar_strain.shape == (s, 5)
    assert res.hinge_angle.shape == res.hinge_moment.shape == (s, 1)
    assert all(values.shape == (s,) for values in res.energy.values()) and {"bars", "hinges"} <= set(res.energy)
    assert isinstance(res[-1], kg.Step) and res[-1].u.shape == (n, 3)
    assert isinstance(res.events, list)
    assert {"iterations", "factorizations", "steps", "cutbacks", "seconds"} <= set(res.stats)
