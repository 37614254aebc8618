"""One unit of length on a page, in a picture and in a report: that of the sheet's size."""

import re

import numpy as np
import pytest
import shapely
from matplotlib import pyplot

import kirigami as kg
from kirigami import plot
from kirigami.drawing.drawing import Drawing
from kirigami.io.html import _contents, titled_curves
from kirigami.scale import Scale
from kirigami.study.report_picture import pictures

LENGTH = re.compile(r"(?<![A-Za-z/])(um|mm|cm|m)(?:2|²|\$\^2\$)?(?![A-Za-z/\d$²^])")  # also that of areas and moments
SIZES = {2.0: "m", 0.2: "mm"}


def case(motion, size):
    if motion == "lift":  # a point told by numbers, by far less than the size
        return kg.LoadCase(lift={(0.25 * size, 0.5 * size): 1e-3 * size})
    return kg.LoadCase(twist=2.0)


@pytest.fixture(autouse=True)
def closed():
    yield
    pyplot.close("all")


@pytest.fixture(scope="module", params=[(2.0, "twist"), (0.2, "lift")])
def report(request):
    size, motion = request.param
    cut = shapely.LineString([(0.4 * size, 0.3 * size), (0.6 * size, 0.3 * size)])
    drawing = Drawing(shapely.box(0, 0, size, 0.8 * size), (cut,), unit="m")
    return kg.study.stretch_drawing(
        drawing, thickness=5e-4 * size, E="3GPa", case=case(motion, size), accuracy="draft", max_edge=0.2 * size,
        stiffness="facet", imperfection=1e-4 * size,
    )  # fmt: skip


def unit_of(report):
    return SIZES[report.results.mesh.size]


def lengths(*texts):
    """The units of length in some texts."""
    return {found for text in texts for found in LENGTH.findall(text)}


def test_a_report_speaks_in_one_unit(report):
    material = [words for words in report.notes if words.startswith("thickness")]  # a sheet of 2 m is 1 mm thick
    notes = [words for words in report.notes if words not in material]
    assert lengths(report.text(), *notes) == {unit_of(report)}


def test_a_page_speaks_in_one_unit(report):
    results, scale = report.results, Scale(unit_of(report))
    curves = titled_curves(results)
    head, _ = _contents(results, np.arange(len(results)))
    assert lengths(*curves, f"[{head['unit']}]") == {unit_of(report)}
    height = next(values for title, values in curves.items() if title.startswith("height"))
    assert np.array(height) * scale.unit("length")[1] == pytest.approx(results.height(), rel=1e-12)
    area = next(values for title, values in curves.items() if title.startswith("open area"))
    assert np.array(area) * scale.unit("area")[1] == pytest.approx(results.open_area().sum(axis=1), rel=1e-12)
    answer = next(values for title, values in curves.items() if title.startswith(report.drive.takes(scale)))
    assert np.array(answer) * scale.unit(report.drive.answer_kind)[1] == pytest.approx(report.force, rel=1e-12)


def labels(ax):
    """What the axes of a figure and its colour bar say."""
    return [axis.get_label_text() for one in ax.figure.axes for axis in (one.xaxis, one.yaxis)]


def test_pictures_speak_in_one_unit(report):
    results = report.results
    node = int(np.abs(results.u[-1]).sum(axis=1).argmax())
    drawn = [draw() for draw in pictures(report).values()]
    drawn += [
        results.plot(view="top"), results.plot(color="height"), results.plot(color="displacement"),
        results.plot_curve(), results.plot_curve(x=(node, "z"), nodes=[node]),
        plot.plot_open_area(results, x=(node, "z")),
        plot.plot_energy_shares(results, x=(node, "z")), plot.plot_measure(results, results.lam, x=(node, "z")),
    ]  # fmt: skip
    assert lengths(*(text for ax in drawn for text in labels(ax) if "J" not in text)) == {unit_of(report)}


def test_ticks_are_in_the_unit_of_the_label(report):
    results, factor = report.results, Scale(unit_of(report)).unit("length")[1]
    ax = results.plot(view="top")
    ax.figure.canvas.draw()
    told = [float(label.get_text().replace("\N{MINUS SIGN}", "-")) for label in ax.get_xticklabels()]
    assert np.array(told) * factor == pytest.approx(ax.get_xticks(), rel=1e-5, abs=1e-9)


def test_without_units_none_are_told(report):
    results = report.results
    results.units = ""
    try:
        assert not lengths(*titled_curves(results), *labels(results.plot_curve()), *labels(results.plot(view="top")))
    finally:
        results.units = "SI"


def test_a_scale_holds_together():
    """Area and torque are those of its unit of length, whatever the size."""
    for size in (3e-6, 2e-4, 0.02, 0.7, 1.0, 40.0):
        scale = Scale.of(size)
        (length, one), (area, square), (torque, moment) = map(scale.unit, ("length", "area", "torque"))
        assert (area, torque) == (f"{length}2", f"N {length}") and square == one**2 and moment == one
        number, unit = scale.show(size, "length", 6).split()
        assert unit == length and float(number) * one == pytest.approx(size)
