"""scan2step turns 3D scans into B-spline faces and solids that CAD programs open.

A scan is a triangle mesh or a cloud of points. It becomes one trimmed face, a shell of several
faces, or a watertight solid. Lengths are millimetres, whatever the unit of the scan is.

>>> import scan2step
>>> made = scan2step.convert("relief.ply", tolerance=0.5)  # doctest: +SKIP
>>> made.kind, made.tolerance_met  # doctest: +SKIP
('face', True)
>>> made.write("relief.step")  # doctest: +SKIP
"""

from ._assembly import Assembly, Node, Part, Place
from ._conversion import Arc, Conversion, Curve, Cylinder, Ellipse, Face, Loop, Relation, Surface
from ._errors import (
    FileError,
    FillError,
    InternalError,
    MemoryBoundError,
    OptionError,
    Scan2StepError,
    ScanError,
    TopologyError,
    TrimError,
)
from ._functions import check, convert, inspect
from ._scan import Scan, read
from ._scan2step import __version__

__all__ = [
    "Arc",
    "Assembly",
    "Conversion",
    "Curve",
    "Cylinder",
    "Ellipse",
    "Face",
    "FileError",
    "FillError",
    "InternalError",
    "Loop",
    "MemoryBoundError",
    "Node",
    "OptionError",
    "Part",
    "Place",
    "Relation",
    "Scan",
    "Scan2StepError",
    "ScanError",
    "Surface",
    "TopologyError",
    "TrimError",
    "__version__",
    "check",
    "convert",
    "inspect",
    "read",
]
