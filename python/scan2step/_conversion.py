"""What a scan became."""

from __future__ import annotations

import base64
import html
import json
import math
import os
import time
import uuid
from typing import TYPE_CHECKING, Any, Dict, List, NamedTuple, Optional, Tuple, Union

from . import _scan2step
from ._errors import FileError, OptionError

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from ._scan import Path

    Floats = npt.NDArray[np.float64]
Colour = Optional[Tuple[int, int, int]]


class Curve(NamedTuple):
    """A B-spline curve in the parameter plane of a face, or in space. A line has the degree 1."""

    #: The degree.
    degree: int
    #: The knots: (k + degree + 1,).
    knots: Floats
    #: The control points: (k, 2) in the parameter plane, or (k, 3) in mm.
    control_points: Floats


class Ellipse(NamedTuple):
    """A part of an ellipse or a circle: ``centre + cos(t) * axes[0] + sin(t) * axes[1]``."""

    #: The first and the last t.
    range: Tuple[float, float]
    #: The centre: (2,) in the parameter plane, or (3,) in mm.
    centre: Floats
    #: The half axes: (2, 2) or (2, 3).
    axes: Floats


class Surface(NamedTuple):
    """The kind of a surface and its parameters. Those that the kind does not have are ``None``."""

    #: ``"spline"``, ``"plane"``, ``"cylinder"``, ``"cone"``, ``"sphere"`` or ``"torus"``.
    kind: str
    #: A point of the plane or of the axis, or the centre, in mm.
    at: Optional[Tuple[float, float, float]] = None
    #: The normal of the plane, or the direction of the axis.
    axis: Optional[Tuple[float, float, float]] = None
    #: The radius in mm; of a cone that at ``at``, and of a torus that of its circle.
    radius: Optional[float] = None
    #: The radius of the tube of a torus in mm.
    tube_radius: Optional[float] = None
    #: The angle between the axis of a cone and its generators, in degrees.
    half_angle: Optional[float] = None


class Cylinder(NamedTuple):
    """A cylinder of a part: a bore, a shaft, a fillet or a round edge."""

    #: If it goes all around ``"bore"`` where the material is outside, or ``"shaft"``; otherwise ``"fillet"`` or ``"round"``.
    kind: str
    #: The radius in mm.
    radius: float
    #: The middle of its axis.
    at: Tuple[float, float, float]
    #: The direction of its axis.
    axis: Tuple[float, float, float]
    #: Its extent along the axis in mm.
    length: float
    #: The faces on it, as positions in ``faces`` of the conversion.
    faces: Tuple[int, ...]
    #: The standard deviation of the radius in mm, if the part was scanned and its vertices tell it.
    radius_deviation: Optional[float] = None


class Relation(NamedTuple):
    """Cylinders of a part that belong together. They are positions in ``cylinders()`` of the conversion."""

    #: ``"equal radius"``, ``"coaxial"``, ``"parallel"`` or ``"perpendicular"``.
    kind: str
    #: The cylinders.
    cylinders: Tuple[int, ...]
    #: The cylinders that these are perpendicular to, each to each. Empty for the other kinds.
    to: Tuple[int, ...]


class Arc(NamedTuple):
    """An edge as a part of a loop."""

    #: The edge in the parameter plane of the face.
    pcurve: Union[Curve, Ellipse]
    #: The edge in space. It has the parameters of ``pcurve``. Two faces that meet share it.
    edge: Union[Curve, Ellipse]
    #: Whether the loop runs along the curves. Otherwise it runs against them.
    forward: bool


class Loop(NamedTuple):
    """A closed loop that bounds a face."""

    #: Whether the loop bounds a hole. Otherwise it is the outer loop.
    hole: bool
    #: The edges in the order of the loop.
    arcs: List[Arc]


class Face:
    """A trimmed face of a :class:`Conversion`. Arrays are read-only views.

    Only a B-spline face has control points, knots and a degree; others raise a ``ValueError``.
    """

    def __init__(self, made: _scan2step.Face) -> None:
        self._made = made

    @property
    def surface(self) -> Surface:
        """The kind of the surface, and its parameters."""
        kind, frame, numbers = self._made.parameters
        if frame is None:
            return Surface(kind)
        at, axis = _triple(frame[0]), _triple(frame[3])
        half_angle = math.degrees(numbers[1]) if kind == "cone" else None
        return Surface(
            kind,
            at,
            None if kind == "sphere" else axis,
            numbers[0] if numbers else None,
            numbers[1] if kind == "torus" else None,
            half_angle,
        )

    @property
    def control_points(self) -> Floats:
        """The control net: (m, n, 3), in mm."""
        return self._made.control_points

    @property
    def knots_u(self) -> Floats:
        """The knots in u: (m + 4,)."""
        return self._made.knots_u

    @property
    def knots_v(self) -> Floats:
        """The knots in v: (n + 4,)."""
        return self._made.knots_v

    @property
    def degree(self) -> Tuple[int, int]:
        """The degrees in u and in v."""
        return self._made.degree

    @property
    def loops(self) -> List[Loop]:
        """The loops that bound the face: the outer one, then those of holes."""
        return [
            Loop(k > 0, [Arc(_curve(*pcurve), _curve(*edge), forward) for pcurve, edge, forward in loop])
            for k, loop in enumerate(self._made.loops)
        ]

    def points(self, uv: Any) -> Floats:
        """Points of the surface: (k, 2) parameter points in, (k, 3) in mm out.

        :raises ValueError: a parameter point is outside of the knots' range.
        """
        return self._made.points(_floats(uv))

    def normals(self, uv: Any) -> Floats:
        """Unit normals of the face: (k, 2) parameter points in, (k, 3) out.

        :raises ValueError: a parameter point is outside of the knots' range.
        """
        return self._made.normals(_floats(uv))

    def __repr__(self) -> str:
        kind = self._made.parameters[0]
        if kind != "spline":
            return f"<scan2step.Face {kind}>"
        m, n, _ = self.control_points.shape
        return f"<scan2step.Face {m} × {n} control points>"


class Conversion:
    """A face, a shell or a solid, with its figures. It does not change. Lengths are mm.

    With ``component="all"`` it holds what all components became.
    """

    def __init__(self, made: _scan2step.Conversion, name: str) -> None:
        self._made = made
        self._name = name

    @property
    def kind(self) -> str:
        """``"face"``, ``"shell"`` or ``"solid"``."""
        return self._made.kind

    @property
    def faces(self) -> List[Face]:
        """The faces."""
        return [Face(self._made.face(k)) for k in range(self._made.face_count)]

    def cylinders(self) -> List[Cylinder]:
        """The cylinders of a part with exact faces: bores, shafts, fillets and round edges, the widest first."""
        found: List[Cylinder] = []
        first = 0
        for body in self._bodies():
            for row in body.get("exact", {}).get("cylinders", []):
                at, axis = _triple(row["at"]), _triple(row["axis"])
                faces = tuple(first + face for face in row["faces"])
                deviation = row["radius_deviation_mm"]
                found.append(Cylinder(row["kind"], row["radius_mm"], at, axis, row["length_mm"], faces, deviation))
            first += body["shape"]["faces"]
        return found

    def relations(self) -> List[Relation]:
        """Groups of the cylinders of a part: of equal radius, coaxial, parallel and perpendicular ones.

        Two values are the same if they differ by twice the rounding of the file at the most. Those that are only parallel
        are in a group of their own kind; coaxial ones are parallel, too.
        """
        found: List[Relation] = []
        first = 0
        for body in self._bodies():
            exact = body.get("exact", {})
            for row in exact.get("relations", []):
                cylinders, to = (tuple(first + k for k in row[key]) for key in ("cylinders", "to"))
                found.append(Relation(row["kind"], cylinders, to))
            first += len(exact.get("cylinders", []))
        return found

    def _bodies(self) -> List[Dict[str, Any]]:
        """The report of each body."""
        report = self.report
        bodies: List[Dict[str, Any]] = report.get("components", [report])
        return bodies

    @property
    def tolerance(self) -> float:
        """The tolerance that was named, or that follows from the noise."""
        return self._made.tolerance

    @property
    def tolerance_met(self) -> bool:
        """Whether the result keeps the tolerance."""
        return self._made.tolerance_met

    @property
    def noise(self) -> float:
        """Standard deviation of the noise of the scan along the normal."""
        return self._made.noise

    @property
    def rms(self) -> float:
        """Root mean square deviation of the points as they were measured."""
        return self._made.rms

    @property
    def max(self) -> float:
        """Largest deviation of a point as it was measured."""
        return self._made.max

    @property
    def volume(self) -> Optional[float]:
        """The enclosed volume of a solid in mm³."""
        return self._made.volume

    @property
    def area(self) -> float:
        """The area of all faces in mm²."""
        return self._made.area

    @property
    def origin(self) -> Tuple[float, float, float]:
        """Where the result is measured from: zero unless the scan is far from zero."""
        x, y, z = self._made.origin
        return x, y, z

    @property
    def placement(self) -> Optional[List[List[float]]]:
        """The rows of the matrix that ``align=True`` has found: it takes places of the scan's own frame, in mm, to those of the part."""
        return self._made.placement

    @property
    def hints(self) -> List[str]:
        """What could be better, and what to do about it."""
        return self._made.hints

    @property
    def report(self) -> Dict[str, Any]:
        """All figures, as the program's ``--report FILE.json`` has them."""
        report: Dict[str, Any] = json.loads(self._made.report_json())
        return report

    @property
    def deviations(self) -> Floats:
        """The signed distance of each vertex of the scan from the result: (n,), in mm.

        It is positive on the side that the scan's triangles face, and NaN where a vertex belongs to
        no component that was converted.
        """
        return self._made.deviations()

    @property
    def smoothed_deviations(self) -> Floats:
        """The same for the smoothed vertices, against which the tolerance is held.

        The vertices of a cloud have none: the array is of no use there.
        """
        return self._made.smoothed_deviations()

    def distance(self, points: Any) -> Floats:
        """The distances of points (k, 3) from the result: (k,), in mm."""
        return self._made.distance(_floats(points))

    def step(self, schema: str = "ap242", colour: Colour = None) -> bytes:
        """The STEP file: the same bytes as the program writes.

        :param schema: ``"ap203"``, ``"ap214"`` or ``"ap242"``.
        :param colour: from 0 to 255. Without, the mean colour of the scan, if it has one.
        """
        return self._made.step(schema, _checked(colour), _time_stamp())

    def iges(self, form: str = "trimmed", colour: Colour = None, file_name: str = "") -> bytes:
        """The IGES file.

        :param form: ``"trimmed"`` for trimmed surfaces (144), ``"brep"`` for shells and solids.
        :param file_name: the name that the file says it has.
        """
        return self._made.iges(form, _checked(colour), _time_stamp(), file_name)

    def html(self) -> str:
        """The report as a page that needs nothing else."""
        return self._made.html()

    def png(self) -> bytes:
        """The picture of the report: 1600 × 1000 pixels."""
        return self._made.png()

    def write(self, *paths: Path) -> None:
        """Writes files, each in the format of its extension: all of them, or none.

        ``.step``, ``.stp``, ``.igs``, ``.iges``, ``.html``, ``.png``, ``.json``.

        :raises OptionError: an extension is not known.
        :raises FileError: a file cannot be written.
        """
        names = [os.fsdecode(path) for path in paths]
        for path in names:
            if os.path.exists(path) and not os.path.isfile(path):
                raise FileError(f"{path}: is not an ordinary file", "name a file", path=path)
        contents = [(path, self._content(path)) for path in names]
        pending: List[Tuple[str, str]] = []
        try:
            for path, content in contents:
                try:
                    pending.append((_temporary(path, content), path))
                except OSError as error:
                    raise _unwritten(path, error) from error
            for temporary, path in pending:
                try:
                    # Through links, which stay.
                    os.replace(temporary, os.path.realpath(path))
                except OSError as error:
                    raise _unwritten(path, error) from error
        finally:
            for temporary, _ in pending:
                if os.path.exists(temporary):
                    os.unlink(temporary)

    def _content(self, path: str) -> bytes:
        extension = os.path.splitext(path)[1].lower()
        if extension in (".step", ".stp"):
            return self.step()
        if extension in (".igs", ".iges"):
            name = os.fsencode(os.path.basename(path)).decode(errors="replace")
            return self.iges(file_name=name)
        if extension == ".html":
            return self.html().encode()
        if extension == ".png":
            return self.png()
        if extension == ".json":
            return self._report_json().encode()
        raise OptionError(
            f"{path}: no known extension", "name .step, .stp, .igs, .iges, .html, .png or .json"
        )

    def _report_json(self) -> str:
        return self._made.report_json()

    def to_occ(self) -> Any:
        """The result as a ``TopoDS_Shape`` of OCP (``pip install cadquery-ocp``)."""
        from .occ import to_occ

        return to_occ(self)

    def to_build123d(self) -> Any:
        """The result as a ``Face``, ``Shell`` or ``Solid`` of build123d."""
        from .occ import to_build123d

        return to_build123d(self)

    def to_cadquery(self) -> Any:
        """The result as a ``Face``, ``Shell`` or ``Solid`` of CadQuery."""
        from .occ import to_cadquery

        return to_cadquery(self)

    def show(self, height: int = 900) -> Any:
        """The report in a notebook: it turns, and shows the deviation. It is saved with the notebook."""
        import IPython.display

        frame: Any = IPython.display.HTML
        page = html.escape(self.html(), quote=True)
        return frame(
            f'<iframe sandbox="allow-scripts" width="100%" height="{height}" srcdoc="{page}"></iframe>'
        )

    def __repr__(self) -> str:
        faces = self._made.face_count
        count = f"{faces} face" if faces == 1 else f"{faces} faces"
        met = "met" if self.tolerance_met else "missed"
        return (
            f"<scan2step.Conversion {self._name}: a {self.kind} of {count}, "
            f"tolerance {self.tolerance:.4g} mm {met}, rms {self.rms:.4g} mm>"
        )

    def _repr_html_(self) -> str:
        picture = base64.b64encode(self.png()).decode()
        return f'<img alt="{html.escape(repr(self), quote=True)}" width="800" src="data:image/png;base64,{picture}">'

    def __reduce__(self) -> Any:
        raise TypeError("a Conversion cannot be pickled: return step() and report")


def _curve(degree: int, knots: Floats, points: Floats) -> Union[Curve, Ellipse]:
    if degree > 0:
        return Curve(degree, knots, points)
    return Ellipse((float(knots[0]), float(knots[1])), points[0], points[1:])


def _triple(numbers: List[float]) -> Tuple[float, float, float]:
    x, y, z = numbers
    return x, y, z


def _floats(numbers: Any) -> Floats:
    # numpy is imported where arrays are used: it takes longer than everything else here.
    import numpy as np

    return np.ascontiguousarray(numbers, np.float64)


def _checked(colour: Colour) -> Colour:
    if colour is not None and not (len(colour) == 3 and all(0 <= c <= 255 for c in colour)):
        raise ValueError(f"a colour is three whole numbers from 0 to 255, not {colour!r}")
    return colour


def _time_stamp() -> str:
    """SOURCE_DATE_EPOCH, or 1970 without it, so that the same scan gives the same bytes."""
    asked = os.environ.get("SOURCE_DATE_EPOCH", "0")
    # The last second of the year 9999. A time stamp has four digits for the year.
    last = 253_402_300_799
    if not (asked.isascii() and asked.isdigit() and int(asked) <= last):
        raise OptionError(
            f"SOURCE_DATE_EPOCH: {asked!r} is no number of seconds since 1970",
            f"set it to a whole number up to {last}, or unset it",
        )
    return time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(int(asked)))


def _temporary(path: str, content: bytes) -> str:
    """Writes a file beside its place, with the rights of an ordinary file."""
    folder = os.path.dirname(os.path.realpath(path))
    temporary = os.path.join(folder, f".scan2step-{uuid.uuid4().hex}.part")
    # The user's umask limits the rights.
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
    descriptor = os.open(temporary, flags, 0o666)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
    except BaseException:
        os.unlink(temporary)
        raise
    return temporary


def _unwritten(path: str, error: OSError) -> FileError:
    return FileError(
        f"{path}: cannot be written: {error.strerror}",
        "check that the folder exists, can be written to and has room",
        path=path,
    )
