"""Walks the public names of the package: every class, function and method that a user can call."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Callable
from typing import Any

import kirigami as kg
from kirigami.deferred import deferred

# Modules whose functions users call by the path of the module, beside what `kirigami` itself lists.
DOCUMENTED = (
    "kirigami.post.curvature",
    "kirigami.post.energy",
    "kirigami.post.friction",
    "kirigami.post.opening",
    "kirigami.post.permeability",
    "kirigami.post.shape",
    "kirigami.results.contact",
    "kirigami.units",
)


def public_objects() -> dict[str, Any]:
    """Classes and functions by name: ``"Model"``, ``"study.bracket"``, ``"effects.contact.Plane"``; each once."""
    found: dict[str, Any] = {}
    modules = {}
    for name in kg.__all__:
        item = getattr(kg, name)
        if inspect.ismodule(item):
            modules[name] = item
        elif name != "__version__":
            found[name] = item
    for path in DOCUMENTED:
        modules[path.removeprefix("kirigami.")] = importlib.import_module(path)
    for name, module in modules.items():
        listed = getattr(module, "__all__", None) or [
            key
            for key, item in vars(module).items()
            if getattr(item, "__module__", "") == module.__name__ or isinstance(item, type(deferred("")))
        ]
        for key in listed:
            item = getattr(module, key)
            if isinstance(item, type(deferred(""))):
                item = item.__get__(None, object)  # a function of another package
            if key.startswith("_") or not (inspect.isclass(item) or inspect.isfunction(item)):
                continue
            if not any(item is other for other in found.values()):
                found[f"{name}.{key}"] = item
    return found


def public_callables() -> dict[str, Callable[..., Any]]:
    """Constructors, functions and methods of the package's own, by name; what a class inherits, at its first heir."""
    found: dict[str, Callable[..., Any]] = {}
    seen: set[int] = set()
    for name, item in public_objects().items():
        found[name] = item
        if not inspect.isclass(item):
            continue
        for method in sorted(dir(item)):
            if method.startswith("_") or not callable(getattr(item, method, None)):
                continue
            plain = inspect.unwrap(getattr(getattr(item, method), "__func__", getattr(item, method)))
            if str(getattr(plain, "__module__", "")).startswith("kirigami") and id(plain) not in seen:
                seen.add(id(plain))
                found[f"{name}.{method}"] = getattr(item, method)
    return found
