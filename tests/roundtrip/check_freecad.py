#!/usr/bin/env python3
"""Opens a STEP or IGES file with FreeCAD and describes the result.

    /usr/bin/python3 check_freecad.py FILE
    freecadcmd check_freecad.py FILE

The script prints one JSON object. Each process reads only one file, because FreeCAD 0.20 may crash on
the second IGES file. The script also does the typical next steps of a user: it cuts the shape with a
box, thickens it and extrudes it. Lengths are in millimetres.
"""

import glob
import json
import os
import sys

# Importers print to stdout. Keep the real one for the result.
ANSWER = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)


def find_freecad():
    """Puts FreeCAD's modules on the path, if they are not there already."""
    try:
        import FreeCAD  # noqa: F401

        return
    except ImportError:
        pass
    home = os.environ.get("FREECAD_LIB")
    candidates = [home] if home else []
    for pattern in (
        "/usr/lib/freecad-python3/lib",
        "/usr/lib/freecad*/lib",
        "/usr/lib/*/freecad*/lib",
        "/usr/local/lib/freecad*/lib",
        "/opt/freecad*/lib",
    ):
        candidates += sorted(glob.glob(pattern))
    found = [c for c in candidates if glob.glob(os.path.join(c, "FreeCAD*.so"))]
    # In Debian, the Python part and the rest are in different folders. Both must be on the path.
    rest = [c for c in candidates if os.path.isdir(c) and c not in found]
    if not found:
        raise SystemExit("FreeCAD's Python modules are nowhere; set FREECAD_LIB")
    sys.path[:0] = rest + found


find_freecad()
import FreeCAD  # noqa: E402
import MeshPart  # noqa: E402
import Part  # noqa: E402


def load(path):
    """The document that FreeCAD's "open" creates from the file."""
    document = FreeCAD.newDocument("check")
    import Import

    Import.insert(path, document.Name)
    return document


def shapes_of(document):
    """The objects with a shape that are not parts of another object."""
    found = []
    for thing in document.Objects:
        shape = getattr(thing, "Shape", None)
        if shape is None or shape.isNull():
            continue
        # A compound links to its parts.
        part = any(owner.TypeId.startswith("Part::") for owner in thing.InList)
        if thing.TypeId.startswith("Part::") and not part:
            found.append(thing)
    return found


def attempt(what):
    """The result of `what()`, or the text of the error."""
    try:
        return what()
    except Exception as error:  # FreeCAD raises all sorts
        return f"{type(error).__name__}: {error}".strip()


def bounding_box(shape):
    """The tight bounding box without triangulation. 0.20 refuses the second argument."""
    for arguments in ((False, False), (False,)):
        try:
            return shape.optimalBoundingBox(*arguments)
        except TypeError:
            pass
    return shape.BoundBox


def check(shape):
    """FreeCAD's "Check geometry" with the Boolean check. None means valid."""
    try:
        shape.check(True)
    except Exception as error:
        return str(error).strip() or type(error).__name__
    return None


def sound(shape):
    """Whether a user could continue with the result of an operation."""
    return bool(not shape.isNull() and shape.Faces and shape.isValid())


def cut(shape):
    """The shape without the half that a box covers."""
    box = bounding_box(shape)
    margin = box.DiagonalLength * 0.1 + 1.0
    corner = FreeCAD.Vector(box.XMin - margin, box.YMin - margin, box.ZMin - margin)
    block = Part.makeBox(
        box.XLength * 0.47 + margin,
        box.YLength + 2 * margin,
        box.ZLength + 2 * margin,
        corner,
    )
    rest, piece = shape.cut(block), shape.common(block)
    whole, left = area(shape), area(rest)
    areas = abs(left + area(piece) - whole) < 1e-3 * whole
    return bool(sound(rest) and sound(piece) and left < whole and areas)


def area(shape):
    """The area by a fine tessellation. FreeCAD's own figure is 5 % off for ragged loops."""
    fine = 2e-4 * bounding_box(shape).DiagonalLength
    return MeshPart.meshFromShape(Shape=shape, LinearDeflection=fine, AngularDeflection=1.0).Area


def offset(shape):
    """A shell of constant thickness over each face. OpenCASCADE offsets shells and faces,
    but not compounds of them."""
    size = shape.BoundBox.DiagonalLength
    sheets = shape.Shells or shape.Faces if shape.ShapeType == "Compound" else [shape]
    return all(sound(s.makeOffsetShape(0.005 * size, 1e-3, fill=True)) for s in sheets)


def extrude(shape):
    """A solid between the face and its copy above."""
    solid = shape.extrude(FreeCAD.Vector(0, 0, shape.BoundBox.DiagonalLength * 0.1))
    return bool(sound(solid) and solid.Solids)


def report(path):
    document = load(path)
    things = shapes_of(document)
    answer = {"file": os.path.basename(path), "objects": len(things)}
    answer["freecad"] = ".".join(FreeCAD.Version()[:3])
    if not things:
        return answer | {"faces": 0, "valid": False}
    shape = things[0].Shape
    if len(things) > 1:
        shape = Part.makeCompound([t.Shape for t in things])
    box = bounding_box(shape)
    vertices = [v.Tolerance for v in shape.Vertexes]
    edges = [e.Tolerance for e in shape.Edges]
    return answer | {
        "label": things[0].Label,
        "shape": shape.ShapeType.lower(),
        "faces": len(shape.Faces),
        "edges": len(shape.Edges),
        "wires_inner": sum(len(f.Wires) - 1 for f in shape.Faces),
        "surface_type": type(shape.Faces[0].Surface).__name__ if shape.Faces else None,
        "valid": shape.isValid(),
        "check": check(shape),
        "max_tolerance_edge": max(edges, default=0.0),
        "max_tolerance_vertex": max(vertices, default=0.0),
        "bbox": [box.XMin, box.YMin, box.ZMin, box.XMax, box.YMax, box.ZMax],
        "area": area(shape),
        "boolean_ok": attempt(lambda: cut(shape)),
        "offset_ok": attempt(lambda: offset(shape)),
        "extrude_ok": attempt(lambda: extrude(shape)),
    }


def main():
    files = [a for a in sys.argv[1:] if os.path.splitext(a)[1].lower() in FILES]
    if len(files) != 1:
        raise SystemExit("usage: check_freecad.py FILE")
    json.dump(report(os.path.abspath(files[0])), ANSWER)
    ANSWER.write("\n")
    ANSWER.flush()


FILES = {".step", ".stp", ".p21", ".iges", ".igs"}

# freecadcmd runs scripts under the name of their file.
if __name__ == "__main__" or (
    __name__ == "check_freecad" and "freecadcmd" in os.path.basename(sys.argv[0]).lower()
):
    main()
    sys.stderr.flush()
    # freecadcmd would wait for more commands, or open FILE itself.
    os._exit(0)
