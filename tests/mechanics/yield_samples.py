"""A plate that yields where it is bent."""

import shapely

import kirigami as kg


def lifted(rung="shell", **yields):
    mesh = kg.Sheet(shapely.box(0, 0, 0.1, 0.04)).mesh(max_edge=0.03)
    material = kg.Material(3.5e9, 0.34, yield_stress=60e6, **yields)
    m = kg.Model.from_mesh(mesh, thickness=5e-3, material=material, stiffness=rung)
    right = m.select(boundary="right")
    m.add(kg.Fix(m.select(boundary="left"), clamp=True), kg.Prescribe(right, z=0.06))
    return m, right
