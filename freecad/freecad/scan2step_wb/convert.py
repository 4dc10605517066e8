"""Between FreeCAD and scan2step, without a window: meshes to arrays, conversions to shapes."""

import hashlib
import json
import os
import tempfile

import numpy as np
import Part

#: The options that an object has as properties, each with its type in FreeCAD, its default, and what it does.
OPTIONS = {
    "tolerance": ("App::PropertyLength", 0.0, "Largest distance of a smoothed point from the result; 0: from the noise of the scan"),
    "shape": ("App::PropertyEnumeration", ["auto", "face", "shell", "solid"], "What the scan becomes; auto: what suits it"),
    "holes": ("App::PropertyEnumeration", ["cut out", "filled"], "What becomes of the holes of a face"),
    "component": ("App::PropertyIntegerConstraint", (0, 0, 1000000, 1), "Component of the scan; 0 is the largest"),
    "smooth": ("App::PropertyEnumeration", ["auto", "off"], "Smoothing of the scan"),
    "sizes": ("App::PropertyEnumeration", ["as measured", "round"], "Radii, angles and distances of planes in the scan of a part: as measured, or round where that is within two standard deviations"),
    "weld": ("App::PropertyLength", 0.0, "Points of rims that are not farther from each other are one; 0: what the scan tells"),
    "points": ("App::PropertyEnumeration", ["with their triangles", "alone"], "What is taken of a mesh; alone: new triangles are laid through its points, which joins meshes that overlap"),
    "face_count": ("App::PropertyIntegerConstraint", (0, 0, 100000, 1), "About how many faces a solid or a shell gets; 0: as many as its shape needs"),
    "handles": ("App::PropertyLength", 0.0, "Cut handles whose loop is not longer; 0: a few edges"),
    "outline": ("App::PropertyEnumeration", ["auto", "sides", "trimmed"], "Where the outer boundary of a face goes: the sides of its surface, or a trim loop"),
    "rim_tolerance": ("App::PropertyLength", 0.0, "Largest distance of a trim loop from the measured rim; 0: from the scan"),
    "fill_only_holes_below": ("App::PropertyLength", 0.0, "Fill holes whose rim is shorter, and cut out the others; 0: none"),
    "outliers": ("App::PropertyPercent", 0, "Percentage of points that may exceed the tolerance"),
}

#: The options that the panel shows first. The others are folded.
FIRST = ("tolerance", "shape", "holes", "component", "smooth")


def defaults():
    """The default of each option, as :func:`arguments` takes it."""
    values = {}
    for name, (kind, default, _) in OPTIONS.items():
        values[name] = default[0] if isinstance(default, (list, tuple)) else default
    return values


def arguments(values):
    """The arguments of ``scan2step.convert`` for values of options."""
    given = {
        "shape": values["shape"],
        "component": int(values["component"]),
        "smooth": values["smooth"],
        "outline": values["outline"],
        "outliers": values["outliers"] / 100.0,
        "keep_fills": values["holes"] == "filled",
        "regularize": values["sizes"] == "round",
        "remesh": values["points"] == "alone",
    }
    for name in ("tolerance", "handles", "rim_tolerance", "fill_only_holes_below", "weld"):
        if values[name] > 0:
            given[name] = float(values[name])
    if values["face_count"] > 0:
        given["face_count"] = int(values["face_count"])
    return given


def is_scan(obj):
    """Whether an object is a mesh or a cloud of points."""
    return obj.isDerivedFrom("Mesh::Feature") or obj.isDerivedFrom("Points::Feature")


def geometry(source):
    """The mesh of an object, or its points if it is a cloud."""
    return source.Mesh if source.isDerivedFrom("Mesh::Feature") else source.Points


def arrays(source):
    """The points and the triangles of a scan, in the place where the document has it. A cloud has none."""
    if source.isDerivedFrom("Mesh::Feature"):
        points, triangles = source.Mesh.Topology
        triangles = np.array(triangles, np.uint32).reshape(-1, 3)
    else:
        points, triangles = source.Points.Points, None
    return np.array([(p.x, p.y, p.z) for p in points], float).reshape(-1, 3), triangles


def fingerprint(source, values):
    """A text that changes if a point or a triangle of the scan or an option does."""
    found = hashlib.sha256(repr(sorted(values.items())).encode())
    for array in arrays(source):
        found.update(b"" if array is None else array.tobytes())
    return found.hexdigest()


class Prepared:
    """What a document takes of a conversion. It is made in the thread of the conversion."""

    def __init__(self, made, version):
        self.kind = made.kind
        self.shape = shape(made)
        self.properties = {
            "Kind": made.kind,
            "ToleranceFound": made.tolerance,
            "ToleranceMet": made.tolerance_met,
            "Noise": made.noise,
            "Rms": made.rms,
            "Largest": made.max,
            "Faces": len(made.faces),
            "Version": version,
            "Deviations": made.deviations.tolist(),
            "Report": json.dumps(made.report),
            "Step": made.step().decode(),
        }


def shape(made):
    """The shape of a conversion: a face, a shell, a solid, or a compound of several."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scan2step.step")
        with open(path, "wb") as file:
            file.write(made.step())
        read = Part.read(path)
    for parts in (read.Solids, read.Shells if made.kind == "shell" else read.Faces):
        if len(parts) == 1:
            return parts[0]
    return read
