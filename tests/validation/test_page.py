"""The page of the docs shows every case as it is listed here, and no row beyond its bound that is not marked."""

import importlib.util
from pathlib import Path

import pytest

TOOL = Path(__file__).parents[2] / "tools" / "validation.py"


def load():
    spec = importlib.util.spec_from_file_location("validation_page", TOOL)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_is_that_of_the_cases():
    tool = load()
    assert tool.PAGE.read_text() == tool.page(tool.sources(), tool.read_rows())


def test_rows_are_within_their_bounds_and_at_least_25_cases_are_there():
    tool = load()
    rows, cases = tool.read_rows(), [(n, case) for n, module in tool.sources().items() for case in module.CASES]
    assert len(cases) >= 25
    for name, case in cases:
        for rung, bound in case.bounds.items():
            assert float(rows[name, case.name, rung]["error"]) <= bound.error, f"{case.name} on {rung}"


def test_a_miss_that_holds_its_case_is_refused():
    """The tests of the cases can fail, both ways."""
    import case

    listed = case.Case("half", 1.0, "a number", lambda rung: case.Found(1.01), {"shell": case.Bound(0.005)})
    with pytest.raises(AssertionError, match="1.00 % off"):
        listed.check("shell")
    listed = case.Case("half", 1.0, "a number", lambda rung: case.Found(1.01), {"shell": case.Bound(0.1, "a cause")})
    with pytest.raises(AssertionError, match="no miss any more"):
        listed.check("shell")
