"""Threads change no answer: fronts of a factorisation bit by bit, sums over facets up to rounding."""

import subprocess
import sys

import numpy as np
import pytest

import kirigami as kg
from kirigami.linalg import compiled_fronts, factorize, multifrontal, plain_fronts
from kirigami.linalg.front_plan import Eliminated
from kirigami.linalg.plain_fronts import PlainElimination
from kirigami.linalg.subtrees import shares
from kirigami.primitives.processors import processors

THREADS = (1, 2, 3)


@pytest.fixture(scope="module")
def sheet():
    mesh = kg.Sheet([(0, 0), (3, 0), (3, 2), (0, 2)], [[(0.5, 1), (2.5, 1)]]).mesh(0.2)
    model = kg.Model.from_mesh(mesh, 0.01, kg.Material(1e6, 0.3), stiffness="shell")
    model.add(kg.Fix(model.select(boundary="left"), clamp=True), kg.Prescribe(model.select(boundary="right"), x=-0.05))
    system = kg.System(model)
    return system, system.displacement(np.zeros(system.free), 1.0)


@pytest.mark.parametrize("halved", [2, 10**9])
def test_a_factor_is_the_same_whoever_eliminates(sheet, monkeypatch, halved):
    """Compiled loops in any number of threads, and Python: bit by bit, also where it is indefinite, as in a squeezed
    sheet, whose negative eigenvalues are counted alike, and where threads share fronts. Solutions are the same bit by
    bit for any number of threads, and as Python finds them up to rounding."""
    pytest.importorskip("numba")
    system, u = sheet
    for module in (compiled_fronts, plain_fronts):
        monkeypatch.setattr(module, "HALVED", halved)
    monkeypatch.setattr(multifrontal, "COMPILED", 1)
    right = np.random.default_rng(0).normal(size=system.free)
    for share, least in ((0.0, 1), (0.0, 10**9), (1.0, 1), (1.0, 10**9)):
        monkeypatch.setattr(multifrontal, "LARGE", least)  # solutions in two halves and a rest, and as a whole
        matrix = system.matrix(system.stiffness_blocks(share * u, share))
        found = []
        for threads in THREADS:
            monkeypatch.setattr(multifrontal, "threads_for", lambda numbers, threads=threads: threads)
            factor = factorize(matrix)
            assert factor.backend == "multifrontal" and (len(factor._loops._halves) == 2) == (least == 1)
            assert (factor.negative > 0) == (share > 0)
            found.append((*factor._made, factor.solve(right)))
        for other in found[1:]:
            for one, two in zip(found[0], other):
                np.testing.assert_array_equal(one, two)
        plain = Eliminated.nothing(factor._plan)
        factor._plan.spread(matrix.data, plain.store)
        PlainElimination(factor._plan, plain).eliminate(np.arange(len(factor._plan.pivots)))
        for one, two in zip(found[0], plain):
            np.testing.assert_array_equal(one, two)
        solution = plain_fronts.solve(factor._plan, plain, right)
        np.testing.assert_allclose(found[0][-1], solution, rtol=0, atol=1e-9 * np.abs(solution).max())
        assert np.linalg.norm(matrix @ found[0][-1] - right) < 1e-9 * np.linalg.norm(right)


def test_nothing_is_compiled_where_that_is_not_wanted(sheet, monkeypatch):
    """The answers are the same up to rounding."""
    pytest.importorskip("numba")
    system, u = sheet
    monkeypatch.setattr(multifrontal, "COMPILED", 1)
    matrix, right = system.matrix(system.stiffness_blocks(u, 1.0)), system.reduce(system.forces(u, 1.0)[0])
    compiled = factorize(matrix)
    monkeypatch.setenv("KIRIGAMI_COMPILED", "0")
    plain = factorize(matrix)
    assert compiled._loops is not None and plain._loops is None
    assert plain.negative == compiled.negative > 0
    expected = compiled.solve(right)
    np.testing.assert_allclose(plain.solve(right), expected, rtol=0, atol=1e-7 * np.abs(expected).max())


def test_forces_and_tangent_are_the_same_for_any_number_of_threads(sheet, monkeypatch):
    pytest.importorskip("numba")
    from kirigami.elements import compiled_shell

    system, u = sheet
    monkeypatch.setattr(compiled_shell, "MANY", 10)
    found = []
    for threads in THREADS:
        monkeypatch.setattr(compiled_shell, "processors", lambda threads=threads: threads)
        once, again = ((*system.forces(u, 1.0), system.stiffness_blocks(u, 1.0)) for _ in range(2))
        for one, other in zip(once, again):
            np.testing.assert_array_equal(one, other)  # repeatable
        found.append(once)
    for other in found[1:]:
        for one, two in zip(found[0], other):
            np.testing.assert_allclose(two, one, rtol=1e-9, atol=1e-12 * np.abs(one).max())


def test_shares_of_a_tree_are_whole_subtrees():
    """Every front belongs to one thread or to the rest; no thread waits for another, and the rest waits for all."""
    random = np.random.default_rng(0)
    parent = np.array([*(random.integers(k + 1, min(k + 30, 400)) for k in range(399)), -1])
    work = random.uniform(1, 2, 400)
    for threads in (1, 2, 5):
        groups, rest = shares(parent, work, threads)
        assert sorted([front for group in [*groups, rest] for front in group]) == list(range(400))
        for group in groups:
            inside = set(group)
            assert group == sorted(group)
            for child, above in enumerate(parent.tolist()):
                assert (above in inside) <= (child in inside)  # whoever has a front has all below it
        if threads == 2:
            loads = [work[group].sum() for group in groups]
            assert min(loads) > 0.5 * max(loads) and sum(loads) > 0.5 * work.sum()


def test_processors_are_those_allowed(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    assert processors() == 1
    monkeypatch.setenv("OMP_NUM_THREADS", "nonsense")
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    assert processors() >= 1


def test_routines_are_known_to_loops_in_a_process_that_has_compiled_nothing():
    """Numba learns of routines called by address from a module that it loads with the first thing it compiles: a plate
    whose factor was the first ended in a TypingError."""
    pytest.importorskip("numba")
    lines = "import numba, kirigami.linalg.compiled_fronts as fronts; numba.typeof(fronts._packed_solve())"
    done = subprocess.run([sys.executable, "-c", lines], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
