"""What came of contacts: gaps, forces and penetration at each step."""

from __future__ import annotations

import numpy as np

from kirigami.effects.contact import Contact, ContactKernel
from kirigami.errors import ModelError
from kirigami.primitives.checks import require_instance
from kirigami.primitives.kernel import Array
from kirigami.results.results import Results


def gaps(results: Results, contact: Contact | int | None = None) -> Array:
    """Distance of the nodes from their surfaces at each step, less the offset; negative inside.

    Parameters
    ----------
    results : Results
        Of a model with contacts.
    contact : Contact or int, optional
        One of them, or its number in the order added; None takes all, in the order added and node by node.

    Returns
    -------
    ndarray, shape (s, nodes)
        Distance [length].

    Raises
    ------
    ModelError
        The model had no contact, or not this one.
    """
    name = _contact(results)
    return results.deformation(name, of=contact)


def normal_forces(results: Results, contact: Contact | int | None = None) -> Array:
    """Force that pushes each node off its surface, along the normal of the surface there.

    Parameters
    ----------
    results : Results
        Of a model with contacts.
    contact : Contact or int, optional
        One of them, or its number in the order added; None takes all, in the order added and node by node.

    Returns
    -------
    ndarray, shape (s, nodes)
        Force, never negative [force].

    Raises
    ------
    ModelError
        The model had no contact, or not this one.
    """
    name = _contact(results)
    return results.force(name, of=contact)


def penetration(results: Results, contact: Contact | int | None = None) -> Array:
    """Depth of the deepest node inside its surface at each step (s,) [length]; zero where none is inside.

    Parameters
    ----------
    results : Results
        Of a model with contacts.
    contact : Contact or int, optional
        One of them, or its number in the order added; None takes all.

    Raises
    ------
    ModelError
        The model had no contact, or not this one.
    """
    depth: Array = np.maximum(-gaps(results, contact), 0.0).max(axis=1)
    return depth


def _contact(results: Results) -> str:
    require_instance(results, Results, "results", "contact")
    if not any(kernel.name == ContactKernel.name for kernel in results.kernels):
        raise ModelError("these results have no Contact: add one to the model")
    return ContactKernel.name
