"""What a curve is for: told by the user, by the name of its layer, by its line type, or by its colour."""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

from kirigami.drawing.curves import Curve
from kirigami.errors import GeometryError
from kirigami.primitives.checks import require_items, require_text
from kirigami.words import counted

Names = str | Iterable[str] | None

# How words in the names of layers begin or end that say what a layer is for; the first row with a match wins. Words as
# they are used in English, German, French, Spanish, Italian, Portuguese and Dutch, without their accents.
WORDS = (
    ("ignore", ("defpoints", "dim", "text", "note", "construction", "guide", "title", "legend", "bemassung", "hilfs",
                "viewport", "annotation", "etch", "engrav", "gravur", "gravier", "raster", "extent", "extents",
                "tangent", "gravure", "grabado", "incisione", "cotas", "cotes", "quote", "template", "vorlage")),
    ("fold", ("fold", "folds", "crease", "creases", "score", "scoring", "mountain", "valley", "bend", "falz", "falt",
              "falten", "biege", "biegung", "rill", "knick", "pliage", "pliegue", "pliegues", "plegado", "doblez",
              "dobra", "vinco", "piega", "pieghe", "cordon", "vouw", "perfor")),
    ("outline", ("outline", "contour", "border", "boundary", "frame", "perimeter", "sheet", "umriss", "kontur",
                 "profile", "profiles", "contorno", "bordo", "perimetro", "omtrek")),
    ("cut", ("cut", "cuts", "cutting", "slit", "slits", "slot", "slots", "hole", "holes", "laser", "schnitt",
             "schnitte", "schneid", "kerf", "decoupe", "decoupes", "coupe", "corte", "cortes", "taglio", "tagli",
             "snijd", "loch", "locher")),
    ("ignore", ("center", "centre", "centerline", "mittel", "mark", "marks", "marking", "registration")),
)  # fmt: skip
EXACT = {"pli": "fold", "plis": "fold", "rand": "outline", "bord": "outline", "snij": "cut", "thrucut": "cut"}
SIDES = (
    (1.0, ("valley", "valleys", "tal", "talfalz", "talfalten", "vallee", "valle", "up")),
    (-1.0, ("mountain", "mountains", "berg", "bergfalz", "bergfalten", "montagne", "montana", "monte", "down")),
)
# Words in the names of line types; folds are drawn in dashes, centre lines in long and short ones.
LINE_TYPES = {"ignore": ("center", "centre", "mittel"), "fold": ("dash", "hidden", "phantom", "dot", "divide", "iso")}
COLORS = {
    "#000000": "black", "#ff0000": "red", "#0000ff": "blue", "#00ff00": "green", "#008000": "green",
    "#ff00ff": "magenta", "#00ffff": "cyan", "#ffff00": "yellow", "#ffffff": "white",
}  # fmt: skip


@dataclass(frozen=True)
class Row:
    """What the curves of one layer, colour and line type were taken for."""

    layer: str
    color: str
    line_type: str
    role: str
    count: int


@dataclass
class Roles:
    """Which layers (or colours) are what; None leaves it to the names of the layers."""

    outline: Names = None
    cuts: Names = None
    folds: Names = None
    ignore: Names = None
    regions: Names = None

    def of(self, curves: Sequence[Curve]) -> list[str]:
        """Role of each curve: "outline", "cut", "fold", "ignore", "region", or "" where nothing says."""
        asked: dict[str, str] = {}
        present = {name.casefold() for curve in curves for name in (curve.layer, curve.color) if name}
        for role, names in (
            ("outline", self.outline), ("cut", self.cuts), ("fold", self.folds), ("ignore", self.ignore),
            ("region", self.regions),
        ):  # fmt: skip
            for name in listed(names):
                plain = color_name(name).casefold()
                if plain not in present:
                    raise GeometryError(f"no curve is on a layer or has a colour {name!r}; there are {listing(curves)}")
                asked[plain] = role
        by_name = {curve.layer: role_of_name(curve.layer) for curve in curves}
        by_type = {curve.line_type: role_of_line_type(curve.line_type) for curve in curves}
        told = [asked.get(curve.layer.casefold()) or asked.get(curve.color.casefold()) for curve in curves]
        plain_ones = any(
            not (role or by_name[curve.layer] or by_type[curve.line_type])
            or (role or by_name[curve.layer]) in ("outline", "cut")
            for curve, role in zip(curves, told)
        )
        # Dashes tell something only beside lines without them.
        return [
            role or by_name[curve.layer] or (by_type[curve.line_type] if plain_ones else "")
            for curve, role in zip(curves, told)
        ]

    @property
    def names(self) -> set[str]:
        """All names asked for, in small letters."""
        groups = (self.outline, self.cuts, self.folds, self.ignore, self.regions)
        return {name.casefold() for group in groups for name in listed(group)}

    def settle(self, inner: Sequence[Curve], rim: Sequence[Curve]) -> tuple[list[Curve], str]:
        """The curves inside the outline that are cut, by name or because nothing speaks against it, and a note.

        Parameters
        ----------
        inner : sequence of Curve
            Those that are no folds.
        rim : sequence of Curve
            What the outline was made of.

        Raises
        ------
        GeometryError
            Lines of several colours, none of which has a role: some may be folds, and only the user knows.
        """
        unnamed = [curve for curve in inner if not curve.role]
        if listed(self.cuts):
            look = {(curve.layer, curve.color) for curve in rim}
            note = ""
            left = [curve for curve in unnamed if not (curve.closed and (curve.layer, curve.color) in look)]
            if left:
                note = (
                    f"{counted(len(left), 'curve')} inside the outline beside the cuts that were named: left out "
                    f"({listing(left)}); {proposal(left, 'folds')} folds there, {proposal(left, 'cuts')} cuts"
                )
            gone = set(map(id, left))
            return [curve for curve in inner if id(curve) not in gone], note
        lines = [curve for curve in unnamed if not curve.closed]
        colors = Counter(curve.color for curve in lines if curve.color)
        known = {curve.color for curve in inner if curve.role == "cut"}
        if len(colors.keys() - known) > 1:
            told = ", ".join(f"{name} ({number})" for name, number in colors.most_common(6))
            first, *others = (name for name, _ in colors.most_common(6))
            raise GeometryError(
                f"lines of {counted(len(colors), 'colour')} inside the outline, and nothing says which are cut and "
                f"which are folded: {told}; name them, for example `cuts={first}` "
                + " ".join(f"`folds={name}`" for name in others)
                + f" (or `ignore={others[-1]}`, or `cuts` for each of them)"
            )
        odd = [curve for curve in lines if curve.color and curve.color not in known]
        if not known or not odd:
            return list(inner), self._other_layers(lines, inner)
        return list(inner), (
            f"{listing(odd)}: cut, though nothing says so and cuts have another colour; {proposal(odd, 'folds')} folds "
            f"there, {proposal(odd, 'ignore')} leaves them out"
        )


    def _other_layers(self, lines: Sequence[Curve], inner: Sequence[Curve]) -> str:
        """A note on lines that are cut although they lie beside layers whose names say cut."""
        named = {curve.layer for curve in inner if curve.role == "cut" and curve.layer}
        odd = [curve for curve in lines if curve.layer and curve.layer not in named and not curve.role]
        if not named or not odd or listed(self.cuts):
            return ""
        return (
            f"{listing(odd)}: cut, though nothing says so and cuts have another layer; `folds={odd[0].layer!r}` folds "
            f"there, `ignore={odd[0].layer!r}` leaves them out"
        )


def proposal(curves: Sequence[Curve], option: str) -> str:
    """The option that gives these curves a role, by their colour or else their layer."""
    names = [curve.color or curve.layer for curve in curves]
    name = next((name for name in names if name), "")
    return f"`{option}={name!r}`" if name else f"`{option}`"


def listed(names: Names) -> list[str]:
    """One name, several or none as a list."""
    if names is None or isinstance(names, str):
        return [] if names is None else [names]
    wanted = require_items(names, "names of layers", "reading a drawing", GeometryError)
    return [require_text(name, "names of layers", "reading a drawing", GeometryError) for name in wanted]


def color_name(color: str) -> str:
    """The common name of a colour given as #rrggbb, else what was given."""
    return COLORS.get(color.casefold(), color)


@lru_cache(maxsize=4096)
def role_of_name(name: str) -> str:
    """The role that the name of a layer tells, or ""."""
    tokens = _tokens(name)
    for role, words in WORDS:
        if any(token.startswith(word) or token.endswith(word) for token in tokens for word in words):
            return role
    return next((EXACT[token] for token in tokens if token in EXACT), "")


def side_of_name(name: str) -> float:
    """1 where the name of a layer of folds says valley, -1 where it says mountain, else 0."""
    tokens = _tokens(name)
    return next((side for side, words in SIDES if any(token in words for token in tokens)), 0.0)


def _tokens(name: str) -> list[str]:
    """The words of a name, in small letters without accents."""
    bare = "".join(letter for letter in unicodedata.normalize("NFKD", name) if not unicodedata.combining(letter))
    return re.findall(r"[^\W\d_]+", re.sub(r"([a-z])([A-Z])", r"\1 \2", bare).casefold())


@lru_cache(maxsize=256)
def role_of_line_type(name: str) -> str:
    """The role that a line type tells, or ""."""
    plain = name.casefold()
    return next((role for role, words in LINE_TYPES.items() if any(word in plain for word in words)), "")


def listing(curves: Sequence[Curve]) -> str:
    """Layers and colours with their numbers of curves, for messages."""
    parts = []
    for kind, names in (("layer", [c.layer for c in curves]), ("colour", [c.color for c in curves])):
        parts += [f"{kind} {name!r} ({number})" for name, number in Counter(filter(None, names)).most_common(12)]
    return ", ".join(parts) or "neither layers nor colours"


def table_of(curves: Sequence[Curve], became: dict[int, str]) -> tuple[Row, ...]:
    """Rows of what curves became, in the order of the drawing; those that became nothing are left out."""
    rows = Counter(
        (curve.layer, curve.color, curve.line_type, became.get(number, "left out"))
        for number, curve in enumerate(curves)
    )
    return tuple(Row(*key, count) for key, count in rows.items())


def table_lines(rows: Sequence[Row]) -> list[str]:
    """The table as lines of text."""
    if not rows:
        return []
    head = ("layer", "colour", "line type", "curves", "taken as")
    cells = [(row.layer or "-", row.color or "-", row.line_type or "-", str(row.count), row.role) for row in rows]
    wide = [max(len(line[k]) for line in (head, *cells)) for k in range(len(head))]
    return ["  ".join(word.ljust(width) for word, width in zip(line, wide)).rstrip() for line in (head, *cells)]
