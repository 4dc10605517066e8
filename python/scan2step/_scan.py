"""Scans: files, arrays, and the meshes of other packages."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, List, Optional, Sequence, Tuple, Union

from . import _scan2step

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

Path = Union[str, bytes, "os.PathLike[str]", "os.PathLike[bytes]"]


class Scan:
    """A scan as it was read: a mesh or a cloud of points.

    Make one with :func:`read`, or let :func:`scan2step.convert` make it.
    """

    _made: _scan2step.Scan

    def __init__(self, made: _scan2step.Scan) -> None:
        self._made = made

    @property
    def vertices(self) -> npt.NDArray[np.float64]:
        """The vertices of a mesh, or the points of a cloud: (n, 3), in the unit of the scan."""
        return self._made.vertices

    @property
    def faces(self) -> Optional[npt.NDArray[np.uint32]]:
        """The triangles: (m, 3) indices into :attr:`vertices`. ``None`` for a cloud.

        Polygons with more than three corners are cut into fans.
        """
        return self._made.faces

    @property
    def unit(self) -> Optional[str]:
        """The unit that the file declares: ``"mm"``, ``"cm"``, ``"m"``, ``"in"``, ``"ft"``."""
        return self._made.unit

    @property
    def colour(self) -> Optional[Tuple[int, int, int]]:
        """The mean colour of the vertices, from 0 to 255, if all have one."""
        return self._made.colour

    @property
    def notes(self) -> List[str]:
        """What to know about how the file was read, for example which points were left out."""
        return self._made.notes

    def __repr__(self) -> str:
        faces = self.faces
        what = "a cloud" if faces is None else f"{len(faces)} triangles"
        return f"<scan2step.Scan {self._made.file}: {len(self.vertices)} points, {what}>"

    def __reduce__(self) -> Any:
        raise TypeError("a Scan cannot be pickled: send the file's path, or the arrays")


def read(
    path: Path,
    *,
    classes: Sequence[int] = (),
    min_intensity: Optional[float] = None,
    columns: Optional[Sequence[Union[int, str]]] = None,
) -> Scan:
    """Reads a scan from a file.

    :param path: a mesh (PLY, OBJ, glTF, STL, OFF) or a cloud of points (PLY without faces, XYZ,
        TXT, ASC, CSV, PTS, PTX, PCD, E57, LAS, LAZ), each also gzipped.
    :param classes: take only the points of these classes of a LAS or LAZ file.
    :param min_intensity: take only points with at least this intensity (LAS, LAZ, E57).
    :param columns: the columns of x, y and z in a text file, counted from 1 as ``(2, 3, 4)``, or their
        names; those of the normal may follow. Without it they are found.
    :raises FileError: the file cannot be read. ``path`` and ``place`` say where.
    """
    if not all(0 <= number <= 255 for number in classes):
        raise ValueError("classes are whole numbers from 0 to 255")
    named = None if columns is None else ",".join(str(column) for column in columns)
    return Scan(_scan2step.Scan.read(os.fsdecode(path), list(classes), min_intensity, named))


def scan_of(scan: Any, faces: Any = None) -> Scan:
    """The scan that an argument stands for: a path, arrays, or a mesh of another package."""
    if isinstance(scan, (Scan, str, bytes, os.PathLike)) and faces is not None:
        raise TypeError("faces go with an array of vertices, and not with a file or a Scan")
    if isinstance(scan, Scan):
        return scan
    if isinstance(scan, (str, bytes, os.PathLike)):
        return read(scan)
    vertices, faces = _arrays(scan, faces)
    points = _numbers(vertices)
    if faces is None:
        return Scan(_scan2step.Scan.cloud(points, "cloud"))
    return Scan(_scan2step.Scan.mesh(points, _indices(faces, len(points)), "mesh"))


def _arrays(scan: Any, faces: Any) -> Tuple[Any, Any]:
    """Vertices and faces of a mesh of trimesh, Open3D, PyVista or FreeCAD, or of arrays."""
    if faces is not None:
        return scan, faces
    if hasattr(scan, "Topology"):  # FreeCAD, in global placement
        points, triangles = scan.Topology
        return [(p.x, p.y, p.z) for p in points], triangles
    if hasattr(scan, "regular_faces"):  # PyVista
        return scan.points, scan.regular_faces
    if hasattr(scan, "vertices"):
        for name in ("faces", "triangles"):  # trimesh, Open3D
            if hasattr(scan, name):
                return scan.vertices, getattr(scan, name)
        return scan.vertices, None  # a cloud of trimesh
    if hasattr(scan, "points"):  # a cloud of Open3D
        return scan.points, None
    if isinstance(scan, tuple) and len(scan) == 2:
        return scan
    return scan, None


def _unmasked(values: Any) -> npt.NDArray[Any]:
    """An array. What a mask hides is no part of a scan, and no array can leave it out."""
    import numpy as np

    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        raise ValueError("the array is masked: take the rows that count first")
    return np.asarray(values)


def _numbers(vertices: Any) -> npt.NDArray[np.float64]:
    import numpy as np

    array = _unmasked(vertices)
    if array.dtype.kind not in "fiu" or array.ndim != 2:
        raise TypeError(
            "a scan is a path, an array of points (n, 3) with or without an array of faces (m, 3), "
            f"or a mesh of another package, not {type(vertices).__name__} of shape {array.shape}"
        )
    return np.ascontiguousarray(array, np.float64)


def _indices(faces: Any, count: int) -> npt.NDArray[np.uint32]:
    import numpy as np

    array = _unmasked(faces)
    if array.ndim != 2 or array.dtype.kind not in "iu":
        if array.size == 0:
            return np.zeros((0, 3), np.uint32)
        raise TypeError(f"faces are an array (m, 3) of whole numbers, not {array.dtype} {array.shape}")
    if array.size and not (0 <= array.min() and array.max() < count):
        raise ValueError(f"faces have indices from {array.min()} to {array.max()}, and there are {count} vertices")
    return np.ascontiguousarray(array, np.uint32)
