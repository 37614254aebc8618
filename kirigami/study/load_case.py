"""What is done to a sheet: one plain description for :func:`kirigami.stretch`, the command line and the case file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from typing import Any

from kirigami.errors import ModelError
from kirigami.primitives.checks import (
    require_boolean,
    require_finite,
    require_items,
    require_mapping,
    require_not_negative,
    shown,
)
from kirigami.primitives.node import AXES
from kirigami.study.grips import pull_direction
from kirigami.study.places import Place, place
from kirigami.words import counted

STRAIN = 0.2  # what a sheet is pulled by where nothing is said
MOST_TURNS = 100  # of a grip


@dataclass(frozen=True, eq=False, init=False)
class LoadCase:
    """What is done to a sheet: its grips pulled, pushed, sheared or twisted, places lifted, others held.

    Everything grows with the load factor, in one way from nothing to the whole. The two grips lie at the ends of the
    sheet along `direction`, as :func:`kirigami.stretch` says; they are there where a strain, a shear or a twist is
    asked for. What is lifted may move in the plane. Where neither grips nor `hold` are given, the rim is held.

    Parameters
    ----------
    strain : float, optional
        Displacement of the moved grip over the free length; negative to push. None takes 20 %, or nothing where another
        motion is given; 0 lets the weight act alone.
    direction : "x", "y" or float
        From the held grip to the moved one: an axis, or an angle in degrees from x, counter-clockwise.
    grip : float, optional
        Length of the strips that are held [length]; 0 holds the edges alone. None as for :func:`kirigami.stretch`.
    shear : float
        Displacement of the moved grip across the pull over the free length, towards larger x (larger y for a pull along
        x).
    twist : float
        Turn of the moved grip about the axis of the pull through its middle [degrees], right-handed about the direction
        of the pull.
    lift : mapping or sequence of pairs (place, float)
        Places and how far up each is lifted [length]; negative pushes down. Places as for
        :func:`kirigami.study.place`.
    hold : place, or mapping or sequence of pairs (place, str)
        Places that are held, and how: "clamp" (the default), which keeps their direction too where they hold edges or
        facets, or axes out of "xyz".
    weight : float
        Acceleration by which the sheet's own weight acts, downwards [length / time^2]: 9.81 in SI units, for a material
        with a density; 0 for none. From the start; where nothing is moved it grows with the load factor.
    cycle : bool
        Go there and back again.

    Raises
    ------
    ModelError
        What makes no sense: nothing asked for, a strain of -100 %, no such place, a place that is lifted twice.

    Examples
    --------
    >>> import kirigami as kg
    >>> kg.LoadCase(strain=0.1, shear=0.05).gripped, kg.LoadCase(lift={"centre": 0.04}, hold="rim").gripped
    (True, False)
    """

    strain: float
    direction: str | float
    grip: float | None
    shear: float
    twist: float
    lift: tuple[tuple[Place, float], ...]
    hold: tuple[tuple[Place, str], ...]
    weight: float
    cycle: bool

    def __init__(
        self,
        strain: float | None = None,
        direction: str | float = "y",
        grip: float | None = None,
        *,
        shear: float = 0.0,
        twist: float = 0.0,
        lift: Mapping[Any, float] | Iterable[tuple[Any, float]] = (),
        hold: Any = (),
        weight: float = 0.0,
        cycle: bool = False,
    ) -> None:
        pull_direction(direction)
        lifted = tuple(
            (place(where), require_finite(by, "how far a place is lifted", "LoadCase"))
            for where, by in _pairs(lift, "lift")
        )
        held = tuple((place(where), _way(how)) for where, how in _pairs(hold, "hold", "clamp"))
        shear = require_finite(shear, "shear", "LoadCase")
        twist = require_finite(twist, "twist", "LoadCase")
        for where, by in lifted:
            if by == 0:
                raise ModelError(f"LoadCase: {where.text} is lifted by nothing: hold it, or say how far")
        if abs(twist) > 360 * MOST_TURNS:
            raise ModelError(
                f"LoadCase: a twist of {counted(twist, 'degree', spec='.6g')} is more than {MOST_TURNS} turns"
            )
        weight = require_not_negative(weight, "weight", "LoadCase")
        moved = bool(lifted or shear or twist)
        if strain is None:
            strain = 0.0 if moved else STRAIN
        strain = require_finite(strain, "strain", "LoadCase")
        if strain == 0 and not moved and not weight:
            raise ModelError("stretch: strain must be a number other than zero: negative to push, positive to pull")
        if strain <= -1:
            raise ModelError(f"stretch: a strain of {100 * strain:.6g} % would push one grip through the other")
        if grip is not None:
            grip = require_not_negative(grip, "grip", "stretch")
        values = {
            "strain": strain, "direction": direction, "grip": grip, "shear": shear, "twist": twist, "lift": lifted,
            "hold": held, "weight": weight, "cycle": require_boolean(cycle, "cycle", "stretch"),
        }  # fmt: skip
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @property
    def gripped(self) -> bool:
        """Whether the ends of the sheet are held in grips."""
        return bool(self.strain or self.shear or self.twist)

    @property
    def moves(self) -> bool:
        """Whether a grip or a place is moved; else the weight alone acts."""
        return bool(self.gripped or self.lift)

    @property
    def places(self) -> list[Place]:
        """All places it names."""
        return [where for where, _ in (*self.lift, *self.hold)]

    def in_drawing(self, layers: Mapping[str, Any]) -> LoadCase:
        """The same case with the shapes of the layers it names.

        Parameters
        ----------
        layers : mapping of str to shapely geometry
            The curves of a drawing by layer or colour.
        """
        values, layers = self.values(), require_mapping(layers, "layers", "LoadCase.in_drawing")
        for name in ("lift", "hold"):
            values[name] = [(where.in_drawing(layers), how) for where, how in values[name]]
        return LoadCase(**values)

    def plain(self) -> dict[str, Any]:
        """What a case file keeps: only what is not as usual, in plain numbers and text."""
        kept = {}
        for name, value in self.values().items():
            if name in ("lift", "hold"):
                key = {"lift": "by", "hold": "how"}[name]
                value = [{"at": where.plain, key: how} for where, how in value]
            said = (name == "grip" and value is not None) or (name == "strain" and not self.moves)
            if said or value not in (None, 0, [], False):
                kept[name] = value
        return kept

    @classmethod
    def from_plain(cls, kept: Any) -> LoadCase:
        """A case from what a case file keeps.

        Raises
        ------
        ModelError
            An entry that is unknown or not as it should be.
        """
        if not isinstance(kept, Mapping):
            raise ModelError(f"a load case must hold named entries, got {shown(kept)}")
        known = [item.name for item in fields(cls)]
        unknown = [str(name) for name in kept if name not in known]
        if unknown:
            raise ModelError(f"a load case has no entry {unknown[0]!r}: it has {', '.join(known)}")
        values = dict(kept)
        for name, key in (("lift", "by"), ("hold", "how")):
            entries = values.get(name, [])
            if not isinstance(entries, list):
                raise ModelError(f"{name!r} of a load case must be a list, got {shown(entries)}")
            for entry in entries:
                if not isinstance(entry, Mapping) or set(entry) != {"at", key}:
                    raise ModelError(f"each entry of {name!r} of a load case has 'at' and {key!r}, got {shown(entry)}")
            values[name] = [(entry["at"], entry[key]) for entry in entries]
        return cls(**values)

    def values(self) -> dict[str, Any]:
        """The arguments that make this case, by name."""
        return {item.name: getattr(self, item.name) for item in fields(self)}

    def __repr__(self) -> str:
        said = [f"{name}={value!r}" for name, value in self.plain_words().items()]
        return f"LoadCase({', '.join(said)})"

    def plain_words(self) -> dict[str, Any]:
        """What is not as usual, with places in words."""
        kept = {}
        for name, value in self.values().items():
            if name in ("lift", "hold"):
                value = {where.text: how for where, how in value}
            if value not in (None, 0, {}, False):
                kept[name] = value
        return kept


def _pairs(given: Any, name: str, alone: str | None = None) -> list[tuple[Any, Any]]:
    """Pairs of a place and what is done there; a place alone, or a list of them, where `alone` says what."""
    if isinstance(given, Mapping):
        return list(given.items())
    if alone is not None and (isinstance(given, (str, Place)) or hasattr(given, "geom_type")):
        return [(given, alone)]
    wrong = f"LoadCase: {name} takes pairs of a place and a length, such as {{'centre': 0.04}}, got "
    if isinstance(given, str):
        raise ModelError(wrong + shown(given))
    found = []
    for item in require_items(given, name, "LoadCase"):
        pair = isinstance(item, (tuple, list)) and len(item) == 2
        if pair and (alone is None or isinstance(item[1], str)):
            found.append((item[0], item[1]))
        elif alone is not None:
            found.append((item, alone))
        else:
            raise ModelError(wrong + shown(item))
    return found


def _way(how: Any) -> str:
    if isinstance(how, str) and (how == "clamp" or (how and set(how) <= set(AXES) and len(set(how)) == len(how))):
        return how
    raise ModelError(f"LoadCase: a place is held by 'clamp', or along axes out of 'xyz', not {shown(how)}")
