#!/usr/bin/env python3
"""make_kinds.py FOLDER: shapes of each kind of surface, curve and placement as STEP and IGES.

NAME.json has the area of each shape as OpenCASCADE integrates it in two ways, its volume, its bounding box, and
vertices of a tessellation."""

import json
import math
import sys
from pathlib import Path

import numpy

from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepAlgoAPI import BRepAlgoAPI_Common, BRepAlgoAPI_Cut
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakeWire,
    BRepBuilderAPI_NurbsConvert,
    BRepBuilderAPI_Transform,
)
from OCP.BRepGProp import BRepGProp
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeBox,
    BRepPrimAPI_MakeCone,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakePrism,
    BRepPrimAPI_MakeRevol,
    BRepPrimAPI_MakeSphere,
    BRepPrimAPI_MakeTorus,
)
from OCP.Bnd import Bnd_Box
from OCP.GProp import GProp_GProps
from OCP.Geom import (
    Geom_Circle,
    Geom_CylindricalSurface,
    Geom_Ellipse,
    Geom_Hyperbola,
    Geom_OffsetSurface,
    Geom_Parabola,
    Geom_SurfaceOfLinearExtrusion,
    Geom_SurfaceOfRevolution,
    Geom_TrimmedCurve,
)
from OCP.GeomAPI import GeomAPI_PointsToBSpline, GeomAPI_PointsToBSplineSurface
from OCP.IGESControl import IGESControl_Writer
from OCP.Interface import Interface_Static
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Controller, STEPControl_Writer
from OCP.TColgp import TColgp_Array1OfPnt, TColgp_Array2OfPnt
from OCP.TopAbs import TopAbs_FACE, TopAbs_SOLID
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Compound
from OCP.gp import gp_Ax1, gp_Ax2, gp_Ax3, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec

ORIGIN = gp_Pnt(3.0, -2.0, 5.0)
TILTED = gp_Ax2(ORIGIN, gp_Dir(0.3, 0.5, 0.8), gp_Dir(1.0, 0.2, -0.1))


def box(x, y, z, corner=gp_Pnt(0, 0, 0)):
    return BRepPrimAPI_MakeBox(corner, x, y, z).Shape()


def cut(a, b):
    return BRepAlgoAPI_Cut(a, b).Shape()


def common(a, b):
    return BRepAlgoAPI_Common(a, b).Shape()


def edge(curve, a=None, b=None):
    return BRepBuilderAPI_MakeEdge(curve).Edge() if a is None else BRepBuilderAPI_MakeEdge(curve, a, b).Edge()


def closed(*edges):
    wire = BRepBuilderAPI_MakeWire()
    for e in edges:
        wire.Add(e)
    return BRepBuilderAPI_MakeFace(wire.Wire()).Face()


def segment(a, b):
    return BRepBuilderAPI_MakeEdge(gp_Pnt(*a), gp_Pnt(*b)).Edge()


def bounded_by_chord(curve, a, b):
    """The plane face between an arc of a curve and its chord."""
    p, q = curve.Value(a), curve.Value(b)
    return closed(edge(curve, a, b), BRepBuilderAPI_MakeEdge(p, q).Edge())


def prism(face, x=1.0, y=2.0, z=6.0):
    return BRepPrimAPI_MakePrism(face, gp_Vec(x, y, z)).Shape()


def spline(points):
    array = TColgp_Array1OfPnt(1, len(points))
    for i, p in enumerate(points):
        array.SetValue(i + 1, gp_Pnt(*p))
    return GeomAPI_PointsToBSpline(array).Curve()


def patch():
    array = TColgp_Array2OfPnt(1, 6, 1, 5)
    for i in range(6):
        for j in range(5):
            array.SetValue(i + 1, j + 1, gp_Pnt(4 * i, 4 * j, math.sin(i) + 0.7 * math.cos(1.3 * j) * i / 5))
    return GeomAPI_PointsToBSplineSurface(array).Surface()


def face(surface, *ranges):
    return BRepBuilderAPI_MakeFace(surface, *ranges, 1e-7).Face()


def placed(shape, angle, axis, shift):
    turn = gp_Trsf()
    turn.SetRotation(gp_Ax1(gp_Pnt(1, 2, 3), gp_Dir(*axis)), angle)
    move = gp_Trsf()
    move.SetTranslation(gp_Vec(*shift))
    return shape.Moved(TopLoc_Location(move.Multiplied(turn)))


def compound(*shapes):
    builder, whole = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(whole)
    for shape in shapes:
        builder.Add(whole, shape)
    return whole


def vase():
    """A solid of revolution whose profile is a spline that ends on the axis."""
    profile = spline([(0, 0, 0), (3, 0, 0.5), (6, 0, 5), (4, 0, 9), (3, 0, 12), (0, 0, 14)])
    axis = gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))
    return BRepPrimAPI_MakeRevol(closed(edge(profile), segment((0, 0, 0), (0, 0, 14))), axis).Shape()


def shapes():
    sphere = BRepPrimAPI_MakeSphere(TILTED, 7.0).Shape()
    cylinder = BRepPrimAPI_MakeCylinder(TILTED, 4.0, 11.0).Shape()
    cone = BRepPrimAPI_MakeCone(TILTED, 5.0, 0.0, 9.0).Shape()
    torus = BRepPrimAPI_MakeTorus(TILTED, 9.0, 3.0).Shape()
    far = gp_Pnt(-20, -20, -20)
    flat = gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))
    axis = gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))
    ellipse = Geom_Ellipse(gp_Ax2(gp_Pnt(1, 1, 0), gp_Dir(0, 0, 1), gp_Dir(1, 1, 0)), 6.0, 3.0)
    hyperbola = Geom_Hyperbola(flat, 3.0, 2.0)
    parabola = Geom_Parabola(flat, 1.5)
    yield "box", box(3, 4, 5)
    yield "cylinder", cylinder
    yield "cone", cone
    yield "cone_cut", BRepPrimAPI_MakeCone(TILTED, 5.0, 2.0, 9.0).Shape()
    yield "sphere", sphere
    yield "torus", torus
    yield "sphere_part", BRepPrimAPI_MakeSphere(TILTED, 7.0, -0.4, 1.1, 4.0).Shape()
    yield "torus_part", BRepPrimAPI_MakeTorus(TILTED, 9.0, 3.0, -1.0, 2.0, 4.0).Shape()
    yield "cylinder_part", BRepPrimAPI_MakeCylinder(TILTED, 4.0, 11.0, 4.0).Shape()
    yield "cone_part", BRepPrimAPI_MakeCone(TILTED, 5.0, 0.0, 9.0, 2.0).Shape()
    through = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(0, 0, -20), gp_Dir(0, 0, 1)), 2.0, 40.0).Shape()
    ball = BRepPrimAPI_MakeSphere(flat, 7.0).Shape()
    yield "ball_through_poles", cut(ball, through)
    yield "ball_half_through_poles", cut(ball, box(20, 40, 40, gp_Pnt(0, -20, -20)))
    yield "ball_quarter", common(ball, box(20, 20, 40, gp_Pnt(0, 0, -20)))
    yield "ball_octant", common(ball, box(20, 20, 20))
    yield "ball_cap", cut(ball, box(40, 40, 40, gp_Pnt(-20, -20, -37)))
    side = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(-20, 0, 0.5), gp_Dir(1, 0, 0)), 1.5, 40.0).Shape()
    yield "ball_drilled", cut(ball, side)
    yield "cylinder_drilled", cut(BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(0, 0, -9), gp_Dir(0, 0, 1)), 4.0, 18.0).Shape(), side)
    yield "cone_drilled", cut(BRepPrimAPI_MakeCone(gp_Ax2(gp_Pnt(0, 0, -5), gp_Dir(0, 0, 1)), 6.0, 0.0, 15.0).Shape(), side)
    ring = BRepPrimAPI_MakeTorus(flat, 9.0, 3.0).Shape()
    yield "torus_drilled", cut(ring, side)
    yield "torus_half", cut(ring, box(40, 40, 40, gp_Pnt(-20, -20, 0.7)))
    yield "torus_tilted_cut", cut(torus, box(40, 40, 22, far))
    yield "sphere_tilted_cut", cut(sphere, box(40, 40, 22, far))
    yield "cone_tilted_cut", cut(cone, box(40, 40, 27, far))
    yield "cylinder_tilted_cut", cut(cylinder, box(40, 40, 30, far))
    whole = swept(ellipse, (1, 2, 6), numpy.linspace(0, 2 * math.pi, 33)) + 2 * math.pi * 6 * 3
    yield "ellipse_prism", prism(closed(edge(ellipse))), whole
    yield "hyperbola_prism", prism(bounded_by_chord(hyperbola, -1.2, 1.5))
    yield "parabola_prism", prism(bounded_by_chord(parabola, -4.0, 5.0))
    wave = spline([(0, 0, 0), (4, 3, 0), (8, -1, 0), (11, 2, 0)])
    yield "spline_prism", prism(closed(edge(wave), segment((0, 0, 0), (0, -6, 0)), segment((0, -6, 0), (11, -6, 0)), segment((11, -6, 0), (11, 2, 0))))
    yield "vase", vase()
    yield "vase_part", common(vase(), box(20, 20, 20))
    off = Geom_Circle(gp_Ax2(gp_Pnt(7, 0, 2), gp_Dir(0, 1, 0)), 2.5)
    yield "revolved_circle", BRepPrimAPI_MakeRevol(closed(edge(off)), axis, 2.2).Shape()
    tall = Geom_Ellipse(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(0, -1, 0), gp_Dir(0, 0, 1)), 6.0, 3.0)
    half = closed(edge(tall, 0.0, math.pi), segment((0, 0, -6), (0, 0, 6)))
    yield "egg", BRepPrimAPI_MakeRevol(half, axis).Shape()
    lemon = Geom_Circle(gp_Ax2(gp_Pnt(-2, 0, 0), gp_Dir(0, -1, 0), gp_Dir(1, 0, 0)), 5.0)
    angle = math.acos(2 / 5)
    top = math.sqrt(25 - 4)
    yield "lemon", BRepPrimAPI_MakeRevol(closed(edge(lemon, -angle, angle), segment((0, 0, top), (0, 0, -top))), axis).Shape()
    yield "patch", face(patch(), 0.0, 1.0, 0.0, 1.0)
    yield "offset_patch", face(Geom_OffsetSurface(patch(), 0.8), 0.1, 0.9, 0.2, 1.0)
    slanted = gp_Dir(0.1, 0.2, 1)
    lines = [7 * x for x in (slanted.X(), slanted.Y(), slanted.Z())]
    whole = swept(wave, lines, numpy.linspace(0, 1, 65))
    yield "extruded_face", face(Geom_SurfaceOfLinearExtrusion(wave, slanted), 0.0, 1.0, 0.0, 7.0), whole
    arc = Geom_TrimmedCurve(ellipse, 0.3, 2.9)
    yield "extruded_arc", face(Geom_SurfaceOfLinearExtrusion(arc, gp_Dir(0, 0, 1)), 0.3, 2.9, -1.0, 7.0)
    yield "revolved_face", face(Geom_SurfaceOfRevolution(spline([(5, 0, 0), (7, 0, 3), (4, 0, 6)]), axis), 0.5, 4.0, 0.0, 1.0)
    yield "pipe_piece", face(Geom_CylindricalSurface(gp_Ax3(TILTED), 4.0), 1.0, 8.0 - 2.0, -2.0, 5.0)
    for name, shape in [("cylinder", cylinder), ("cone", cone), ("sphere", sphere), ("torus", torus), ("ball_drilled", cut(ball, side))]:
        yield name + "_nurbs", BRepBuilderAPI_NurbsConvert(shape).Shape()
    hollow = cut(box(20, 20, 20, gp_Pnt(-10, -10, -10)), ball)
    yield "hollow", hollow
    part = compound(cylinder, placed(cone, 0.7, (1, 2, 3), (10, 0, 4)))
    yield "assembly", compound(part, placed(part, 1.9, (-1, 2, 0.5), (-30, 12, 8)), placed(cone, 3.0, (0, 1, 0), (5, 40, 0)))
    mirror = gp_Trsf()
    mirror.SetMirror(gp_Ax2(gp_Pnt(1, 2, 3), gp_Dir(0.2, 1, 0.4)))
    yield "mirrored", BRepBuilderAPI_Transform(cut(ball, side), mirror, True).Shape()


def swept(curve, direction, ranges):
    """The area that a curve sweeps along a vector. OpenCASCADE integrates it to three digits."""
    nodes, weights = numpy.polynomial.legendre.leggauss(20)
    area, along = 0.0, gp_Vec(*direction)
    for a, b in zip(ranges, ranges[1:]):
        for node, weight in zip(nodes, weights):
            point, tangent = gp_Pnt(), gp_Vec()
            curve.D1(0.5 * (a + b) + 0.5 * (b - a) * node, point, tangent)
            area += 0.5 * (b - a) * weight * tangent.Crossed(along).Magnitude()
    return area


def mass(shape, properties, *accuracy):
    found = GProp_GProps()
    properties(shape, found, *accuracy)
    return found.Mass()


def vertices(shape, size):
    """Vertices of a tessellation."""
    BRepMesh_IncrementalMesh(shape, 1e-3 * size, False, 0.3, False)
    faces, points = TopExp_Explorer(shape, TopAbs_FACE), []
    while faces.More():
        location = TopLoc_Location()
        mesh = BRep_Tool.Triangulation_s(TopoDS.Face_s(faces.Current()), location)
        for i in range(1, mesh.NbNodes() + 1, 1 + mesh.NbNodes() // 50):
            p = mesh.Node(i).Transformed(location.Transformation())
            points.append((p.X(), p.Y(), p.Z()))
        faces.Next()
    return points


def volume(shape):
    solids, sum_ = TopExp_Explorer(shape, TopAbs_SOLID), 0.0
    while solids.More():
        sum_ += mass(solids.Current(), BRepGProp.VolumeProperties_s, 1e-9)
        solids.Next()
    return sum_


# What OpenCASCADE does not write to IGES as it is: it has no hyperbolas, parabolas without ends, and a wrong curve
# where a plane cuts a cylinder.
NO_IGES = ["hyperbola_prism", "parabola_prism", "cylinder_tilted_cut"]


def write(shape, folder, name, exact):
    bounds = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, bounds, False, False)
    box = bounds.Get()
    areas = [mass(shape, BRepGProp.SurfaceProperties_s), mass(shape, BRepGProp.SurfaceProperties_s, 1e-9)]
    truth = {
        "areas": areas if exact is None else [exact],
        "volume": volume(shape),
        "box": box,
        "points": vertices(shape, math.dist(box[:3], box[3:])),
    }
    (folder / f"{name}.json").write_text(json.dumps(truth))

    def step(suffix, **settings):
        Interface_Static.SetCVal_s("write.step.unit", settings.get("unit", "MM"))
        Interface_Static.SetIVal_s("write.surfacecurve.mode", settings.get("pcurves", 1))
        Interface_Static.SetIVal_s("write.step.assembly", settings.get("assembly", 0))
        writer = STEPControl_Writer()
        writer.Transfer(shape, STEPControl_AsIs)
        writer.Write(str(folder / f"{name}{suffix}.step"))

    step("")
    step(".bare", pcurves=0)
    if name in ("cone_drilled", "sphere_part", "assembly"):
        step(".inch", unit="INCH")
        step(".metre", unit="M")
    if name == "assembly":
        step(".nested", assembly=1)
        step(".nested_inch", assembly=1, unit="INCH")
    for mode, suffix in [] if name in NO_IGES else [(0, ".trimmed"), (1, ".brep")]:
        writer = IGESControl_Writer("INCH" if name == "cone_drilled" else "MM", mode)
        writer.AddShape(shape)
        writer.ComputeModel()
        writer.Write(str(folder / f"{name}{suffix}.igs"))


def main(folder):
    STEPControl_Controller.Init_s()
    for name, shape, *exact in shapes():
        write(shape, Path(folder), name, exact[0] if exact else None)


main(sys.argv[1])
