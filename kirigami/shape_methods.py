"""The methods of Results that measure shape and energy: each is one line over a function of `kirigami.post`.

They are a base class for the same reason as those that write files: what results are can be read without them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

from numpy.typing import ArrayLike

from kirigami.primitives.kernel import Array

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh
    from kirigami.primitives.material import Material
    from kirigami.results.results import Results
    from kirigami.results.stress import SheetStress


class ResultsShape:
    """Height, width, Poisson ratio, curvature and energy shares of :class:`kirigami.Results`."""

    def height(self) -> Array:
        """Largest minus smallest z of all nodes (s,) [length]; see :func:`kirigami.post.shape.height`."""
        from kirigami.post.shape import height

        return height(cast("Results", self).position())

    def width(self, axis: str = "y", band: float = 0.5) -> Array:
        """Mean width across the pull (s,) [length], over a band at mid height.

        Parameters
        ----------
        axis : {"y", "x"}
            Direction of the pull.
        band : float
            Height of the band over the height of the sheet; see :func:`kirigami.post.shape.width`.

        Raises
        ------
        AnalysisError
            The model was not made from a mesh.
        ModelError
            An unknown axis, or a band out of range.
        """
        from kirigami.post.shape import width

        return width(self._points("width"), self._drawn("width"), axis, band)

    def poisson_ratio(self, axis: str = "y", band: float = 0.5, strain: ArrayLike | None = None) -> Array:
        """Minus the relative change of width over the axial strain (s,); nan at steps without strain.

        Parameters
        ----------
        axis : {"y", "x"}
            Direction of the pull.
        band : float
            Height of the band over the height of the sheet; see :func:`kirigami.post.shape.poisson_ratio`.
        strain : array_like, shape (s,), optional
            What to divide by; by default the strain of the band itself.

        Raises
        ------
        AnalysisError
            The model was not made from a mesh.
        ModelError
            An unknown axis, a band out of range, or strains of another number.

        Examples
        --------
        >>> import kirigami as kg
        >>> mesh = kg.Sheet([(0, 0), (1, 0), (1, 2), (0, 2)]).mesh(0.1)
        >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e9), dim=2)
        >>> top = m.select(boundary="top")
        >>> held = m.add(kg.Fix(m.select(boundary="bottom")), kg.Fix(top, "x"), kg.Prescribe(top, y=1e-3))
        >>> bool(0.3 < kg.LinearStatic(m).run().poisson_ratio()[-1] < 0.4)  # bars make about 1/3
        True
        """
        from kirigami.post.shape import poisson_ratio

        return poisson_ratio(self._points("poisson_ratio"), self._drawn("poisson_ratio"), axis, band, strain)

    def curvature(self, kind: str = "mean", per: str = "facet") -> Array:
        """Curvature of the sheet (s, facets) or (s, nodes), from the angles of its hinges.

        Parameters
        ----------
        kind : {"mean", "gaussian", "principal", "tensor"}
            Which; see :func:`kirigami.post.curvature.curvature` for shapes and units.
        per : {"facet", "node"}
            Where.

        Raises
        ------
        AnalysisError
            The model was not made from a mesh.
        ModelError
            An unknown kind or place, or a mesh that is not flat.
        """
        from kirigami.post.curvature import curvature

        return curvature(self._points("curvature"), self._drawn("curvature"), kind, per)

    def stress(
        self, step: int | None = None, thickness: float | None = None, material: Material | None = None
    ) -> SheetStress:
        """Stress of the sheet at each facet: tensors, principal values, membrane forces and moments.

        Parameters
        ----------
        step : int, optional
            Number of one stored step; None takes all of them.
        thickness : float, optional
            Sheet thickness [length]; by default that of the model or the mesh.
        material : Material, optional
            Elastic constants; by default those of the model or the mesh.

        Returns
        -------
        SheetStress
            See :class:`kirigami.results.stress.SheetStress`.

        Raises
        ------
        AnalysisError
            The model was not made from a mesh.
        ModelError
            No such step, no thickness or material, or a mesh that is not flat.
        """
        from kirigami.results.stress import sheet_stress

        return sheet_stress(cast("Results", self), step, thickness, material)

    def plot_stress(self, step: int = -1, kind: str = "largest", fibre: str = "top", **options: Any) -> Any:
        """Draw the deformed sheet, coloured by stress.

        Parameters
        ----------
        step : int
            Number of the stored step; -1 is the last.
        kind : {"largest", "smallest", "von Mises"}
            Which: one of the principal stresses, or von Mises' [force / length^2].
        fibre : {"top", "middle", "bottom"}
            Where in the thickness.
        options
            As for :func:`kirigami.plot.plot_results`.

        Returns
        -------
        matplotlib axes

        Raises
        ------
        AnalysisError
            The model was not made from a mesh.
        ModelError
            No such step, kind or fibre, no thickness or material, or a mesh that is not flat.
        """
        from kirigami.results.stress import checked_values

        values, label = checked_values(self.stress(step), kind, fibre)
        return cast("Results", self).plot(step, color=values, **{"label": label, **options})

    def energy_shares(self) -> dict[str, Array]:
        """Energy by kind over the whole, each (s,); 0 where nothing is stored.

        Raises
        ------
        ModelError
            The structure has no elements.

        Examples
        --------
        >>> import kirigami as kg
        >>> m = kg.Model(dim=2)
        >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
        >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
        >>> kg.LinearStatic(m).run().energy_shares()["bars"].tolist()
        [0.0, 1.0]
        """
        from kirigami.post.energy import energy_shares

        return energy_shares(cast("Results", self).energy)

    def _points(self, owner: str) -> Array:
        """Positions (s, n, 3) of the nodes of the mesh, without the tips of normals."""
        return cast("Results", self).position()[:, : len(self._drawn(owner).nodes)]

    def _drawn(self, owner: str) -> TriMesh:
        """The mesh, or an AnalysisError."""
        from kirigami.errors import AnalysisError

        results = cast("Results", self)
        if results.mesh is None:
            raise AnalysisError(f"{owner} needs a model made by Model.from_mesh", results=results)
        return results.mesh
