"""Modules of version 0.1 go on being importable under their old names, with a warning that names the new home."""

import importlib

import pytest

import kirigami as kg
from kirigami.moved import MOVED, PUBLIC

# One name of each module, as a script written for version 0.1 imports it.
NAMES = {
    "kernel": "displacement_of",
    "objects": "ModelObject",
    "constraints": "Fix",
    "storage": "load",
    "step": "Step",
    "framework": "Framework",
    "io.dxf": "read_dxf",
    "io.fold": "read_fold",
    "post.stress": "sheet_stress",
    "model": "Model",
    "results": "Results",
    "system": "System",
    "sweep": "Sweep",
    "analysis.path": "ArcLength",
    "sampling": "latin_hypercube",
    "sweep_table": "SweepTable",
}


@pytest.mark.parametrize("module", NAMES)
def test_old_names_warn_and_work(module):
    found = importlib.import_module(f"kirigami.{module}")
    name = NAMES[module]
    with pytest.warns(DeprecationWarning, match=f"kirigami.{module}.{name} has moved to kirigami."):
        getattr(found, name)


@pytest.mark.parametrize("module", PUBLIC)
def test_public_modules_are_the_same_under_both_names(module):
    assert importlib.import_module(f"kirigami.{module}") is getattr(kg, module)
    assert importlib.import_module(f"kirigami.{PUBLIC[module]}") is getattr(kg, module)


@pytest.mark.parametrize("module", MOVED)
def test_every_new_home_exists(module):
    assert importlib.import_module(f"kirigami.{module}") is not None
    for home in MOVED[module]:
        importlib.import_module(f"kirigami.{home}")


def test_a_name_that_never_was_is_an_attribute_error():
    with pytest.raises(ImportError):
        exec("from kirigami.objects import Rope")
