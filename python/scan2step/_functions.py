"""The functions: convert, inspect, check."""

from __future__ import annotations

import json
import os
import tempfile
from typing import Any, Callable, Dict, Optional, Sequence, Tuple, Union

from . import _scan2step
from ._assembly import Assembly
from ._conversion import Conversion
from ._errors import FileError, OptionError
from ._scan import Path, scan_of

Place = Union[int, Sequence[float]]


def convert(
    scan: Any,
    faces: Any = None,
    *,
    shape: str = "auto",
    tolerance: Optional[float] = None,
    units: Optional[str] = None,
    name: Optional[str] = None,
    component: Union[str, int] = "auto",
    surfaces: str = "auto",
    keep_polygons: bool = False,
    regularize: bool = False,
    bias: Optional[float] = None,
    align: bool = False,
    edges: Union[str, float] = "auto",
    face_count: Optional[int] = None,
    handles: Optional[float] = None,
    weld: Optional[float] = None,
    remesh: bool = False,
    keep_fills: bool = False,
    fill_only_holes_below: Optional[float] = None,
    smooth: Union[str, float] = "auto",
    outliers: float = 0.0,
    rim_tolerance: Optional[float] = None,
    outer: Optional[Place] = None,
    corners: Optional[Sequence[Place]] = None,
    boundary_corners: Union[str, Sequence[Place]] = "auto",
    outline: str = "auto",
    map: str = "least-stretch",
    fit: str = "refined",
    kappa: Optional[float] = None,
    depth: Optional[int] = None,
    net: Optional[Tuple[int, int]] = None,
    max_net: Optional[int] = None,
    box: Optional[Tuple[Sequence[float], Sequence[float]]] = None,
    above: Optional[Sequence[float]] = None,
    remove_plane: bool = False,
    spacing: Optional[float] = None,
    max_points: Optional[int] = None,
    scan_number: Optional[int] = None,
    origin: str = "local",
    parts: Optional[str] = None,
    strict: bool = False,
    up: str = "keep",
    threads: Optional[int] = None,
    max_memory: Optional[int] = None,
    progress: Optional[Callable[[str, float], Any]] = None,
) -> Conversion:
    """Converts a scan to a face, a shell or a solid.

    The options are those of the program's ``convert``, with ``_`` for ``-``; ``face_count`` is its
    ``--faces``, and ``scan_number`` its ``--scan``. Lengths are millimetres.

    :param scan: a path; a :class:`Scan`; an array (n, 3) of points; or a mesh or cloud of trimesh,
        Open3D, PyVista or FreeCAD.
    :param faces: the faces (m, 3) if ``scan`` is an array of vertices.
    :param shape: ``"face"``, ``"shell"``, ``"solid"``, or ``"auto"`` for what suits the scan.
    :param tolerance: the farthest that a smoothed point may be from the result. Without, it follows
        from the noise of the scan. A missed tolerance is no error: see
        :attr:`Conversion.tolerance_met`.
    :param units: the unit of the scan's numbers: ``"mm"``, ``"cm"``, ``"m"``, ``"in"``, ``"ft"``.
        Without, what the file declares, else mm.
    :param name: the part's name in CAD files. Without, the name of the scan's file.
    :param component: ``"largest"``, ``"all"``, or a number (0 is the largest). ``"auto"`` takes every closed piece of a
        mesh that a CAD program made, and otherwise the largest.
    :param surfaces: ``"auto"`` finds planes, cylinders, cones, spheres and tori on such a mesh; ``"spline"`` makes
        B-splines.
    :param keep_polygons: leave prisms of few sides flat where a cylinder has all their corners.
    :param align: turn a part so that its main plane lies in z = 0 and its main axis is one of the world; ``placement`` has the
        matrix.
    :param bias: the size of systematic errors of the scanner in mm, which neighbouring points share.
    :param regularize: make radii, angles and distances of planes in the scan of a part round where that is within two standard deviations.
    :param edges: where exact faces end. ``"auto"``: where another surface begins; an angle in degrees: also at every edge
        of the mesh that turns by more; ``"off"``: nowhere, so that the faces are B-splines.
    :param face_count: about how many faces a solid or a shell gets.
    :param handles: cut handles whose loop is not longer, and close them. Without: a few edges.
    :param weld: join points on the rims of a mesh that are no farther from each other; 0 joins none. Without: a
        thousandth of the edges there.
    :param remesh: lay new triangles through the points of a mesh, which joins meshes that overlap.
    :param keep_fills: fill all holes, and cut none out.
    :param fill_only_holes_below: fill holes whose rim is shorter, and cut out the others.
    :param smooth: the support of the smoothing, ``"auto"`` or ``"off"``.
    :param outliers: the share of points, from 0 to below 1, that may exceed the tolerance.
    :param rim_tolerance: the farthest that a trim loop may be from the measured rim.
    :param outer: a vertex or a point on the outer boundary.
    :param corners: four vertices or points of the outer boundary.
    :param box: leave out what is outside of a box between two places in the scan's own numbers.
    :param above: leave out what is not above a plane ``(a, b, c, d)``: a x + b y + c z > d.
    :param remove_plane: leave out the largest plane that has the rest of the scan on one side: the turntable.
    :param spacing: thin a cloud to this distance between neighbours.
    :param origin: ``"local"``, or ``"keep"`` to put the result of a far scan where the scan is.
    :param parts: of a file with several: ``"keep"``, each once, placed as in the file: the result is an
        :class:`Assembly`; ``"merge"``, all as one mesh. Without, they are kept if all meshes are closed.
    :param strict: a part that cannot be converted is an error. Without, it is left out and has an ``error``.
    :param up: ``"z"`` or ``"y"`` turns a mesh so that this axis points up; ``"keep"`` leaves the numbers.
    :param threads: how many threads share the work. The result does not depend on it.
    :param max_memory: the number of bytes that the conversion may need.
    :param progress: is called with the name of a stage and the share of it that is done, on the
        calling thread. What it raises stops the conversion and is raised again.
    :raises FileError: the scan cannot be read.
    :raises OptionError: an option cannot be.
    :raises ScanError: the scan cannot be converted; ``point`` says where.
    :raises TypeError: the arrays are not those of a scan.

    >>> import numpy as np
    >>> import scan2step
    >>> x, y = np.meshgrid(np.arange(20.0), np.arange(20.0))
    >>> points = np.stack([x, y, 0.02 * x**2], axis=-1).reshape(-1, 3)
    >>> at = np.arange(400).reshape(20, 20)
    >>> a, b, c, d = (at[i:19 + i, j:19 + j].ravel() for i, j in ((0, 0), (0, 1), (1, 1), (1, 0)))
    >>> made = scan2step.convert(points, np.stack([a, b, c, d], axis=1), tolerance=0.05)
    >>> made.kind, made.tolerance_met, len(made.faces)
    ('face', True, 1)
    """
    options: Dict[str, Any] = {
        key: value
        for key, value in locals().items()
        if key not in ("scan", "faces", "progress", "name", "parts", "strict", "up")
    }
    if parts not in (None, "keep", "merge"):
        raise OptionError(f"parts: {parts!r} is not keep or merge", "name one of them", option="parts")
    read = scan_of(scan, faces)._made
    if up != "keep":
        read = read.turned(up)
    read = _taken(read, remesh)
    if keep_fills and fill_only_holes_below is not None:
        raise OptionError(
            "fill_only_holes_below: keep_fills fills all holes",
            "name one of the two",
            option="fill_only_holes_below",
        )
    options["name"] = part_name(read.file) if name is None else name
    names_place = (
        outer is not None
        or corners is not None
        or not isinstance(boundary_corners, str)
        or isinstance(component, int)
    )
    if parts == "keep" and names_place:
        raise OptionError("parts: a place or a component of one mesh is named", "leave it out", option="parts")
    if parts != "merge" and read.place_count > 1 and not names_place:
        chosen = (parts == "keep", strict, up)
        assembly = _scan2step.convert_parts(read, options, chosen, progress)
        if assembly is not None:
            return Assembly(assembly, options["name"])
    return Conversion(_scan2step.convert(read, options, progress), options["name"])


def inspect(
    scan: Any,
    faces: Any = None,
    *,
    units: Optional[str] = None,
    component: Union[str, int] = "largest",
    outer: Optional[Place] = None,
    handles: Optional[float] = None,
    weld: Optional[float] = None,
    remesh: bool = False,
    box: Optional[Tuple[Sequence[float], Sequence[float]]] = None,
    above: Optional[Sequence[float]] = None,
    remove_plane: bool = False,
    spacing: Optional[float] = None,
    max_points: Optional[int] = None,
    scan_number: Optional[int] = None,
    threads: Optional[int] = None,
) -> Dict[str, Any]:
    """Says what a scan is, and what :func:`convert` makes of it.

    :returns: what the program's ``inspect --json`` prints, as a dictionary: counts, components,
        boundary loops, genus, handles, noise, repairs, ``shape`` and ``faces_about``.
    :raises FileError: the scan cannot be read.
    """
    options: Dict[str, Any] = {
        key: value for key, value in locals().items() if key not in ("scan", "faces")
    }
    read = _taken(scan_of(scan, faces)._made, remesh)
    found: Dict[str, Any] = json.loads(_scan2step.inspect(read, options))
    return found


def check(
    cad: Union[Path, bytes, Conversion],
    scan: Any,
    faces: Any = None,
    *,
    units: Optional[str] = None,
    component: Union[str, int] = "largest",
    tolerance: Optional[float] = None,
    outliers: float = 0.0,
    outer: Optional[Place] = None,
    weld: Optional[float] = None,
    remesh: bool = False,
    box: Optional[Tuple[Sequence[float], Sequence[float]]] = None,
    above: Optional[Sequence[float]] = None,
    remove_plane: bool = False,
    spacing: Optional[float] = None,
    max_points: Optional[int] = None,
    scan_number: Optional[int] = None,
    origin: str = "local",
    placement: Optional[Sequence[Sequence[float]]] = None,
    threads: Optional[int] = None,
) -> Dict[str, Any]:
    """Measures a CAD file against a scan, in both directions.

    :param cad: the path of a STEP or IGES file, the bytes of a STEP file, or a :class:`Conversion`.
    :param tolerance: the largest distance that counts as good.
    :param outliers: the share of points that may exceed it.
    :param placement: the ``placement`` of a conversion with ``align=True``, which puts the scan to the part.
    :returns: what the program's ``check --json`` prints, as a dictionary.
    :raises FileError: a file cannot be read.
    """
    keys = ("units", "component", "outer", "weld", "remesh", "box", "above", "remove_plane", "spacing", "max_points", "scan_number", "origin", "threads")
    values = locals()
    options = {key: values[key] for key in keys}
    read = _taken(scan_of(scan, faces)._made, remesh)
    if isinstance(cad, Conversion):
        cad = cad.step()
    if not isinstance(cad, bytes):
        return _checked(os.fsdecode(cad), read, options, placement, tolerance, outliers)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "part.step")
        with open(path, "wb") as file:
            file.write(cad)
        try:
            return _checked(path, read, options, placement, tolerance, outliers)
        except FileError as error:
            told = str(error).replace(path, "the bytes of the CAD file")
            raise FileError(told, error.help, place=error.place) from None


def _checked(
    path: str,
    scan: _scan2step.Scan,
    options: Dict[str, Any],
    placement: Optional[Sequence[Sequence[float]]],
    tolerance: Optional[float],
    outliers: float,
) -> Dict[str, Any]:
    rows = None if placement is None else [list(row) for row in placement]
    found: Dict[str, Any] = json.loads(_scan2step.check(path, scan, options, rows, tolerance, outliers))
    return found


def _taken(scan: _scan2step.Scan, remesh: bool) -> _scan2step.Scan:
    """What is taken of a scan: all of it, or its points alone."""
    return scan.points_alone() if remesh else scan


def part_name(file: str) -> str:
    """The file's name without its folder and extensions, as the program names parts."""
    name = os.path.basename(file)
    if name.lower().endswith(".gz"):
        name = name[:-3]
    return os.path.splitext(name)[0]
