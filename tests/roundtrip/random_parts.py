#!/usr/bin/env python3
"""Makes random parts of boxes, cylinders, cones, balls and rings, and judges STEP files of them, with OpenCASCADE.

    python random_parts.py make FOLDER SEED ...
    python random_parts.py check FOLDER SEED ...

`make` writes FOLDER/SEED.stl, which is binary, and FOLDER/SEED.json, the truth. A seed always gives the same part.
Seeds whose last digit is even give parts as designers make them: along the axes, with sizes on a lattice. The others
are turned at random.

`check` reads FOLDER/SEED.step without healing and prints a JSON object that has an entry for each seed.
Lengths are in millimetres.
"""

import json
import math
import os
import random
import struct
import sys

import check_occ as occ
import numpy as np
from check_solid_occ import surfaces_of
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeBox,
    BRepPrimAPI_MakeCone,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakeSphere,
    BRepPrimAPI_MakeTorus,
)
from OCP.BRepTools import BRepTools
from OCP.GProp import GProp_GProps
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt, gp_Quaternion, gp_Trsf, gp_Vec
from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_REVERSED, TopAbs_SOLID
from OCP.TopExp import TopExp
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS
from OCP.TopTools import TopTools_IndexedDataMapOfShapeListOfShape

KINDS = ("plane", "cylinder", "cone", "sphere", "torus")

# Parts that OpenCASCADE cannot make are made anew, so many times.
TRIES = 50

# The seed of the shape is that of the part times this, plus the number of the try.
PRIME = 1000003

# Sides of primitives are 0.1 to 1 times this.
SIZE = 40.0

# Designers' sizes are multiples of this.
LATTICE = 0.5

# The vertices of a mesh lie on the surfaces of their faces within this share of the part's size. It is that of a
# step of its numbers of 32 bits. OpenCASCADE approximates some edges, and is worse there.
ON_SURFACE = 2.0**-23

# The volume is integrated to this share. OpenCASCADE's other adaptive rule does not end on some edges of many knots.
INTEGRAL = 1e-8

# Two surfaces are one if their parameters differ by no more than this.
SAME = 1e-6


class Impossible(Exception):
    """OpenCASCADE cannot make the part, or its mesh is not that of a solid."""


class Chance:
    """Random numbers of a part. `is_designed` keeps to the axes and to a lattice."""

    def __init__(self, seed, is_designed):
        self.random = random.Random(seed)
        self.is_designed = is_designed

    def size(self, low, high):
        value = self.random.uniform(low, high)
        return max(LATTICE, LATTICE * round(value / LATTICE)) if self.is_designed else value

    def place(self, reach):
        return [self.size_of_either_sign(reach) for _ in range(3)]

    def size_of_either_sign(self, reach):
        value = self.random.uniform(-reach, reach)
        return LATTICE * round(value / LATTICE) if self.is_designed else value

    def direction(self):
        if self.is_designed:
            axis = [0.0, 0.0, 0.0]
            axis[self.random.randrange(3)] = self.random.choice((-1.0, 1.0))
            return axis
        while True:
            axis = [self.random.gauss(0.0, 1.0) for _ in range(3)]
            length = math.hypot(*axis)
            if length > 1e-3:
                return [x / length for x in axis]

    def axes(self, reach):
        return gp_Ax2(gp_Pnt(*self.place(reach)), gp_Dir(*self.direction()))


def primitive(chance, reach, largest):
    """A primitive whose origin is at most `reach` from the middle in each coordinate."""
    kind = chance.random.choice(KINDS)
    axes = chance.axes(reach)
    side = lambda low, high: chance.size(low * largest, high * largest)
    if kind == "plane":
        return BRepPrimAPI_MakeBox(axes, side(0.2, 1.0), side(0.2, 1.0), side(0.2, 1.0)).Shape()
    if kind == "cylinder":
        return BRepPrimAPI_MakeCylinder(axes, side(0.1, 0.4), side(0.3, 1.2)).Shape()
    if kind == "cone":
        wide, narrow = side(0.15, 0.4), side(0.0, 0.3)
        if chance.random.random() < 0.3:
            narrow = 0.0
        if wide == narrow:
            wide += LATTICE
        return BRepPrimAPI_MakeCone(axes, wide, narrow, side(0.2, 0.8)).Shape()
    if kind == "sphere":
        return BRepPrimAPI_MakeSphere(axes, side(0.15, 0.45)).Shape()
    tube = side(0.05, 0.12)
    return BRepPrimAPI_MakeTorus(axes, tube + side(0.08, 0.3), tube).Shape()


def operated(shape, tool, fuses):
    operation = (BRepAlgoAPI_Fuse if fuses else BRepAlgoAPI_Cut)(shape, tool)
    if not operation.IsDone():
        raise Impossible("the operation fails")
    return operation.Shape()


def posed(shape, chance):
    """The part anywhere. Every other part of designers stays where it is."""
    if chance.is_designed and chance.random.random() < 0.5:
        return shape
    turn = [chance.random.gauss(0.0, 1.0) for _ in range(4)]
    length = math.hypot(*turn)
    move = gp_Trsf()
    move.SetRotation(gp_Quaternion(*(x / length for x in turn)))
    move.SetTranslationPart(gp_Vec(*(chance.random.uniform(-60.0, 60.0) for _ in range(3))))
    return BRepBuilderAPI_Transform(shape, move, True).Shape()


def part(chance):
    """A solid of 2 to 12 operations, and their number."""
    shape = primitive(chance, 0.0, SIZE)
    operations = chance.random.randint(2, 12)
    for _ in range(operations):
        tool = primitive(chance, 0.35 * SIZE, 0.8 * SIZE)
        shape = operated(shape, tool, chance.random.random() < 0.45)
    unify = ShapeUpgrade_UnifySameDomain(shape, True, True, False)
    unify.Build()
    shape = posed(unify.Shape(), chance)
    if not BRepCheck_Analyzer(shape).IsValid() or not occ.parts(shape, TopAbs_SOLID):
        raise Impossible("it is no valid solid")
    return shape, operations


def kind_of(face):
    kind = str(BRepAdaptor_Surface(face, False).GetType()).rsplit("_", 1)[-1].lower()
    if kind not in KINDS:
        raise Impossible(f"it has a {kind}")
    return kind


def parameters(face):
    """What two faces of one surface have in common, as numbers."""
    surface = BRepAdaptor_Surface(face, False)
    kind = kind_of(face)
    frame = getattr(surface, kind.capitalize())()
    position = frame.Position()
    place, axis = np.array(occ.xyz(position.Location())), np.array(occ.xyz(position.Direction()))
    # The sense of an axis says nothing.
    axis = axis * np.sign(axis[np.argmax(np.abs(axis) > 0.5 / math.sqrt(3.0))])
    if kind == "plane":
        return [*axis, place @ axis]
    foot = place - (place @ axis) * axis
    if kind == "cylinder":
        return [*axis, *foot, frame.Radius()]
    if kind == "cone":
        return [*axis, *occ.xyz(frame.Apex()), abs(frame.SemiAngle())]
    if kind == "sphere":
        return [*place, frame.Radius()]
    return [*axis, *place, frame.MajorRadius(), frame.MinorRadius()]


def kinds_of(shape):
    """How many faces of each kind there are. Neighbours on one surface are one face."""
    faces = occ.faces_of(shape)
    number = {face: i for i, face in enumerate(faces)}
    root = list(range(len(faces)))

    def find(i):
        while root[i] != i:
            i = root[i]
        return i

    of_edges = TopTools_IndexedDataMapOfShapeListOfShape()
    TopExp.MapShapesAndAncestors_s(shape, TopAbs_EDGE, TopAbs_FACE, of_edges)
    known = [(kind_of(face), np.array(parameters(face))) for face in faces]
    for i in range(1, of_edges.Extent() + 1):
        around = [
            next(j for f, j in number.items() if f.IsSame(face)) for face in of_edges.FindFromIndex(i)
        ]
        for a, b in zip(around, around[1:]):
            if known[a][0] == known[b][0] and np.abs(known[a][1] - known[b][1]).max() < SAME:
                root[find(a)] = find(b)
    kinds = {}
    for i, (kind, _) in enumerate(known):
        if find(i) == i:
            kinds[kind] = kinds.get(kind, 0) + 1
    return kinds


def distances(face, points):
    """The distances of points from the unbounded surface of a face."""
    surface = BRepAdaptor_Surface(face, False)
    kind = kind_of(face)
    frame = getattr(surface, kind.capitalize())()
    position = frame.Position()
    away = points - occ.xyz(position.Location())
    along = away @ np.array(occ.xyz(position.Direction()))
    if kind == "plane":
        return np.abs(along)
    if kind == "sphere":
        return np.abs(np.linalg.norm(away, axis=1) - frame.Radius())
    across = np.sqrt(np.maximum((away**2).sum(1) - along**2, 0.0))
    if kind == "cylinder":
        return np.abs(across - frame.Radius())
    if kind == "torus":
        return np.abs(np.hypot(across - frame.MajorRadius(), along) - frame.MinorRadius())
    apex = np.array(occ.xyz(frame.Apex())) - occ.xyz(position.Location())
    tip = apex @ np.array(occ.xyz(position.Direction()))
    sine, cosine = math.sin(abs(frame.SemiAngle())), math.cos(frame.SemiAngle())
    return np.abs(across * cosine - np.abs(along - tip) * sine)


def meshed(shape, deflection, angle):
    """The triangles, the bound of the volume between them and the surfaces, and how far corners are off these."""
    BRepTools.Clean_s(shape)
    BRepMesh_IncrementalMesh(shape, deflection, False, angle, False)
    triangles, guard, off = [], 0.0, 0.0
    for face in occ.faces_of(shape):
        points, corners = triangles_of(face)
        off = max(off, distances(face, points).max())
        if kind_of(face) != "plane":
            guard += between(face, points, corners)
        triangles.append(points[corners])
    return np.concatenate(triangles), guard, off


def triangles_of(face):
    """The vertices of a face's mesh, and the numbers of the corners of each triangle."""
    place = TopLoc_Location()
    found = BRep_Tool.Triangulation_s(face, place)
    if found is None:
        raise Impossible("a face has no triangles")
    move = place.Transformation()
    points = [occ.xyz(found.Node(i).Transformed(move)) for i in range(1, found.NbNodes() + 1)]
    corners = np.array([found.Triangle(i).Get() for i in range(1, found.NbTriangles() + 1)]) - 1
    return np.array(points), corners[:, ::-1] if face.Orientation() == TopAbs_REVERSED else corners


def between(face, points, corners):
    """A bound of the volume between the triangles of a face and its surface: area times sagitta."""
    a, b, c = points[corners].transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    middles = ((a + b + c) / 3, (a + b) / 2, (b + c) / 2, (c + a) / 2)
    return float(areas @ np.max([distances(face, middle) for middle in middles], axis=0))


def assert_closed(triangles):
    """Whether each edge has exactly two triangles, one in each sense, when equal corners are one."""
    corners = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)[1].reshape(-1, 3)
    # Triangles at poles, and those that rounding flattens, are lines.
    corners = corners[(corners != np.roll(corners, -1, axis=1)).all(axis=1)]
    start, end = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    there = np.unique(np.stack((start, end)), axis=1)
    back = np.unique(np.stack((end, start)), axis=1)
    if there.shape[1] < len(start) or not np.array_equal(there, back):
        raise Impossible("the mesh is not closed, or touches itself along an edge")


def volume_of(shape):
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties, INTEGRAL, True, False)
    return properties.Mass()


def volume_within(triangles):
    a, b, c = triangles.transpose(1, 0, 2)
    return float((np.cross(a, b) * c).sum() / 6)


def tried(seed, attempt):
    chance = Chance(PRIME * seed + attempt, seed % 2 == 0)
    shape, operations = part(chance)
    low, high = np.array(occ.bounding_box(shape)).reshape(2, 3)
    size = float(np.linalg.norm(high - low))
    share = 1e-2 * 0.05 * 10.0 ** chance.random.uniform(0.0, 1.0)
    angle = chance.random.uniform(0.15, 0.5)
    exact, guard, off = meshed(shape, share * size, angle)
    triangles = exact.astype(np.float32)
    assert_closed(triangles)
    volume, volume_of_mesh = volume_of(shape), volume_within(exact)
    steps = ON_SURFACE * float(np.abs(exact).max())
    rounding = steps * occ.area_of(shape)
    if volume <= 0.0 or abs(volume_of_mesh - volume) > guard + rounding + off * occ.area_of(shape):
        raise Impossible("the mesh encloses another volume")
    tolerance = max(BRep_Tool.Tolerance_s(edge) for edge in occ.edges_of(shape))
    truth = {
        "seed": seed,
        "attempt": attempt,
        "designed": chance.is_designed,
        "operations": operations,
        "solids": len(occ.parts(shape, TopAbs_SOLID)),
        "kinds": kinds_of(shape),
        "size": size,
        "volume": volume,
        "area": occ.area_of(shape),
        "volume_of_mesh": volume_of_mesh,
        # A bound of the volume between the mesh and the part.
        "guard": guard,
        # What moving all vertices by a step of their numbers does to the volume.
        "rounding": rounding,
        "triangles": len(triangles),
        "deflection_pct": 100 * share,
        "angle": angle,
        # How far vertices are off their surfaces, in steps of their numbers.
        "off_steps": off / steps,
        "tolerance": tolerance,
    }
    return triangles, truth


def write_stl(triangles, path):
    record = np.zeros(len(triangles), dtype=[("normal", "<3f4"), ("corners", "<9f4"), ("rest", "<u2")])
    record["corners"] = triangles.reshape(-1, 9)
    with open(path, "wb") as out:
        out.write(bytes(80) + struct.pack("<I", len(triangles)) + record.tobytes())


def make(folder, seed):
    for attempt in range(TRIES):
        try:
            triangles, truth = tried(seed, attempt)
        except (Impossible, RuntimeError):
            continue
        with open(os.path.join(folder, f"{seed}.json"), "w") as out:
            json.dump(truth, out)
        write_stl(triangles, os.path.join(folder, f"{seed}.stl"))
        return
    raise SystemExit(f"{seed}: no part after {TRIES} tries")


def check(path):
    shape = occ.read(path, heal=False)[2]
    names = {"Plane": "plane", "CylindricalSurface": "cylinder", "ConicalSurface": "cone"}
    names |= {"SphericalSurface": "sphere", "ToroidalSurface": "torus"}
    kinds = {}
    for surface in surfaces_of(shape):
        kind = names.get(surface, surface)
        kinds[kind] = kinds.get(kind, 0) + 1
    return {
        "solids": len(occ.parts(shape, TopAbs_SOLID)),
        "valid": BRepCheck_Analyzer(shape).IsValid(),
        "kinds": kinds,
        "volume": volume_of(shape),
    }


def main():
    task, folder, *seeds = sys.argv[1:]
    if task == "make":
        for seed in seeds:
            make(folder, int(seed))
    else:
        found = {seed: check(os.path.join(folder, f"{seed}.step")) for seed in seeds}
        json.dump(found, occ.ANSWER)
    occ.ANSWER.flush()


if __name__ == "__main__":
    main()
    # Some of OpenCASCADE's destructors crash at exit, after the work.
    sys.stderr.flush()
    os._exit(0)
