"""Isobe and Okumura, Initial rigid response and softening transition of highly stretchable kirigami sheet materials,
Scientific Reports 6, 24758 (2016), and their measurements of 2019 as digitised by others.

A ribbon 35 x 110 x 1 mm of E = 7.9 MPa with 21 rows of slits, 30 mm long and 5 mm apart, pulled by up to 39.5 mm.
"""

import numpy as np
import shapely
from case import Bound, Case, Found, each_rung

import kirigami as kg

FORCE = np.array([[20.0, 0.1505], [30.0, 0.162], [39.5, 0.175]])
HINGES = "hinges resist the twisting of ligaments, more so the finer the mesh is"


def ribbon():
    """Rows in turn with one slit in the middle and two from the rims; bridges of 5 mm between rows' slits."""
    slits = []
    for row in range(21):
        y = 5.0 + 5.0 * row
        ends = [(2.5, 32.5)] if row % 2 == 0 else [(0.0, 15.0), (20.0, 35.0)]
        slits += [shapely.LineString([(left, y), (right, y)]) for left, right in ends]
    return kg.Sheet(shapely.box(0, 0, 35, 110), slits, thickness=1.0, material=kg.Material(7.9, 0.3))


def pulled(rung, nodes=4000):
    model = kg.Model.from_mesh(ribbon().mesh(nodes=nodes), stiffness=rung)
    model.imperfect()
    bottom, top = model.select(boundary="bottom"), model.select(boundary="top")
    model.add(kg.Fix(bottom, clamp=True), kg.Prescribe(top, x=0, y=39.5, z=0, clamp=True))
    results = kg.DisplacementControl(model, targets=FORCE[:, 0] / 39.5).run()
    rows = [results.nearest(way / 39.5) for way in FORCE[:, 0]]
    return Found(results.reaction(top, "y")[rows], results)


CASES = [
    Case("ribbon pulled open, measured", FORCE[:, 1], "force at 20, 30 and 39.5 mm", pulled,
         {"shell": Bound(0.1, long=True), "facet": Bound(0.1, long=True),
          "plate": Bound(0.4, HINGES, long=True)}, FORCE[:, 0], axis="elongation [mm]",
         holds=0.1, most=4200),
]  # fmt: skip


@each_rung(CASES)
def test_measured(case, rung):
    case.check(rung)
