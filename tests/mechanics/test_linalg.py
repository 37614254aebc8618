"""Factorisations: each back end against dense linear algebra, and the dissection against what it promises."""

from __future__ import annotations

import importlib.util
import weakref
from itertools import pairwise

import numpy as np
import pytest
from scipy.sparse import block_diag, csc_matrix, diags, identity, kron, random
from shapely import box

import kirigami as kg
from kirigami.linalg import (
    BACKENDS,
    SingularMatrixError,
    factorize,
    lowest_eigenpairs,
    lowest_of_pencil,
    make_solver,
    multifrontal,
    nearby_factor,
)
from kirigami.linalg.dissection import dissect
from kirigami.linalg.multifrontal import MultifrontalFactor
from kirigami.linalg.threads import one_thread

needs_rslab = pytest.mark.skipif(importlib.util.find_spec("rslab") is None, reason="rslab is not installed")
needs_numba = pytest.mark.skipif(importlib.util.find_spec("numba") is None, reason="numba is not installed")
MARKS = {"rslab": needs_rslab, "compiled": needs_numba}


@pytest.fixture(params=[pytest.param(name, marks=MARKS.get(name, ())) for name in (*BACKENDS, "compiled")])
def name(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Name of a back end; "compiled" is the default with the loops that larger matrices are worth."""
    if request.param != "compiled":
        return str(request.param)
    monkeypatch.setattr(multifrontal, "COMPILED", 1)
    return "multifrontal"


def grid(columns: int, rows: int) -> csc_matrix:
    """Three unknowns at each node of a grid, coupled, with the stiffness of a net of springs."""
    line_x, line_y = (diags([-1.0, 2.1, -1.0], [-1, 0, 1], shape=(k, k)) for k in (columns, rows))
    net = kron(line_x, identity(rows)) + kron(identity(columns), line_y)
    return csc_matrix(kron(net, np.array([[4.0, 1.0, 0.0], [1.0, 3.0, 1.0], [0.0, 1.0, 2.0]])))


def slit_sheet() -> kg.System:
    """A thin sheet with two slits, gripped at two edges, some 400 nodes."""
    sheet = kg.Sheet(
        [(0, 0), (1, 0), (1, 1), (0, 1)],
        [[(0.2, 0.35), (0.8, 0.35)], [(0.2, 0.65), (0.8, 0.65)]],
        thickness=1e-3,
        material=kg.Material(E=1e9),
    )
    m = kg.Model.from_mesh(sheet.mesh(max_edge=0.07))
    x, y, _ = m.positions().T
    m.perturb(0.01 * np.sin(5 * x) * np.cos(4 * y))
    m.add(kg.Fix(m.select(boundary="bottom")), kg.Fix(m.select(boundary="top"), "xz"))
    m.add(kg.Prescribe(m.select(boundary="top"), y=0.05))
    return kg.System(m)


def relative_error(matrix: csc_matrix, solution: np.ndarray, rhs: np.ndarray) -> float:
    return float(np.linalg.norm(matrix @ solution - rhs) / np.linalg.norm(rhs))


@pytest.mark.parametrize("shift", [0.0, 0.5, 3.0, 12.0, 40.0])
def test_solution_and_inertia_against_dense_eigenvalues(name: str, shift: float) -> None:
    matrix = csc_matrix(grid(14, 11) - shift * identity(3 * 14 * 11))
    values = np.linalg.eigvalsh(matrix.toarray())
    factor = make_solver(name).factorize(matrix)
    rhs = np.random.default_rng(2).normal(size=matrix.shape[0])
    assert relative_error(matrix, factor.solve(rhs), rhs) < 1e-10
    assert factor.negative == np.count_nonzero(values < 0)
    assert factor.backend == name


@pytest.mark.parametrize("shift", [0.0, 12.0])
def test_some_right_hand_sides_at_once(name: str, shift: float) -> None:
    """Columns solve as they do one by one, also none, only one, a zero one, and where pivots are exchanged."""
    matrix = csc_matrix(grid(14, 11) - shift * identity(3 * 14 * 11))
    factor = make_solver(name).factorize(matrix)
    rhs = np.random.default_rng(3).normal(size=(matrix.shape[0], 5)) * [1.0, 1e-9, 0.0, 1e9, 1.0]
    for count in (0, 1, 5):
        some = factor.solve(rhs[:, :count])
        assert some.shape == (matrix.shape[0], count)
        for column in range(count):
            one = factor.solve(rhs[:, column])
            assert np.allclose(some[:, column], one, rtol=0, atol=1e-10 * np.abs(one).max())


def test_random_indefinite_matrices(name: str) -> None:
    for seed in range(5):
        rng = np.random.default_rng(seed)
        half = random(150, 150, density=0.02, random_state=rng, data_rvs=rng.standard_normal)
        matrix = csc_matrix(half + half.T + diags(rng.normal(size=150)))
        factor = make_solver(name).factorize(matrix)
        rhs = rng.normal(size=150)
        assert relative_error(matrix, factor.solve(rhs), rhs) < 1e-8
        assert factor.negative == np.count_nonzero(np.linalg.eigvalsh(matrix.toarray()) < 0)


def test_saddle_point_with_zeros_on_the_diagonal(name: str) -> None:
    """Constraints by multipliers: as many negative eigenvalues as constraints, and no pivot to start from."""
    stiff = grid(9, 8)
    rng = np.random.default_rng(4)
    rows = random(20, stiff.shape[0], density=0.1, random_state=rng, data_rvs=rng.standard_normal).tocsc()
    from scipy.sparse import bmat

    matrix = csc_matrix(bmat([[None, rows], [rows.T, stiff]]))
    factor = make_solver(name).factorize(matrix)
    rhs = np.ones(matrix.shape[0])
    assert relative_error(matrix, factor.solve(rhs), rhs) < 1e-8
    assert factor.negative == 20


def test_tangents_of_a_sheet_agree_between_back_ends(name: str) -> None:
    system = slit_sheet()
    rng = np.random.default_rng(0)
    solver, counts = make_solver(name), []
    for amplitude in (0.0, 1e-5, 1e-3):  # the last state is far from equilibrium and very indefinite
        u = amplitude * rng.normal(size=system.rest.shape)
        u[system.constrained] = 0.0
        matrix = system.stiffness(u)
        dense = matrix.toarray()
        factor = solver.factorize(matrix)
        rhs = rng.normal(size=system.free)
        exact = np.linalg.solve(dense, rhs)
        assert np.linalg.norm(factor.solve(rhs) - exact) < 1e-8 * np.linalg.norm(exact)
        assert relative_error(matrix, factor.solve(rhs), rhs) < 1e-9
        counts.append(factor.negative)
        assert counts[-1] == np.count_nonzero(np.linalg.eigvalsh(dense) < 0)
    assert counts[0] == 0 and counts[-1] > 50


def test_results_of_a_path_do_not_depend_on_the_back_end(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    ends = []
    for chosen in ("superlu", name):
        monkeypatch.setenv("KIRIGAMI_SOLVER", chosen)
        m = slit_sheet().model
        res = kg.DisplacementControl(m, to=0.02, step=0.01, tol=1e-12).run()
        assert res.stats["backend"] == chosen and chosen in res.summary()
        ends.append((res.u[-1], res.reaction(m.select(boundary="top"), "y")[-1], res[-1].negative))
    (u, force, negative), (other_u, other_force, other_negative) = ends
    assert np.abs(u - other_u).max() < 1e-9 * np.abs(u).max()
    assert force == pytest.approx(other_force, rel=1e-9)
    assert negative == other_negative


def test_a_singular_matrix_gives_the_typed_error(name: str) -> None:
    loose = csc_matrix(diags([-1.0, 2.0, -1.0], [-1, 0, 1], shape=(50, 50)).tolil())
    loose = csc_matrix(loose - diags(np.eye(50)[0] + np.eye(50)[-1]))  # a chain of springs without support
    with pytest.raises(SingularMatrixError):
        factor = make_solver(name).factorize(loose)
        factor.solve(np.ones(50))
    with pytest.raises(SingularMatrixError):
        make_solver(name).factorize(csc_matrix((4, 4))).solve(np.ones(4))


def test_soft_is_not_singular(name: str) -> None:
    """A cantilever of N stiff links on springs k, pushed at its tip: P l^2 N (N + 1) (2 N + 1) / (6 k), of any length.

    Its residual is large against the push, as the terms of K u are, and yet it is right; without its foot it falls.
    """
    links = 600
    m = kg.Model(dim=2)
    nodes = m.add(*(kg.Node(float(k), 0) for k in range(-1, links + 1)))
    m.add(*(kg.Bar(a, b, 1e3) for a, b in pairwise(nodes)))
    m.add(*(kg.TorsionSpring3(a, b, c, 1.0) for a, b, c in zip(nodes, nodes[1:], nodes[2:])))
    m.add(kg.Fix(nodes[:2]))
    matrix, rhs = kg.System(m).stiffness(), np.zeros(2 * links)
    rhs[-1] = 1.0
    tip = make_solver(name).factorize(matrix).solve(rhs)[-1]
    assert tip == pytest.approx(links * (links + 1) * (2 * links + 1) / 6, rel=1e-3)
    m.remove(*[item for item in m.elements if nodes[0] in item.nodes])
    m.add(kg.Bar(nodes[0], nodes[1], 1e3), kg.Fix(nodes[2], "x"))
    loose = kg.System(m).stiffness()
    with pytest.raises(SingularMatrixError):
        make_solver(name).factorize(loose).solve(np.ones(loose.shape[0]))


@pytest.mark.parametrize("rung", ["plate", "facet"])
def test_thin_sheets_bend_as_thick_ones(rung: str) -> None:
    """A clamped strip under a tip load that goes with t^3 moves by the same, from t / L = 1e-2 to 1e-6."""
    mesh = kg.Sheet(box(0, 0, 1, 0.2)).mesh(0.03)
    tips = []
    for t in (1e-2, 1e-4, 1e-6):
        m = kg.Model.from_mesh(mesh, t, kg.Material(E=1e9, nu=0.3), stiffness=rung)
        end = m.select(boundary="right")
        m.add(kg.Fix(m.select(boundary="left"), clamp=True), kg.NodalLoad(end, (0, 0, 1e9 * t**3 / len(end))))
        tips.append(kg.LinearStatic(m).run().u[-1][m.index(end), 2].mean())
    assert tips == pytest.approx([tips[0]] * 3, rel=1e-8)


def test_one_solver_for_changing_values_and_changing_patterns(name: str) -> None:
    solver = make_solver(name)
    rng = np.random.default_rng(1)
    for matrix in (grid(8, 7), 3.0 * grid(8, 7), grid(5, 9), block_diag([grid(4, 4), grid(6, 3)], format="csc")):
        rhs = rng.normal(size=matrix.shape[0])
        assert relative_error(matrix, solver.factorize(csc_matrix(matrix)).solve(rhs), rhs) < 1e-12
    first, second = solver.factorize(grid(8, 7)), solver.factorize(csc_matrix(2.0 * grid(8, 7)))
    rhs = np.ones(3 * 56)
    assert np.allclose(first.solve(rhs), 2.0 * second.solve(rhs), rtol=1e-12)  # factors live side by side


@pytest.mark.parametrize("upper", [False, True])
def test_a_sum_of_matrices_may_have_lost_entries_on_one_side(name: str, upper: bool) -> None:
    """Where two terms cancel to rounding above the diagonal and to zero below it, or the other way about."""
    whole = grid(9, 8).tolil()
    size = whole.shape[0]
    for row in range(30, size):
        column = row - 30
        whole[(column, row) if upper else (row, column)] = 1e-18
    matrix = csc_matrix(whole)
    assert (abs(matrix - matrix.T) > 0).nnz > size
    load = np.cos(np.arange(size))
    found = make_solver(name).factorize(matrix).solve(load)
    np.testing.assert_allclose(found, np.linalg.solve(matrix.toarray(), load), rtol=1e-9)


def test_small_matrices(name: str) -> None:
    assert make_solver(name).factorize(csc_matrix((0, 0))).solve(np.zeros(0)).shape == (0,)
    factor = make_solver(name).factorize(csc_matrix([[-4.0]]))
    assert factor.negative == 1 and factor.solve(np.array([2.0])).tolist() == [-0.5]
    assert factor.solve(np.zeros(1)).tolist() == [0.0]


def test_the_default_repeats_bit_by_bit() -> None:
    matrix = slit_sheet().stiffness()
    rhs = np.random.default_rng(5).normal(size=matrix.shape[0])
    first, second = (factorize(matrix.copy()).solve(rhs) for _ in range(2))
    assert np.array_equal(first, second)
    solver = make_solver()
    solver.factorize(matrix)
    assert np.array_equal(solver.factorize(matrix).solve(rhs), first)


def test_a_smooth_path_keeps_two_factors_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """That of the last equilibrium and the one being made: factors are the largest things in memory. Where a buckle is
    left downhill, a third one, of the state that was left."""
    alive: weakref.WeakSet[MultifrontalFactor] = weakref.WeakSet()
    most, make = [], MultifrontalFactor.__init__

    def counted(factor: MultifrontalFactor, *given: object) -> None:
        alive.add(factor)
        most.append(len(alive))
        make(factor, *given)

    monkeypatch.setattr(MultifrontalFactor, "__init__", counted)
    results = kg.DisplacementControl(slit_sheet().model, to=0.05).run()
    assert len(most) == results.stats["factorizations"] > 10
    assert max(most) <= (3 if results.stats["relaxations"] else 2) and np.mean(most) < 2.1


def test_an_unknown_back_end_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(kg.AnalysisError, match="no solver is called 'umfpack': choose one of multifrontal, superlu"):
        make_solver("umfpack")
    monkeypatch.setenv("KIRIGAMI_SOLVER", "guess")
    with pytest.raises(kg.AnalysisError, match="guess"):
        kg.LinearStatic(slit_sheet().model).run()


def test_a_missing_back_end_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "rslab", None)
    with pytest.raises(kg.AnalysisError, match=r"kirigami-mechanics\[fast\]"):
        make_solver("rslab")


def test_fronts_eliminate_every_unknown_once_and_border_only_on_ancestors() -> None:
    matrix = slit_sheet().stiffness()
    fronts = dissect(matrix, leaf=60)
    assert np.array_equal(np.sort(fronts.order), np.arange(matrix.shape[0]))
    number = np.argsort(fronts.order)
    of = np.repeat(np.arange(len(fronts.parent)), np.diff(fronts.starts))  # front of each numbered unknown
    for f, border in enumerate(fronts.borders):
        ancestors, at = set(), f
        while fronts.parent[at] >= 0:
            assert fronts.parent[at] > at  # children before parents
            at = int(fronts.parent[at])
            ancestors.add(at)
        assert set(of[border]) <= ancestors
        columns = fronts.order[fronts.starts[f] : fronts.starts[f + 1]]
        rows = number[matrix[:, columns].indices]
        assert set(rows[rows >= fronts.starts[f + 1]]) <= set(border)


def test_fill_grows_like_n_log_n_on_grids() -> None:
    """Nested dissection of a square grid leaves O(n log n) entries (George 1973); bands would leave n^1.5."""
    entries = []
    for size in (20, 80):
        fronts = dissect(grid(size, size), leaf=100)
        pivots = np.diff(fronts.starts)
        border = np.array([len(b) for b in fronts.borders])
        entries.append((pivots * (pivots + 1) / 2 + pivots * border).sum() / (3 * size**2))
    assert entries[1] / entries[0] < 2.5  # log ratio; a band would quadruple them
    assert entries[1] < 31 * np.log2(80) * 3 / 4


def test_separator_of_two_blocks_joined_by_a_bridge_is_the_bridge() -> None:
    """A sheet with a ligament is cut across the ligament, wherever that lies."""
    lattice = np.zeros((20, 41), dtype=int)
    lattice[:, :18] = lattice[:, 23:] = 1
    lattice[9:11, 18:23] = 1
    node = np.full(lattice.shape, -1)
    node[lattice == 1] = np.arange(lattice.sum())
    pairs = [
        (one, other)
        for a, b in ((node[:, :-1], node[:, 1:]), (node[:-1], node[1:]))
        for one, other in zip(a.ravel(), b.ravel())
        if one >= 0 and other >= 0
    ]
    n = int(lattice.sum())
    rows, columns = np.array(pairs).T
    graph = csc_matrix((np.ones(len(rows)), (rows, columns)), shape=(n, n))
    fronts = dissect(csc_matrix(graph + graph.T + identity(n)), leaf=400)
    root = fronts.order[fronts.starts[-2] :]
    assert len(root) == 2
    assert np.isin(np.nonzero(np.isin(node, root))[1], np.arange(17, 24)).all()


def test_lowest_eigenpairs_match_dense_ones() -> None:
    matrix = grid(15, 12)
    mass = csc_matrix(diags(1.0 + np.arange(matrix.shape[0]) / 500.0))
    values, vectors = lowest_eigenpairs(matrix, mass, 4, np.zeros((matrix.shape[0], 0)), factorize)
    from scipy.linalg import eigh

    assert values == pytest.approx(eigh(matrix.toarray(), mass.toarray(), eigvals_only=True)[:4], rel=1e-9)
    assert np.abs(vectors.T @ (mass @ vectors) - np.eye(4)).max() < 1e-9


@pytest.mark.parametrize("copies", [1, 3, 9])
@pytest.mark.parametrize("shift", [0.0, 1.7, 30.0])
def test_equal_eigenvalues_are_all_found(copies: int, shift: float) -> None:
    """Blocks alike: every eigenvalue as many times as there are blocks, of definite and indefinite matrices."""
    block = csc_matrix(grid(5, 4) - shift * identity(60))
    matrix = block_diag([block] * copies, format="csc")
    exact = np.sort(np.tile(np.linalg.eigvalsh(block.toarray()), copies))[:7]
    mass = identity(matrix.shape[0], format="csc")
    values, _ = lowest_eigenpairs(matrix, mass, 7, np.zeros((matrix.shape[0], 0)), factorize)
    assert values == pytest.approx(exact, rel=1e-9)


def test_all_eigenvalues_of_a_matrix_of_sixteen_decades() -> None:
    exact = 10.0 ** np.linspace(-8, 8, 30)
    none = np.zeros((30, 0))
    for count in (1, 12, 30):
        values, _ = lowest_eigenpairs(csc_matrix(diags(exact)), identity(30, format="csc"), count, none, factorize)
        assert values == pytest.approx(exact[:count], rel=1e-6)


def test_a_chain_without_support_and_masses_without_inertia() -> None:
    """Springs k in line: k (2 - 2 cos(pi j / n)) / m; the motion of all is told, or found; every other mass is none."""
    n = 41
    chain = diags([-1.0, 2.0, -1.0], [-1, 0, 1], shape=(n, n)).tolil()
    chain[0, 0] = chain[-1, -1] = 1.0
    chain = csc_matrix(chain)
    exact = 2 - 2 * np.cos(np.pi * np.arange(6) / n)
    for null in (np.ones((n, 1)), np.zeros((n, 0))):
        values, _ = lowest_eigenpairs(chain, identity(n, format="csc"), 6, null, factorize)
        assert values == pytest.approx(exact, rel=1e-9, abs=1e-15)
    heavy = np.zeros(n)
    heavy[::2] = 1.0  # the light ones put two springs in line, k / 2, between the 21 heavy ones
    exact = 1 - np.cos(np.pi * np.arange(21) / 21)
    for count in (5, 21):
        values, _ = lowest_eigenpairs(chain, csc_matrix(diags(heavy)), count, np.ones((n, 1)), factorize)
        assert values == pytest.approx(exact[:count], rel=1e-9, abs=1e-15)


def test_dense_blocks_keep_to_one_thread() -> None:
    controller = pytest.importorskip("threadpoolctl").ThreadpoolController()
    before = [library["num_threads"] for library in controller.info()]
    with one_thread():
        assert all(library["num_threads"] == 1 for library in controller.info() if library["user_api"] == "blas")
    assert [library["num_threads"] for library in controller.info()] == before


# ------------------------------------------------------------------------------- a matrix close to a factorised one


def pencil(eigenvalues: np.ndarray) -> tuple[csc_matrix, csc_matrix]:
    """A positive definite matrix L, and K with the given eigenvalues of the pencil (K, L)."""
    rng = np.random.default_rng(3)
    n = len(eigenvalues)
    root = np.tril(rng.normal(size=(n, n))) + 4 * np.eye(n)
    turned = np.linalg.qr(rng.normal(size=(n, n)))[0]
    return tuple(csc_matrix(root @ a @ root.T) for a in (np.eye(n), turned * eigenvalues @ turned.T))


@pytest.mark.parametrize("lowest", [-3.0, -1e-3, 0.05, 0.5, 0.9])
def test_the_lowest_eigenvalue_of_a_pencil(lowest: float) -> None:
    """Alone below a cluster, as where one mode loses its stiffness."""
    near, matrix = pencil(np.append(np.linspace(0.95, 1.05, 59), lowest))
    found, settled = lowest_of_pencil(matrix, factorize(near))
    assert settled and found == pytest.approx(lowest, rel=0.05, abs=5e-3)


@pytest.mark.parametrize("lowest", [0.5, 0.9])
def test_a_factor_close_by_solves_exactly(lowest: float) -> None:
    near, matrix = pencil(np.append(np.linspace(0.95, 1.05, 59), lowest))
    factor = nearby_factor(matrix, factorize(near))
    assert factor is not None and factor.negative == 0
    solution = np.random.default_rng(4).normal(size=60)
    assert factor.solve(matrix @ solution) == pytest.approx(solution, abs=1e-8)


@pytest.mark.parametrize("lowest", [-3.0, -1e-3, 0.05])
def test_a_factor_that_hides_a_loss_of_stability_is_refused(lowest: float) -> None:
    near, matrix = pencil(np.append(np.linspace(0.95, 1.05, 59), lowest))
    assert nearby_factor(matrix, factorize(near)) is None
    assert nearby_factor(near, factorize(-near)) is None
