"""Drawings in the words of particular programs: read without options, or refused with an option that helps."""

# ruff: noqa: E501
from __future__ import annotations

import contextlib
import random
import re
import warnings
from pathlib import Path
from typing import Any

import made_by_programs
import pytest
from made_by_programs import INKSCAPE, NS, data, paths
from made_drawings import CORNERS, SLITS, dxf, line

import kirigami as kg
from kirigami.drawing.convert import read_drawing

MADE = made_by_programs.every()
HEAD = f'<svg {NS} width="160mm" height="120mm" viewBox="-20 -20 160 120">'
THIN, RED, BLUE = ('fill="none" stroke="#000"', 'fill="none" stroke="#f00"', 'fill="none" stroke="#00f"')


def read(made: Any, folder: Path, **options: Any) -> Any:
    """The drawing as read from a file, in millimetres."""
    if made.name.endswith(".svg"):
        pytest.importorskip("svgelements")
    path = folder / made.name
    path.write_bytes(made.text.encode())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return read_drawing(path, unit="mm", **options)


@pytest.mark.parametrize("made", MADE, ids=lambda made: made.name)
def test_drawings_of_programs(made: Any, tmp_path: Path) -> None:
    """Area, number of slits, openings and folds; the three slits that most of them have are as long as drawn."""
    drawing = read(made, tmp_path, **made.options)
    openings = [cut for cut in drawing.cuts if cut.geom_type == "Polygon"]
    assert (len(drawing.cuts) - len(openings), len(openings), len(drawing.folds)) == (
        made.slits, made.openings, made.folds,
    )  # fmt: skip
    sheet = drawing.sheet()
    assert sheet.area == pytest.approx(made.area, rel=2e-3)
    assert made.told in drawing.report
    if made.slits == 3 and made.area >= 9000 and made.name != "illustrator_symbols.svg":
        lengths = sorted(cut.length for cut in drawing.cuts if cut.geom_type == "LineString")
        assert lengths == pytest.approx(sorted(abs(b[0] - a[0]) for a, b in SLITS), rel=2e-3)


def test_they_come_from_many_programs() -> None:
    """Most drawings need no option: their unit or their roles are theirs to say, and nobody else's."""
    needing = [made.name for made in MADE if made.options]
    assert len(MADE) < 60 or len(needing) <= 5, needing


REFUSED = [  # name, text, words of the true cause
    ("two_colours.svg", HEAD + paths(1, THIN, RED) + f'<path d="{data([(100, 0), (100, 80)])}" {BLUE}/>' + "</svg>",
     "lines of 2 colours inside the outline"),
    ("one_gap.svg", HEAD + f'<path d="{data([(0, 0.5), (0, 80), (120, 80), (120, 0), (0, 0)])}" {THIN}/>' + "</svg>",
     "a gap of 0.5 mm"),
    ("two_sheets.svg", HEAD + paths(1, THIN, RED) + f'<g transform="translate(0,90)">{paths(1, THIN, RED)}</g></svg>',
     "2 outlines side by side"),
    ("all_hidden.svg", f'<svg {INKSCAPE} width="120mm" height="80mm" viewBox="0 0 120 80"><g inkscape:label="cut" '
     f'inkscape:groupmode="layer" style="opacity:0">{paths(1, THIN, THIN)}</g></svg>', "neither painted nor visible"),
    ("gaps.dxf", dxf([line((0.3, 0), (120, 0)), line((120, 0), (120, 80)), line((120, 79.8), (0, 80)), line((0, 80), (0, 0))]),
     "the outline is open"),
    ("frozen.dxf", dxf([line(a, b, "PLATE") for a, b in zip(CORNERS, [*CORNERS[1:], CORNERS[0]])], [("PLATE", 7, 1, "CONTINUOUS")]),
     "frozen"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "text", "cause"), REFUSED, ids=[name for name, *_ in REFUSED])
def test_refusals_name_the_cause_and_an_option_that_helps(name: str, text: str, cause: str, tmp_path: Path) -> None:
    """The options that stand in the message, as they stand there, read the drawing."""
    made = made_by_programs.Made(name, text)
    with pytest.raises(kg.GeometryError, match=cause) as refused:
        read(made, tmp_path)
    options: dict[str, Any] = {}
    for option, value in re.findall(r"`(\w+)=([^`]*)`", str(refused.value)):
        plain = value.strip("'\"")
        options.setdefault(option, int(plain) if plain.isdigit() else plain)
    assert options
    found = read(made, tmp_path, **options)
    assert found.sheet().area == pytest.approx(9600, rel=5e-3)


def damaged(text: str, seed: int) -> str:
    """The text cut off, with characters changed, with a piece of it twice, or with a number that is none."""
    chance = random.Random(seed)
    at = chance.randrange(len(text))
    kind = seed % 4
    if kind == 0:
        return text[:at]
    if kind == 1:
        return text[:at] + chance.choice("0123456789.-eMLZAQ<>\"'/ \n,[]{}N%") + text[at + 1 :]
    if kind == 2:
        return text[:at] + text[at : at + 40] + text[at:]
    number = chance.choice(list(re.finditer(r"-?\d+\.?\d*", text)))
    wrong = chance.choice(["1e400", "-1", "0", "nan", "1e-300", "99999999999", "1e30", ""])
    return text[: number.start()] + wrong + text[number.end() :]


@pytest.mark.parametrize("seed", range(60))
def test_damaged_files_are_read_or_refused(seed: int, tmp_path: Path) -> None:
    """No error but those of this package, whatever has happened to a file."""
    made = MADE[seed % len(MADE)]
    with contextlib.suppress(kg.KirigamiError):
        read(made_by_programs.Made(made.name, damaged(made.text, seed)), tmp_path, **made.options).sheet()


def test_values_that_a_library_repairs_are_told(tmp_path: Path) -> None:
    """A number that cannot be read becomes another one in silence: the sheet may be wrong, and that is said."""
    pytest.importorskip("ezdxf")
    path = tmp_path / "damaged.dxf"
    text = dxf([line(a, b) for a, b in zip(CORNERS, [*CORNERS[1:], CORNERS[0]])])
    assert "\n120.0\n" in text
    path.write_text(text.replace("\n120.0\n", "\n1a20.0\n", 1))
    with pytest.warns(kg.KirigamiWarning, match="damaged, .* the first: recovered .*1a20.0"), contextlib.suppress(kg.GeometryError):
        read_drawing(path, unit="mm")


def test_what_is_not_applied_is_told(tmp_path: Path) -> None:
    """A mask whose shades are not known shows everything, and degrees are no lengths."""
    pytest.importorskip("svgelements")
    masked = HEAD + f'<mask id="m"><rect width="9" height="9" fill="url(#g)"/></mask><g mask="url(#m)">{paths(1, THIN, RED)}</g></svg>'
    (tmp_path / "masked.svg").write_text(masked)
    with pytest.warns(kg.KirigamiWarning, match="mask 'm' holds nothing that is understood and is not applied"):
        read_drawing(tmp_path / "masked.svg")
    text = next(made.text for made in MADE if made.name == "qgis_projected.geojson")
    (tmp_path / "degrees.geojson").write_text(text.replace("EPSG::25832", "OGC:1.3:CRS84"))
    with pytest.warns(kg.KirigamiWarning, match="degrees of longitude"):
        read_drawing(tmp_path / "degrees.geojson")
