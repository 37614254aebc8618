"""The methods of Sheet, Results and Model that read and write files: each is one line over a function of this package.

They are base classes so that what a sheet, a result and a model are can be read without them, and each imports its
module, and the library that module needs, only when it is called.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    from kirigami.geometry.sheet import Sheet
    from kirigami.model.model import Model
    from kirigami.primitives.material import Material
    from kirigami.results.results import Results

PathLike = str | os.PathLike[str]


class SheetFiles:
    """Reading and writing of :class:`kirigami.Sheet`."""

    @classmethod
    def from_dxf(
        cls, path: PathLike, thickness: float | None = None, material: Material | None = None, **options: Any
    ) -> Sheet:
        """Read a sheet from a DXF drawing of any version.

        Parameters
        ----------
        path : path
            The file.
        thickness : float, optional
            Thickness, in the unit of the sheet [m].
        material : Material, optional
            Of the sheet.
        **options
            Of :func:`kirigami.drawing.dxf.read_dxf`: layers of outline, cuts and folds, units, tolerances.

        Raises
        ------
        GeometryError
            The drawing cannot be read, or has no closed outline.
        KirigamiError
            ezdxf is not installed.

        Examples
        --------
        >>> import kirigami as kg, shapely, tempfile
        >>> path = Path(tempfile.mkdtemp()) / "plate.dxf"
        >>> file = kg.Sheet(shapely.box(0, 0, 0.2, 0.1), [[(0.05, 0.05), (0.15, 0.05)]]).to_dxf(path)
        >>> kg.Sheet.from_dxf(file, thickness=1e-4, cuts="CUTS")
        Sheet(0.2 x 0.1, area 0.02, 1 slit, 0 openings)
        """
        from kirigami.drawing.dxf import read_dxf

        return read_dxf(path, **options).sheet(thickness, material)

    @classmethod
    def from_svg(
        cls, path: PathLike, thickness: float | None = None, material: Material | None = None, **options: Any
    ) -> Sheet:
        """Read a sheet from an SVG drawing.

        Parameters
        ----------
        path : path
            The file.
        thickness : float, optional
            Thickness, in the unit of the sheet [m].
        material : Material, optional
            Of the sheet.
        **options
            Of :func:`kirigami.drawing.svg.read_svg`: layers or colours of outline, cuts and folds, units, tolerances.

        Raises
        ------
        GeometryError
            The drawing cannot be read, or has no closed outline.
        KirigamiError
            svgelements is not installed.

        Examples
        --------
        >>> import kirigami as kg, shapely, tempfile
        >>> path = Path(tempfile.mkdtemp()) / "plate.svg"
        >>> file = kg.Sheet(shapely.box(0, 0, 0.2, 0.1), [[(0.05, 0.05), (0.15, 0.05)]]).to_svg(path)
        >>> kg.Sheet.from_svg(file, cuts="red")
        Sheet(0.2 x 0.1, area 0.02, 1 slit, 0 openings)
        """
        from kirigami.drawing.svg import read_svg

        return read_svg(path, **options).sheet(thickness, material)

    @classmethod
    def from_geojson(
        cls, path: PathLike, thickness: float | None = None, material: Material | None = None, **options: Any
    ) -> Sheet:
        """Read a sheet from GeoJSON features or geometries.

        Parameters
        ----------
        path : path
            The file.
        thickness : float, optional
            Thickness, in the unit of the sheet [m].
        material : Material, optional
            Of the sheet.
        **options
            Of :func:`kirigami.drawing.geojson.read_geojson`: roles of the features, units, tolerance.

        Raises
        ------
        GeometryError
            The file cannot be read, or has no closed outline.

        Examples
        --------
        >>> import kirigami as kg, shapely, tempfile
        >>> file = kg.Sheet(shapely.box(0, 0, 2, 1)).to_geojson(Path(tempfile.mkdtemp()) / "plate.geojson")
        >>> kg.Sheet.from_geojson(file)
        Sheet(2 x 1, area 2, 0 slits, 0 openings)
        """
        from kirigami.drawing.geojson import read_geojson

        return read_geojson(path, **options).sheet(thickness, material)

    @classmethod
    def from_fold(
        cls, path: PathLike, thickness: float | None = None, material: Material | None = None, **options: Any
    ) -> Sheet:
        """Read a sheet from the crease pattern of a FOLD file.

        Parameters
        ----------
        path : path
            The file.
        thickness : float, optional
            Thickness, in the unit of the sheet [m].
        material : Material, optional
            Of the sheet.
        **options
            Of :func:`kirigami.drawing.fold.read_fold`: which creases are folds, units, tolerance.

        Raises
        ------
        GeometryError
            The file cannot be read, or has no outline.

        Examples
        --------
        >>> import kirigami as kg, shapely, tempfile
        >>> plate = kg.Sheet(shapely.box(0, 0, 2, 1), [[(0.5, 0.5), (1.5, 0.5)]])
        >>> kg.Sheet.from_fold(plate.to_fold(Path(tempfile.mkdtemp()) / "plate.fold"))
        Sheet(2 x 1, area 2, 1 slit, 0 openings)
        """
        from kirigami.drawing.fold import read_fold

        return read_fold(path, **options).sheet(thickness, material)

    def to_dxf(self, path: PathLike, **options: Any) -> Path:
        """Write the sheet for the laser cutter as DXF: true size, outline and cuts on layers of their own.

        Parameters
        ----------
        path : path
            The file.
        **options
            Of :func:`kirigami.drawing.dxf.write_dxf`: unit of the sheet, unit of the file, folds.

        Raises
        ------
        KirigamiError
            ezdxf is not installed, the unit is unknown, the file cannot be written.

        Examples
        --------
        >>> import kirigami as kg, shapely, tempfile
        >>> file = kg.Sheet(shapely.box(0, 0, 2, 1)).to_dxf(Path(tempfile.mkdtemp()) / "plate.dxf", drawn_in="cm")
        >>> kg.Sheet.from_dxf(file).bounds
        (0.0, 0.0, 2.0, 1.0)
        """
        from kirigami.drawing.dxf import write_dxf

        return write_dxf(self, path, **options)

    def to_svg(self, path: PathLike, **options: Any) -> Path:
        """Write the sheet for the laser cutter as SVG: true size, a layer and a colour for each kind of line.

        Parameters
        ----------
        path : path
            The file.
        **options
            Of :func:`kirigami.drawing.svg.write_svg`: unit of the sheet, unit of the file, folds.

        Raises
        ------
        KirigamiError
            The unit is unknown, the file cannot be written.

        Examples
        --------
        >>> import kirigami as kg, shapely, tempfile
        >>> file = kg.Sheet(shapely.box(0, 0, 0.2, 0.1)).to_svg(Path(tempfile.mkdtemp()) / "plate.svg")
        >>> kg.Sheet.from_svg(file).bounds
        (0.0, 0.0, 0.2, 0.1)
        """
        from kirigami.drawing.svg import write_svg

        return write_svg(self, path, **options)

    def to_geojson(self, path: PathLike, **options: Any) -> Path:
        """Write outline and cuts as GeoJSON features with the property "role".

        Parameters
        ----------
        path : path
            The file.
        **options
            Of :func:`kirigami.drawing.geojson.write_geojson`: unit of the sheet, folds.

        Raises
        ------
        KirigamiError
            The file cannot be written.

        Examples
        --------
        >>> import kirigami as kg, shapely, tempfile
        >>> kg.Sheet(shapely.box(0, 0, 2, 1)).to_geojson(Path(tempfile.mkdtemp()) / "plate.geojson").name
        'plate.geojson'
        """
        from kirigami.drawing.geojson import write_geojson

        return write_geojson(self, path, **options)

    def to_fold(self, path: PathLike, **options: Any) -> Path:
        """Write the sheet as a FOLD crease pattern: edges assigned B are the outline, C the cuts.

        Parameters
        ----------
        path : path
            The file.
        **options
            Of :func:`kirigami.drawing.fold.write_fold`: unit of the sheet, folds.

        Raises
        ------
        KirigamiError
            The file cannot be written.

        Examples
        --------
        >>> import kirigami as kg, shapely, tempfile
        >>> kg.Sheet(shapely.box(0, 0, 2, 1)).to_fold(Path(tempfile.mkdtemp()) / "plate.fold").name
        'plate.fold'
        """
        from kirigami.drawing.fold import write_fold

        return write_fold(self, path, **options)


class ResultsFiles:
    """Writing of :class:`kirigami.Results`."""

    def to_html(self, path: PathLike, **options: Any) -> Path:
        """Write a page of its own: the sheet turns under the mouse, a slider runs the load, curves move along.

        Parameters
        ----------
        path : path
            The file.
        **options
            Of :func:`kirigami.io.html.to_html`: reactions to draw, largest number of frames, title.

        Raises
        ------
        AnalysisError
            There are no steps.
        KirigamiError
            plotly is not installed, or the file cannot be written.

        Examples
        --------
        >>> import kirigami as kg, tempfile
        >>> m = kg.Model(dim=2)
        >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
        >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
        >>> kg.LinearStatic(m).run().to_html(Path(tempfile.mkdtemp()) / "bar.html", title="A bar").name
        'bar.html'
        """
        from kirigami.io.html import to_html

        return to_html(cast("Results", self), path, **options)

    def to_csv(self, path: PathLike, **options: Any) -> Path:
        """Write load factor, energies, reactions and other curves, one row per step, every digit kept.

        Parameters
        ----------
        path : path
            The file.
        **options
            Of :func:`kirigami.io.table.to_csv`: supports whose reactions are written.

        Raises
        ------
        AnalysisError
            There are no steps.
        KirigamiError
            The file cannot be written.

        Examples
        --------
        >>> import kirigami as kg, tempfile
        >>> m = kg.Model(dim=2)
        >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
        >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
        >>> file = kg.LinearStatic(m).run().to_csv(Path(tempfile.mkdtemp()) / "bar.csv", reactions={"left": a})
        >>> file.read_text().splitlines()[0]
        'step,load_factor,stable,residual,energy_bars,reaction_left_x,reaction_left_y'
        """
        from kirigami.io.table import to_csv

        return to_csv(cast("Results", self), path, **options)

    def to_surface(self, path: PathLike, **options: Any) -> Path:
        """Write the deformed sheet as a surface for other programs: .stl, .obj, .ply, .glb or .gltf.

        Parameters
        ----------
        path : path
            The file; its ending says how.
        **options
            Of :func:`kirigami.io.surface.write_surface`: which step.

        Raises
        ------
        AnalysisError
            The model has no mesh, or there is no such step.
        ModelError
            Another ending.
        KirigamiError
            trimesh is not installed, or the file cannot be written.

        Examples
        --------
        >>> import kirigami as kg, tempfile
        >>> mesh = kg.TriMesh([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]])
        >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e6))
        >>> held = m.add(kg.Fix(m.nodes[:2]), kg.Fix(m.nodes[2], "xy"), kg.Prescribe(m.nodes[2], z=0.5))
        >>> kg.LinearStatic(m).run().to_surface(Path(tempfile.mkdtemp()) / "sheet.stl").name
        'sheet.stl'
        """
        from kirigami.io.surface import write_surface

        return write_surface(cast("Results", self), path, **options)

    def to_vtk(self, folder: PathLike) -> list[Path]:
        """Write a VTK series that ParaView animates (see :func:`kirigami.io.vtk.write_vtk`)."""
        from kirigami.io.vtk import write_vtk

        return write_vtk(cast("Results", self), folder)

    def to_xarray(self) -> Any:
        """The results as an xarray.Dataset (see :func:`kirigami.io.table.to_xarray`)."""
        from kirigami.io.table import to_xarray

        return to_xarray(cast("Results", self))


class ModelFiles:
    """Handing over of :class:`kirigami.Model` to shell codes."""

    def to_abaqus(self, path: PathLike, **options: Any) -> Path:
        """Write the same sheet as a shell model, ready to run in Abaqus or CalculiX.

        Parameters
        ----------
        path : path
            The file, by custom ending in .inp.
        **options
            Of :func:`kirigami.io.abaqus.to_abaqus`: load factors to reach, increments, element.

        Raises
        ------
        ModelError
            The model has no mesh or holds what a shell model has not, or an option is wrong.
        KirigamiError
            The file cannot be written.

        Examples
        --------
        >>> import kirigami as kg, tempfile
        >>> mesh = kg.TriMesh([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]])
        >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e9))
        >>> held = m.add(kg.Fix(m.select(boundary="bottom")), kg.Prescribe(m.select(boundary="top"), y=0.1))
        >>> "*NODE" in m.to_abaqus(Path(tempfile.mkdtemp()) / "square.inp", element="S6").read_text()
        True
        """
        from kirigami.io.abaqus import to_abaqus

        return to_abaqus(cast("Model", self), path, **options)

    def to_openseespy(self, path: PathLike, **options: Any) -> Path:
        """Write the same sheet as a Python script of a shell model, ready to run with OpenSeesPy.

        Parameters
        ----------
        path : path
            The file, by custom ending in .py.
        **options
            Of :func:`kirigami.io.opensees.to_openseespy`: load factors to store, increments.

        Raises
        ------
        ModelError
            The model has no mesh or holds what a shell model has not, or an option is wrong.
        KirigamiError
            The file cannot be written.

        Examples
        --------
        >>> import kirigami as kg, tempfile
        >>> mesh = kg.TriMesh([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]])
        >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e9))
        >>> held = m.add(kg.Fix(m.select(boundary="bottom")), kg.Prescribe(m.select(boundary="top"), y=0.1))
        >>> "import openseespy" in m.to_openseespy(Path(tempfile.mkdtemp()) / "square.py").read_text()
        True
        """
        from kirigami.io.opensees import to_openseespy

        return to_openseespy(cast("Model", self), path, **options)
