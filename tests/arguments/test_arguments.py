"""Bad arguments are refused where they arrive: every public callable, every parameter, every kind of bad value.

The calls are generated from the public names. A name has a valid call in ``public_calls.CALLS``, or stands in
``NOT_CALLED`` with the reason; so what is added to the package later joins, or has to say why not.
"""

from __future__ import annotations

import inspect
import signal
import warnings
from fnmatch import fnmatch
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
from bad_values import BAD, ODD, kinds
from exceptions import ACCEPTED, ANY_KEYWORD, FREE_TEXT, NAN_MEANS, NOT_CALLED, OPTIONS, TOO_LONG
from public_calls import CALLS
from public_names import public_callables

import kirigami as kg

CALLABLES = public_callables()
PATIENCE = 60.0  # seconds of computing that one call may take before it counts as hanging


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    yield
    plt.close("all")


def parameters(name: str, function: Any, valid: dict[str, Any]) -> dict[str, inspect.Parameter]:
    """What may be spoiled: named parameters, those of the function that takes the options, and listed items."""
    found: dict[str, inspect.Parameter] = {}
    signature = inspect.signature(
        CALLABLES[name] if getattr(function, "__name__", "<lambda>") == "<lambda>" else function
    )
    for parameter in signature.parameters.values():
        if parameter.kind is parameter.VAR_KEYWORD:
            others = inspect.signature(OPTIONS[name]()).parameters if name in OPTIONS else {}
            found |= {key: other for key, other in others.items() if other.default is not other.empty}
            found |= {
                key: parameter.replace(name=key, kind=parameter.KEYWORD_ONLY)
                for key in valid
                if name in ANY_KEYWORD and key not in signature.parameters
            }
        elif parameter.name != "self":
            found[parameter.name] = parameter
    return found


def spoiled(
    valid: dict[str, Any], name: str, parameter: inspect.Parameter, value: Any
) -> tuple[list[Any], dict[str, Any]]:
    items = list(valid.get(f"*{parameter.name}", []))
    named = {key: given for key, given in valid.items() if not key.startswith("*")}
    if parameter.kind is parameter.VAR_POSITIONAL:
        return [*items, value], named
    rest = next((given for key, given in valid.items() if key.startswith("*")), [])
    return list(rest), named | {parameter.name: value}


def holds_nan(answer: Any, depth: int = 0) -> bool:
    """Whether a number, array, list, record or results of that answer is not a number."""
    if isinstance(answer, (float, complex, np.number)):
        return bool(np.isnan(answer))
    if isinstance(answer, np.ndarray):
        return answer.dtype.kind in "fc" and bool(np.isnan(answer).any())
    if isinstance(answer, dict):
        return any(holds_nan(item, depth + 1) for item in answer.values())
    if isinstance(answer, (list, tuple)) and depth < 3:
        return any(holds_nan(item, depth + 1) for item in answer)
    if isinstance(answer, kg.Results):
        return holds_nan(answer.u)
    return False


class TooLong(BaseException):
    """A call did not come back."""


def give_up(*_: Any) -> None:
    raise TooLong(f"no answer within {PATIENCE} s of computing")


def attempt(name: str, parameter: inspect.Parameter, value: Any) -> tuple[str, Any]:
    function, valid = CALLS[name]()
    items, named = spoiled(valid, name, parameter, value)
    if hasattr(signal, "ITIMER_VIRTUAL"):
        signal.signal(signal.SIGVTALRM, give_up)
        signal.setitimer(signal.ITIMER_VIRTUAL, PATIENCE)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            return "accepted", function(*items, **named)
    except kg.KirigamiError as error:
        return "refused", error
    except (Exception, TooLong) as error:
        return "raised", error
    finally:
        if hasattr(signal, "ITIMER_VIRTUAL"):
            signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        plt.close("all")


@pytest.mark.parametrize("name", sorted(CALLABLES))
def test_every_public_name_is_called_or_says_why_not(name: str) -> None:
    reasons = [why for pattern, why in NOT_CALLED.items() if fnmatch(name, pattern)]
    assert (name in CALLS) != bool(reasons), "give a valid call in public_calls.py, or a reason in exceptions.py"


def test_the_tables_name_nothing_that_is_gone() -> None:
    assert set(CALLS) <= set(CALLABLES)
    assert set(OPTIONS) <= set(CALLS)
    for name, parameter in [*ACCEPTED, *FREE_TEXT]:
        assert name in CALLS
        assert parameter in parameters(name, *CALLS[name]()), (name, parameter)


@pytest.mark.parametrize("name", [name for name in sorted(CALLS) if name in CALLABLES])
def test_a_valid_call_is_accepted(name: str) -> None:
    function, valid = CALLS[name]()
    items = next((given for key, given in valid.items() if key.startswith("*")), [])
    answer = function(*items, **{key: given for key, given in valid.items() if not key.startswith("*")})
    assert name in NAN_MEANS or not holds_nan(answer)


@pytest.mark.parametrize("name", [name for name in sorted(CALLS) if name in CALLABLES])
def test_bad_values_are_refused(name: str) -> None:
    """With an error of the package that names the parameter; never anything else, never an answer of nan."""
    wrong = []
    for key, parameter in parameters(name, *CALLS[name]()).items():
        allowed = kinds(parameter.annotation) | ({"None"} if parameter.default is None else set())
        for kind, (value, under) in BAD.items():
            if (name, key, kind) in TOO_LONG:
                continue
            outcome, answer = attempt(name, parameter, value)
            if outcome == "raised":
                wrong.append(f"{key} = {kind}: {type(answer).__name__}: {str(answer)[:100]}")
            elif outcome == "accepted" and not (under & allowed):
                if kind in ACCEPTED.get((name, key), ("", ()))[1] or (
                    kind in ("text", "number as text") and (name, key) in FREE_TEXT
                ):
                    continue
                wrong.append(f"{key} = {kind}: accepted")
            elif outcome == "accepted" and name not in NAN_MEANS and holds_nan(answer):
                wrong.append(f"{key} = {kind}: an answer of nan")
        for kind, value in ODD.items():
            if (name, key, kind) in TOO_LONG:
                continue
            outcome, answer = attempt(name, parameter, value)
            if outcome == "raised":
                wrong.append(f"{key} = {kind}: {type(answer).__name__}: {str(answer)[:100]}")
            elif outcome == "accepted" and name not in NAN_MEANS and holds_nan(answer):
                wrong.append(f"{key} = {kind}: an answer of nan")
    assert not wrong, "\n" + "\n".join(wrong)


@pytest.mark.parametrize("name", [name for name in sorted(CALLS) if name in CALLABLES and name not in ANY_KEYWORD])
def test_a_wrong_keyword_is_refused(name: str) -> None:
    function, valid = CALLS[name]()
    named = {key: given for key, given in valid.items() if not key.startswith("*")}
    with pytest.raises((TypeError, kg.KirigamiError)) as caught:
        function(**named, wrong_keyword=1)
    assert "wrong_keyword" in str(caught.value)
