#!/usr/bin/env python3
"""Makes parts as designers do, or continues with a solid's STEP file as they do, with OpenCASCADE, CadQuery's kernel.

    python operate_occ.py make FOLDER
    python operate_occ.py FILE

`make` writes FOLDER/NAME.stl and FOLDER/NAME.json, the volume and the bores of the part, for each of three parts.

The other form measures the bores by their faces, rounds an edge, pads a circle on a plane face, cuts the solid with a
box, and fuses it with one. It prints one JSON object. Each operation has the volume found and the one expected, and
whether the result is valid. Lengths are in millimetres.
"""

import json
import math
import os
import sys

import check_occ as occ
import numpy as np
import random_parts
from check_solid_occ import volume_of
from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.BRepAlgoAPI import BRepAlgoAPI_Common, BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepFilletAPI import BRepFilletAPI_MakeChamfer, BRepFilletAPI_MakeFillet
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakeSphere, BRepPrimAPI_MakeTorus
from OCP.BRepTools import BRepTools
from OCP.GCPnts import GCPnts_AbscissaPoint
from OCP.GeomAbs import GeomAbs_Cylinder, GeomAbs_Line, GeomAbs_Plane
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_IN, TopAbs_REVERSED, TopAbs_SOLID, TopAbs_VERTEX
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS
from OCP.TopTools import TopTools_IndexedDataMapOfShapeListOfShape

# The radius of the round edge, the radius of the pad and its height, as shares of the part's size.
ROUND, CIRCLE, HEIGHT = 0.01, 0.03, 0.05

# Directions are the same or perpendicular within this.
ALIGNED = 1e-6

# The mesh of a part of a designer: the chord error in mm, and the angle.
DEFLECTION, ANGLE = 0.05, 0.3


# ---- making


def cylinder(x, y, z, radius, height, along=(0, 0, 1)):
    return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(x, y, z), gp_Dir(*along)), radius, height).Shape()


def cut(shape, *tools):
    for tool in tools:
        shape = BRepAlgoAPI_Cut(shape, tool).Shape()
    return shape


def unified(shape):
    unify = ShapeUpgrade_UnifySameDomain(shape, True, True, False)
    unify.Build()
    return unify.Shape()


def edges_at(shape, is_meant):
    """Edges whose middle is meant."""
    found = []
    for edge in occ.edges_of(shape):
        if not BRep_Tool.Degenerated_s(edge):
            curve = BRepAdaptor_Curve(edge)
            middle = curve.Value((curve.FirstParameter() + curve.LastParameter()) / 2)
            if is_meant(*occ.xyz(middle)):
                found.append(edge)
    return found


def rounded(shape, radius, is_meant):
    fillet = BRepFilletAPI_MakeFillet(shape)
    for edge in edges_at(shape, is_meant):
        fillet.Add(radius, edge)
    return fillet.Shape()


def block():
    """A block with round corners, two counterbores and a blind hole with a round end."""
    shape = BRepPrimAPI_MakeBox(60.0, 40.0, 20.0).Shape()
    shape = rounded(shape, 5.0, lambda x, y, z: x in (0.0, 60.0) and y == 40.0 and z == 10.0)
    bores = [cylinder(x, 20.0, -1.0, 3.25, 30.0) for x in (12.0, 48.0)]
    bores += [cylinder(x, 20.0, 14.0, 5.5, 10.0) for x in (12.0, 48.0)]
    blind = [cylinder(30.0, 20.0, 9.0, 4.0, 20.0), BRepPrimAPI_MakeSphere(gp_Pnt(30.0, 20.0, 9.0), 4.0).Shape()]
    return cut(shape, *bores, *blind), [3.25, 3.25, 4.0, 5.5, 5.5]


def flange():
    """A flange with a hub, a round inner edge, a bevelled bore and six holes."""
    shape = BRepAlgoAPI_Fuse(cylinder(0, 0, 0, 30.0, 6.0), cylinder(0, 0, 0, 14.0, 22.0)).Shape()
    # The edge between the hub and the disc.
    shape = rounded(unified(shape), 3.0, lambda x, y, z: z == 6.0 and math.hypot(x, y) < 15.0)
    shape = cut(shape, cylinder(0, 0, -1.0, 8.0, 30.0))
    bevel = BRepFilletAPI_MakeChamfer(shape)
    for edge in edges_at(shape, lambda x, y, z: abs(z - 22.0) < 1e-9 and math.hypot(x, y) < 8.5):
        bevel.Add(1.0, edge)
    turn = [k * math.pi / 3 for k in range(6)]
    holes = [cylinder(22.0 * math.cos(a), 22.0 * math.sin(a), -1.0, 2.75, 10.0) for a in turn]
    return cut(bevel.Shape(), *holes), [2.75] * 6 + [8.0]


def angle():
    """An angle with a round inside, a bore in each leg, and a groove for a ring around one of them."""
    shape = BRepPrimAPI_MakeBox(50.0, 30.0, 8.0).Shape()
    shape = BRepAlgoAPI_Fuse(shape, BRepPrimAPI_MakeBox(8.0, 30.0, 45.0).Shape()).Shape()
    shape = rounded(unified(shape), 6.0, lambda x, y, z: (x, z) == (8.0, 8.0))
    groove = BRepPrimAPI_MakeTorus(gp_Ax2(gp_Pnt(32.0, 15.0, 8.0), gp_Dir(0, 0, 1)), 9.0, 1.5).Shape()
    bores = [cylinder(32.0, 15.0, -1.0, 5.0, 20.0), cylinder(-1.0, 15.0, 30.0, 4.5, 20.0, (1, 0, 0))]
    return cut(shape, groove, *bores), [4.5, 5.0]


def make(folder):
    for name, (shape, bores) in {"block": block(), "flange": flange(), "angle": angle()}.items():
        shape = unified(shape)
        if not BRepCheck_Analyzer(shape).IsValid():
            raise SystemExit(f"{name} is not valid")
        triangles = random_parts.meshed(shape, DEFLECTION, ANGLE)[0].astype(np.float32)
        random_parts.assert_closed(triangles)
        random_parts.write_stl(triangles, os.path.join(folder, f"{name}.stl"))
        truth = {"volume": volume_of(shape), "bores": sorted(bores), "kinds": random_parts.kinds_of(shape)}
        with open(os.path.join(folder, f"{name}.json"), "w") as out:
            json.dump(truth, out)


# ---- operating


def ancestors(shape, kind, of):
    """The parts of a shape of one kind that have each part of another kind."""
    found = TopTools_IndexedDataMapOfShapeListOfShape()
    TopExp.MapShapesAndUniqueAncestors_s(shape, kind, of, found)
    return found


def along(edge):
    return np.array(occ.xyz(BRepAdaptor_Curve(edge).Line().Direction()))


def outer_normal(face):
    normal = np.array(occ.xyz(BRepAdaptor_Surface(face).Plane().Axis().Direction()))
    is_left = not BRepAdaptor_Surface(face).Plane().Position().Direct()
    return -normal if (face.Orientation() == TopAbs_REVERSED) != is_left else normal


def bores_of(shape):
    """The radii of the cylinders that go all around, and whose material is outside."""
    found = []
    for face in occ.faces_of(shape):
        surface = BRepAdaptor_Surface(face)
        if surface.GetType() == GeomAbs_Cylinder:
            u0, u1, _, _ = BRepTools.UVBounds_s(face)
            outwards = surface.Cylinder().Position().Direct()
            if u1 - u0 > 2 * math.pi - ALIGNED and (face.Orientation() == TopAbs_REVERSED) == outwards:
                found.append(surface.Cylinder().Radius())
    return sorted(found)


def is_square(edges):
    """Whether three straight edges are perpendicular to each other."""
    edges = [TopoDS.Edge_s(edge) for edge in edges]
    if len(edges) != 3 or any(BRepAdaptor_Curve(edge).GetType() != GeomAbs_Line for edge in edges):
        return False
    a, b, c = map(along, edges)
    return max(abs(a @ b), abs(b @ c), abs(c @ a)) < ALIGNED


def square_edge(shape, size):
    """The longest straight edge that ends in square corners of three planes and stands out, and its length."""
    edges_of = ancestors(shape, TopAbs_VERTEX, TopAbs_EDGE)
    faces_of = ancestors(shape, TopAbs_VERTEX, TopAbs_FACE)
    sides_of = ancestors(shape, TopAbs_EDGE, TopAbs_FACE)
    best = (0.0, None)
    for edge in occ.edges_of(shape):
        ends = occ.parts(edge, TopAbs_VERTEX)
        if len(ends) < 2 or not all(is_square(edges_of.FindFromKey(end)) for end in ends):
            continue
        around = [TopoDS.Face_s(face) for end in ends for face in faces_of.FindFromKey(end)]
        if any(BRepAdaptor_Surface(face).GetType() != GeomAbs_Plane for face in around):
            continue
        length = GCPnts_AbscissaPoint.Length_s(BRepAdaptor_Curve(edge))
        sides = [TopoDS.Face_s(face) for face in sides_of.FindFromKey(edge)]
        if length > best[0] and stands_out(shape, edge, sides, size):
            best = (length, edge)
    return best


def stands_out(shape, edge, sides, size):
    curve = BRepAdaptor_Curve(edge)
    middle = np.array(occ.xyz(curve.Value((curve.FirstParameter() + curve.LastParameter()) / 2)))
    across = 1e-3 * size * (outer_normal(sides[0]) - outer_normal(sides[1]))
    beside = [gp_Pnt(*(middle + sign * across)) for sign in (1, -1)]
    return not any(BRepClass3d_SolidClassifier(shape, p, 1e-7).State() == TopAbs_IN for p in beside)


def outer_plane(shape, size):
    """A place on the largest plane face that has all of the part on one side, and the face's outer normal."""
    random_parts.meshed(shape, 1e-3 * size, ANGLE)
    corners = {face: random_parts.triangles_of(face) for face in occ.faces_of(shape)}
    best = (0.0, None, None)
    for face, (points, triangles) in corners.items():
        if BRepAdaptor_Surface(face).GetType() != GeomAbs_Plane:
            continue
        out = outer_normal(face)
        if max((p @ out).max() for p, _ in corners.values()) > (points @ out).max() + 1e-6 * size:
            continue
        a, b, c = points[triangles].transpose(1, 0, 2)
        areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        if areas.sum() > best[0]:
            best = (areas.sum(), ((a + b + c) / 3)[areas.argmax()], out)
    return best[1:]


def said(shape, expected):
    valid = BRepCheck_Analyzer(shape).IsValid()
    return {"volume": volume_of(shape), "expected": expected, "valid": valid, "solids": len(occ.parts(shape, TopAbs_SOLID))}


def round_edge(shape, size):
    length, edge = square_edge(shape, size)
    if edge is None:
        return None
    fillet = BRepFilletAPI_MakeFillet(shape)
    fillet.Add(ROUND * size, edge)
    return said(fillet.Shape(), volume_of(shape) - (1.0 - math.pi / 4) * (ROUND * size) ** 2 * length)


def padded(shape, size):
    at, out = outer_plane(shape, size)
    if at is None:
        return None
    pad = cylinder(*map(float, at), CIRCLE * size, HEIGHT * size, map(float, out))
    return said(BRepAlgoAPI_Fuse(shape, pad).Shape(), volume_of(shape) + volume_of(pad))


def over(shape):
    """A box over a part of the shape, none of whose sides is on a face of it, and the size of the shape."""
    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box)
    low, high = (np.array(occ.xyz(corner)) for corner in (box.CornerMin(), box.CornerMax()))
    sides = high - low
    corner = low - sides * [0.11, 0.13, 0.07]
    tool = BRepPrimAPI_MakeBox(gp_Pnt(*corner), *(sides * [0.643, 0.671, 1.14])).Shape()
    return tool, float(np.linalg.norm(sides))


def operated(path):
    # As programs read it: only healing gives a ball the edges at its poles, which operations need.
    shape = occ.read(path, heal=True)[2]
    tool, size = over(shape)
    volume, both = volume_of(shape), volume_of(BRepAlgoAPI_Common(shape, tool).Shape())
    return {
        "solids": len(occ.parts(shape, TopAbs_SOLID)),
        "valid": BRepCheck_Analyzer(shape).IsValid(),
        "check": occ.argument_faults(shape) or None,
        "volume": volume,
        "bores": bores_of(shape),
        "round": round_edge(shape, size),
        "pad": padded(shape, size),
        "cut": said(BRepAlgoAPI_Cut(shape, tool).Shape(), volume - both),
        "fuse": said(BRepAlgoAPI_Fuse(shape, tool).Shape(), volume + volume_of(tool) - both),
    }


if __name__ == "__main__":
    if sys.argv[1] == "make":
        make(sys.argv[2])
    else:
        json.dump(operated(sys.argv[1]), occ.ANSWER)
        occ.ANSWER.write("\n")
    occ.ANSWER.flush()
    sys.stderr.flush()
    os._exit(0)
