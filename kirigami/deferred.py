"""Methods that are functions of another package, imported when they are called."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any


def deferred(target: str, static: bool = False) -> Any:
    """A method by the name of the function that does its work, such as ``deferred("kirigami.io.table:to_csv")``.

    What a class can do is then written where the class is, while the package that does it, and the library that
    package needs, are imported on first use only. Asked of the class, the method is the function itself: help,
    signature and documentation are its own.

    Parameters
    ----------
    target : str
        Module and function, joined by a colon. The function takes the object as its first argument.
    static : bool
        True for alternative constructors, whose function takes no object.

    Examples
    --------
    >>> import inspect, kirigami as kg
    >>> list(inspect.signature(kg.Results.to_csv).parameters)
    ['results', 'path', 'reactions']
    """
    return _Deferred(target, static)


class _Deferred:
    def __init__(self, target: str, static: bool) -> None:
        self.target = target
        self.static = static

    @property
    def __wrapped__(self) -> Callable[..., Any]:
        """The function itself, so that its signature is seen where it stands in a module instead of a class."""
        module, name = self.target.split(":")
        function: Callable[..., Any] = getattr(importlib.import_module(module), name)
        return function

    @property
    def __doc__(self) -> str | None:  # type: ignore[override]
        """What the function says of itself, for help(kg.stiffness.report)."""
        return self.__wrapped__.__doc__

    def __get__(self, instance: Any, owner: type) -> Any:
        function = self.__wrapped__
        return function if self.static or instance is None else function.__get__(instance, owner)

    def __call__(self, *args: Any, **options: Any) -> Any:
        return self.__wrapped__(*args, **options)
