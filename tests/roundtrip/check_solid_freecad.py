#!/usr/bin/env python3
"""Opens a solid's STEP or IGES file with FreeCAD, cuts it with a box, and rounds an edge of
the cut.

    /usr/bin/python3 check_solid_freecad.py FILE

The script prints one JSON object. Lengths are in millimetres.
"""

import json
import os
import sys

import check_freecad as freecad
import FreeCAD
import Part


def cut(shape):
    """The part of the shape beyond a plane that contains no face of it."""
    box = shape.BoundBox
    size = FreeCAD.Vector(box.XLength * 0.53, box.YLength + 2, box.ZLength + 2)
    corner = FreeCAD.Vector(box.XMin - 1, box.YMin - 1, box.ZMin - 1)
    return shape.cut(Part.makeBox(size.x, size.y, size.z, corner))


def rounded(shape):
    """The shape with one edge of the cut rounded: the first one that can be."""
    plane = min(vertex.X for vertex in shape.Vertexes)
    for edge in shape.Edges:
        if all(abs(vertex.X - plane) < 1e-6 for vertex in edge.Vertexes):
            result = freecad.attempt(lambda: shape.makeFillet(0.5, [edge]))
            if not isinstance(result, str) and result.isValid():
                return result
    return None


def report(path):
    things = freecad.shapes_of(freecad.load(path))
    shape = things[0].Shape
    if len(things) > 1:
        shape = Part.makeCompound([thing.Shape for thing in things])
    rest = cut(shape)
    fillet = rounded(rest)
    return {
        "solids": len(shape.Solids),
        "valid": shape.isValid(),
        "check": freecad.check(shape),
        "volume": shape.Volume,
        "cut_valid": rest.isValid(),
        "cut_solids": len(rest.Solids),
        "cut_volume": rest.Volume,
        "fillet_volume": fillet.Volume if fillet else None,
    }


if __name__ == "__main__":
    json.dump(report(os.path.abspath(sys.argv[1])), freecad.ANSWER)
    freecad.ANSWER.write("\n")
    freecad.ANSWER.flush()
    sys.stderr.flush()
    os._exit(0)
