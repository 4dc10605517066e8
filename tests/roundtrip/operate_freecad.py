#!/usr/bin/env python3
"""Opens a solid's STEP file with FreeCAD and continues as a designer does.

    /usr/bin/python3 operate_freecad.py FILE

It measures the bores by their faces, rounds an edge and pads a sketch on a plane face in a PartDesign body, cuts the
solid with a box, and fuses it with one. The script prints one JSON object. Each operation has the volume found and the one
expected, and whether the result is valid. Lengths are in millimetres.
"""

import json
import math
import os
import sys

import check_freecad as freecad
import FreeCAD

# FreeCAD's program finds its workbenches, of which PartDesign is one. Programs that import it do not.
sys.path += [home for home in ("/usr/lib/freecad/Mod", FreeCAD.getHomePath() + "/Mod") if os.path.isdir(home)]
import Part  # noqa: E402

# The radius of the round edge, the radius of the sketch and the height of its pad, as shares of the part's size.
ROUND, SKETCH, HEIGHT = 0.01, 0.03, 0.05

# Directions are the same or perpendicular within this.
ALIGNED = 1e-6


def normal_of(face):
    """The outer normal of a plane face."""
    middle = face.Surface.parameter(face.CenterOfMass)
    return face.normalAt(*middle)


def is_plane(face):
    return isinstance(face.Surface, Part.Plane)


def bores(shape):
    """The radii of the cylinders that go all around, and whose material is outside."""
    found = []
    for face in shape.Faces:
        if not isinstance(face.Surface, Part.Cylinder):
            continue
        u0, u1, v0, v1 = face.ParameterRange
        u, v = (u0 + u1) / 2, (v0 + v1) / 2
        away = face.valueAt(u, v) - face.Surface.Center
        away -= face.Surface.Axis * away.dot(face.Surface.Axis)
        if u1 - u0 > 2 * math.pi - ALIGNED and face.normalAt(u, v).dot(away) < 0.0:
            found.append(face.Surface.Radius)
    return sorted(found)


def square_edges(shape):
    """The numbers of straight edges that end in square corners of three planes and stand out, the longest first."""
    found = []
    for number, edge in enumerate(shape.Edges, 1):
        corners = [shape.ancestorsOfType(vertex, Part.Edge) for vertex in edge.Vertexes]
        if len(corners) < 2 or not all(map(is_square, corners)):
            continue
        faces = shape.ancestorsOfType(edge, Part.Face)
        around = [face for vertex in edge.Vertexes for face in shape.ancestorsOfType(vertex, Part.Face)]
        if all(map(is_plane, around)) and stands_out(shape, edge, faces):
            found.append((-edge.Length, number))
    return [number for _, number in sorted(found)]


def is_square(edges):
    """Whether three straight edges are perpendicular to each other."""
    if len(edges) != 3 or not all(isinstance(edge.Curve, Part.Line) for edge in edges):
        return False
    along = [edge.Curve.Direction for edge in edges]
    return all(abs(along[k].dot(along[k - 1])) < ALIGNED for k in range(3))


def stands_out(shape, edge, faces):
    middle = edge.valueAt((edge.FirstParameter + edge.LastParameter) / 2)
    step = 1e-3 * shape.BoundBox.DiagonalLength
    out = [face.normalAt(*face.Surface.parameter(middle)) for face in faces]
    return not any(shape.isInside(middle + sign * step * (out[0] - out[1]), 1e-7, False) for sign in (1, -1))


def outer_plane(shape):
    """The number of the largest plane face that has all of the part on one side."""
    best = None
    for number, face in enumerate(shape.Faces, 1):
        if not is_plane(face):
            continue
        out = normal_of(face)
        level = out.dot(face.CenterOfMass)
        far = max(out.dot(point) for f in shape.Faces for point in f.tessellate(0.1)[0])
        if far < level + 1e-3 and (best is None or face.Area > best[0]):
            best = (face.Area, number)
    return best and best[1]


def body_of(document, thing):
    body = document.addObject("PartDesign::Body", "Body")
    body.BaseFeature = thing
    document.recompute()
    return body


def said(shape, expected):
    return {"volume": shape.Volume, "expected": expected, "valid": shape.isValid(), "solids": len(shape.Solids)}


def rounded(document, thing):
    """The part with its longest square edge rounded. None if it has no such edge."""
    edges = square_edges(thing.Shape)
    if not edges:
        return None
    body = body_of(document, thing)
    base = body.Tip
    fillet = body.newObject("PartDesign::Fillet", "Fillet")
    fillet.Base = (base, [f"Edge{edges[0]}"])
    radius = ROUND * thing.Shape.BoundBox.DiagonalLength
    fillet.Radius = radius
    document.recompute()
    removed = (1.0 - math.pi / 4) * radius**2 * thing.Shape.Edges[edges[0] - 1].Length
    return said(fillet.Shape, thing.Shape.Volume - removed)


def padded(document, thing):
    """The part with a round pad on a sketch on its largest outer plane."""
    number = outer_plane(thing.Shape)
    if number is None:
        return None
    body = body_of(document, thing)
    base = body.Tip
    sketch = body.newObject("Sketcher::SketchObject", "Sketch")
    sketch.Support = (base, [f"Face{number}"])
    sketch.MapMode = "FlatFace"
    size = thing.Shape.BoundBox.DiagonalLength
    # A place on the material of the face, in the frame of the sketch.
    document.recompute()
    at = sketch.Placement.inverse().multVec(place_on(thing.Shape.Faces[number - 1]))
    circle = Part.Circle(FreeCAD.Vector(at.x, at.y, 0), FreeCAD.Vector(0, 0, 1), SKETCH * size)
    sketch.addGeometry(circle, False)
    pad = body.newObject("PartDesign::Pad", "Pad")
    pad.Profile = sketch
    pad.Length = HEIGHT * size
    document.recompute()
    added = math.pi * (SKETCH * size) ** 2 * HEIGHT * size
    return said(pad.Shape, thing.Shape.Volume + added)


def place_on(face):
    """The middle of the largest triangle of a plane face."""
    points, triangles = face.tessellate(0.1)
    corners = ([points[k] for k in triangle] for triangle in triangles)
    a, b, c = max(corners, key=lambda p: (p[1] - p[0]).cross(p[2] - p[0]).Length)
    return (a + b + c) / 3


def block(shape):
    """A box over a part of the shape, none of whose sides is on a face of it."""
    box = shape.BoundBox
    low = FreeCAD.Vector(box.XMin - 0.11 * box.XLength, box.YMin - 0.13 * box.YLength, box.ZMin - 0.07 * box.ZLength)
    return Part.makeBox(0.643 * box.XLength, 0.671 * box.YLength, 1.14 * box.ZLength, low)


def report(path):
    document = freecad.load(path)
    things = freecad.shapes_of(document)
    thing = things[0]
    shape, tool = thing.Shape, block(thing.Shape)
    both = shape.common(tool).Volume
    return {
        "solids": len(shape.Solids),
        "valid": shape.isValid(),
        "check": freecad.check(shape),
        "volume": shape.Volume,
        "bores": bores(shape),
        "round": rounded(document, thing),
        "pad": padded(document, thing),
        "cut": said(shape.cut(tool), shape.Volume - both),
        "fuse": said(shape.fuse(tool), shape.Volume + tool.Volume - both),
    }


if __name__ == "__main__":
    json.dump(report(os.path.abspath(sys.argv[1])), freecad.ANSWER)
    freecad.ANSWER.write("\n")
    freecad.ANSWER.flush()
    sys.stderr.flush()
    os._exit(0)
