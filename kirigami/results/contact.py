"""What came of contacts: gaps, forces and penetration at each step."""

from __future__ import annotations

from typing import Any

import numpy as np

from kirigami.effects.contact import Contact, ContactKernel
from kirigami.errors import ModelError
from kirigami.primitives.kernel import Array
from kirigami.results.results import Results


def gaps(results: Results, contact: Contact | None = None) -> Array:
    """Distance of the nodes from their surfaces at each step, less the offset; negative inside.

    Parameters
    ----------
    results : Results
        Of a model with contacts.
    contact : Contact, optional
        One of them; None takes all, in the order added and node by node.

    Returns
    -------
    ndarray, shape (s, nodes)
        Distance [length].

    Raises
    ------
    ModelError
        The model has no contact, or not this one.
    """
    return _over_steps(results, contact, lambda kernel, x: kernel.deformation(x))


def normal_forces(results: Results, contact: Contact | None = None) -> Array:
    """Force that pushes each node off its surface, along the normal of the surface there.

    Parameters
    ----------
    results : Results
        Of a model with contacts.
    contact : Contact, optional
        One of them; None takes all, in the order added and node by node.

    Returns
    -------
    ndarray, shape (s, nodes)
        Force, never negative [force].

    Raises
    ------
    ModelError
        The model has no contact, or not this one.
    """
    return _over_steps(results, contact, lambda kernel, x: kernel.force(kernel.deformation(x)))


def penetration(results: Results, contact: Contact | None = None) -> Array:
    """Depth of the deepest node inside its surface at each step (s,) [length]; zero where none is inside.

    Parameters
    ----------
    results : Results
        Of a model with contacts.
    contact : Contact, optional
        One of them; None takes all.

    Raises
    ------
    ModelError
        The model has no contact, or not this one.
    """
    depth: Array = np.maximum(-gaps(results, contact), 0.0).max(axis=1)
    return depth


def _over_steps(results: Results, contact: Contact | None, quantity: Any) -> Array:
    kernel = next((kernel for kernel in results.kernels if isinstance(kernel, ContactKernel)), None)
    if kernel is None:
        raise ModelError("these results have no Contact: add one to the model")
    chosen: Any = slice(None)
    if contact is not None:
        if results.model is None:
            raise ModelError("these results were loaded from a file: leave `contact` out to get all of them")
        present = [item for item in results.model.effects if isinstance(item, Contact)]
        number = next((k for k, item in enumerate(present) if item is contact), None)
        if number is None:
            raise ModelError(f"{contact!r} is not in the model of these results")
        assert kernel.members is not None
        chosen = np.flatnonzero(kernel.members == number)
    return np.array([quantity(kernel, results.configuration(step))[chosen] for step in results.steps])
