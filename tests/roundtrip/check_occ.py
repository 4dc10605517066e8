#!/usr/bin/env python3
"""Reads a STEP or IGES file with OpenCASCADE and describes the result.

    python check_occ.py FILE [--points POINTS.txt]

The script prints one JSON object. It needs cadquery-ocp-novtk 7.9 and numpy. Each process reads only
one file, because some importers keep state.

OpenCASCADE heals shapes without a message. So the file is read twice: with the defaults, and with
healing off. "valid_unhealed", "oriented_loops" and "loops" belong to the second reading. Lengths are in
millimetres.
"""

import argparse
import json
import os
import re
import sys

# OpenCASCADE prints to stdout. Keep the real one for the result.
ANSWER = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)

import numpy as np
from OCP.Bnd import Bnd_Box
from OCP.BOPAlgo import BOPAlgo_ArgumentAnalyzer
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Curve2d
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.BRepTools import BRepTools
from OCP.BRepTopAdaptor import BRepTopAdaptor_FClass2d
from OCP.Geom import Geom_BSplineSurface
from OCP.Geom2d import Geom2d_BSplineCurve, Geom2d_TrimmedCurve
from OCP.GProp import GProp_GProps
from OCP.IGESControl import IGESControl_Reader
from OCP.IGESGeom import IGESGeom_BSplineCurve
from OCP.Interface import Interface_CheckTool, Interface_Static
from OCP.Resource import Resource_DataMapOfAsciiStringAsciiString
from OCP.STEPControl import STEPControl_Reader
from OCP.StepBasic import StepBasic_Product
from OCP.StepGeom import StepGeom_BSplineCurveWithKnots
from OCP.TCollection import TCollection_AsciiString
from OCP.TopAbs import (
    TopAbs_EDGE,
    TopAbs_FACE,
    TopAbs_FORWARD,
    TopAbs_IN,
    TopAbs_ON,
    TopAbs_REVERSED,
    TopAbs_VERTEX,
    TopAbs_WIRE,
)
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS, TopoDS_Iterator
from OCP.TopTools import TopTools_IndexedMapOfShape
from OCP.gp import gp_Pnt, gp_Pnt2d, gp_Vec

# Everything that the shape healing of the readers may do, without its "Mode".
FIXES = """
FixFreeShell FixFreeFace FixFreeWire FixSameParameter FixSolid FixShellOrientation
CreateOpenSolid FixShell FixFaceOrientation FixFace FixWire FixOrientation
FixAddNaturalBound FixMissingSeam FixSmallAreaWire RemoveSmallAreaFace
FixIntersectingWires FixLoopWires FixSplitFace AutoCorrectPrecision ModifyTopology
ModifyGeometry ClosedWire PreferencePCurve FixReorder FixSmall FixConnected
FixEdgeCurves FixDegenerated FixLacking FixSelfIntersection RemoveLoop
FixReversed2d FixRemovePCurve FixRemoveCurve3d FixAddPCurve FixAddCurve3d FixSeam
FixShifted FixEdgeSameParameter FixNotchedEdges FixTail FixSelfIntersectingEdge
FixIntersectingEdges FixNonAdjacentIntersectingEdges FixVertexPosition
FixVertexTolerance
""".split()


def is_step(path):
    return path.lower().endswith((".step", ".stp", ".p21"))


def read(path, heal):
    """The reader after the transfer, the number of its roots, and the shape."""
    reader = STEPControl_Reader() if is_step(path) else IGESControl_Reader()
    if not is_step(path):
        # Invisible entities do not count.
        Interface_Static.SetIVal_s("read.iges.onlyvisible", 1)
    if str(reader.ReadFile(path)).rsplit(".", 1)[-1] != "IFSelect_RetDone":
        raise SystemExit(f"{path}: cannot be read")
    if not heal:
        # Only after ReadFile: it creates what keeps the parameters. For IGES
        # they stay for the rest of the process, so healed comes first.
        off = Resource_DataMapOfAsciiStringAsciiString()
        for fix in FIXES:
            key = TCollection_AsciiString(f"FixShape.{fix}Mode")
            off.Bind(key, TCollection_AsciiString("0"))
        reader.SetShapeFixParameters(off)
    roots = reader.NbRootsForTransfer()
    reader.TransferRoots()
    return reader, roots, reader.OneShape()


def parts(shape, kind):
    found = TopTools_IndexedMapOfShape()
    TopExp.MapShapes_s(shape, kind, found)
    return [found.FindKey(i) for i in range(1, found.Extent() + 1)]


def children(shape, kind):
    it = TopoDS_Iterator(shape)
    found = []
    while it.More():
        if it.Value().ShapeType() == kind:
            found.append(it.Value())
        it.Next()
    return found


def faces_of(shape):
    return [TopoDS.Face_s(f) for f in parts(shape, TopAbs_FACE)]


def edges_of(shape):
    return [TopoDS.Edge_s(e) for e in parts(shape, TopAbs_EDGE)]


def forward(face):
    return TopoDS.Face_s(face.Oriented(TopAbs_FORWARD))


def signed_area(wire, face):
    """The signed area of a loop in (u, v). It is positive if the loop runs counter-clockwise."""
    area = 0.0
    for edge in children(wire, TopAbs_EDGE):
        curve = BRepAdaptor_Curve2d(TopoDS.Edge_s(edge), face)
        ts = np.linspace(curve.FirstParameter(), curve.LastParameter(), 257)
        uv = np.array([(p.X(), p.Y()) for p in (curve.Value(t) for t in ts)])
        if edge.Orientation() == TopAbs_REVERSED:
            uv = uv[::-1]
        a, b = uv[:-1], uv[1:]
        area += float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])) / 2
    return area


def loops_of(shape):
    """The signed areas of each face's loops. The outer loop of the importer comes first."""
    found = []
    for face in map(forward, faces_of(shape)):
        wires = [TopoDS.Wire_s(w) for w in children(face, TopAbs_WIRE)]
        areas = [signed_area(w, face) for w in wires]
        outer = max(range(len(areas)), key=lambda i: abs(areas[i]), default=0)
        found.append([areas[outer]] + [a for i, a in enumerate(areas) if i != outer])
    return found


def oriented(loops):
    return bool(loops) and all(a[0] > 0 and all(x < 0 for x in a[1:]) for a in loops)


def argument_faults(shape):
    """The faults from the check of the Boolean operations (FreeCAD's "Check geometry")."""
    check = BOPAlgo_ArgumentAnalyzer()
    check.SetShape1(shape)
    check.StopOnFirstFaulty = False
    for mode in (
        "ArgumentTypeMode",
        "SelfInterMode",
        "SmallEdgeMode",
        "RebuildFaceMode",
        "TangentMode",
        "MergeVertexMode",
        "MergeEdgeMode",
        "ContinuityMode",
        "CurveOnSurfaceMode",
    ):
        try:
            setattr(check, mode, True)
        except (AttributeError, TypeError):
            pass
    check.Perform()
    if not check.HasFaulty():
        return []
    return sorted({str(r.GetCheckStatus()).rsplit(".", 1)[-1] for r in check.GetCheckResult()})


def tolerance(shapes):
    return max((BRep_Tool.Tolerance_s(s) for s in shapes), default=0.0)


def area_of(shape):
    properties = GProp_GProps()
    # Without a bound, the area of a trimmed face is wrong by up to 0.4 %.
    BRepGProp.SurfaceProperties_s(shape, properties, 1e-5, False)
    return properties.Mass()


def file_faults(reader, path):
    """The faults from OpenCASCADE's check of each entity against its type."""
    model = reader.StepModel() if is_step(path) else reader.IGESModel()
    checks = Interface_CheckTool(model).CompleteCheckList()
    checks.Start()
    found = []
    while checks.More():
        check = checks.Value()
        found += [check.CFail(i + 1) for i in range(check.NbFails())]
        found += [check.CWarning(i + 1) for i in range(check.NbWarnings())]
        checks.Next()
    return found


def bounding_box(shape):
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, box, False, False)
    box.SetGap(0.0)
    low, high = box.CornerMin(), box.CornerMax()
    return [low.X(), low.Y(), low.Z(), high.X(), high.Y(), high.Z()]


def surface_facts(face):
    surface = BRep_Tool.Surface_s(face)
    net = None
    if isinstance(surface, Geom_BSplineSurface):
        net = [surface.NbUPoles(), surface.NbVPoles()]
    return type(surface).__name__, net


def entities(reader, path):
    model = reader.StepModel() if is_step(path) else reader.IGESModel()
    return (model.Value(i) for i in range(1, model.NbEntities() + 1))


def decoded(name):
    """Decodes the Part 21 escapes of non-ASCII characters, if they are still there."""
    def characters(match):
        width = 4 if match[1] == "2" else 8
        digits = match[2]
        codes = [digits[i : i + width] for i in range(0, len(digits), width)]
        return "".join(chr(int(code, 16)) for code in codes)

    return re.sub(r"\\X([24])\\([0-9A-F]+)\\X0\\", characters, name)


def name_of(reader, path):
    """The name of the product, or the name property of a visible IGES entity."""
    for entity in entities(reader, path):
        if isinstance(entity, StepBasic_Product):
            return decoded(entity.Name().ToCString())
        if not is_step(path) and entity.HasName():
            return entity.NameValue().ToCString()
    return None


def key_of(degree, poles):
    return degree, tuple((round(u, 12), round(v, 12)) for u, v in poles)


def either_way(degree, poles):
    return {key_of(degree, poles), key_of(degree, poles[::-1])}


def pcurves_in_file(reader, path):
    keys = set()
    for entity in entities(reader, path):
        if isinstance(entity, StepGeom_BSplineCurveWithKnots):
            points = [
                entity.ControlPointsListValue(i + 1) for i in range(entity.NbControlPointsList())
            ]
            if points[0].NbCoordinates() == 2:
                poles = [(p.CoordinatesValue(1), p.CoordinatesValue(2)) for p in points]
                keys |= either_way(entity.Degree(), poles)
        elif isinstance(entity, IGESGeom_BSplineCurve) and entity.UseFlag() == 5:
            points = [entity.Pole(i) for i in range(entity.UpperIndex() + 1)]
            keys |= either_way(entity.Degree(), [(p.X(), p.Y()) for p in points])
    return keys


def pcurves_kept(shape, keys):
    """The number of uses of edges with a pcurve of the file, and of all uses."""
    kept = uses = 0
    for face in map(forward, faces_of(shape)):
        surface_edges = [e for w in children(face, TopAbs_WIRE) for e in children(w, TopAbs_EDGE)]
        for edge in surface_edges:
            curve = BRep_Tool.CurveOnSurface_s(TopoDS.Edge_s(edge), face, 0.0, 0.0)
            if isinstance(curve, Geom2d_TrimmedCurve):
                curve = curve.BasisCurve()
            uses += 1
            if isinstance(curve, Geom2d_BSplineCurve):
                poles = [curve.Pole(i + 1) for i in range(curve.NbPoles())]
                kept += key_of(curve.Degree(), [(p.X(), p.Y()) for p in poles]) in keys
    return [kept, uses]


class Nearest:
    """The nearest of many samples."""

    def __init__(self, samples):
        self.samples = samples
        try:
            from scipy.spatial import cKDTree

            self.tree = cKDTree(samples)
        except ImportError:
            self.tree = None

    def __call__(self, points):
        if self.tree is not None:
            return self.tree.query(points)[1]
        squares = np.sum(self.samples**2, axis=1)
        found = []
        for start in range(0, len(points), 64):
            some = points[start : start + 64]
            found.append(np.argmin(squares - 2.0 * some @ self.samples.T, axis=1))
        return np.concatenate(found)


def xyz(p):
    return (p.X(), p.Y(), p.Z())


def solve(ata, atb):
    determinant = ata[0] * ata[2] - ata[1] * ata[1]
    if determinant <= 1e-14 * ata[0] * ata[2]:
        return 0.0, 0.0
    u = (ata[2] * atb[0] - ata[1] * atb[1]) / determinant
    v = (ata[0] * atb[1] - ata[1] * atb[0]) / determinant
    return u, v


def foot_on_surface(surface, target, u, v, bounds):
    """Gauss-Newton steps from a near sample. Returns the best (distance, u, v)."""
    best = (np.inf, u, v)
    p, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
    for _ in range(12):
        surface.D1(u, v, p, du, dv)
        gap = gp_Vec(p, target)
        if gap.Magnitude() < best[0]:
            best = (gap.Magnitude(), u, v)
        ata = (du.Dot(du), du.Dot(dv), dv.Dot(dv))
        step_u, step_v = solve(ata, (gap.Dot(du), gap.Dot(dv)))
        next_u = min(max(u + step_u, bounds[0]), bounds[1])
        next_v = min(max(v + step_v, bounds[2]), bounds[3])
        if abs(next_u - u) + abs(next_v - v) < 1e-12 * (bounds[1] - bounds[0]):
            break
        u, v = next_u, next_v
    return best


class FaceProbe:
    """The distances to one trimmed face."""

    def __init__(self, face):
        self.face = forward(face)
        self.surface = BRep_Tool.Surface_s(self.face)
        # Points beyond the edges count as on them within this distance.
        self.classifier = BRepTopAdaptor_FClass2d(self.face, 1e-9)
        self.bounds = BRepTools.UVBounds_s(self.face)
        count = 300
        _, net = surface_facts(face)
        if net:
            count = int(min(max(3 * max(net), 100), 500))
        us = np.linspace(self.bounds[0], self.bounds[1], count)
        vs = np.linspace(self.bounds[2], self.bounds[3], count)
        self.uv = [(u, v) for u in us for v in vs]
        value = self.surface.Value
        self.near = Nearest(np.array([xyz(value(u, v)) for u, v in self.uv]))
        self.edges = [BRepAdaptor_Curve(e) for e in edges_of(self.face)]
        self.edge_samples = []
        samples = []
        for curve in self.edges:
            for t in np.linspace(curve.FirstParameter(), curve.LastParameter(), 801):
                self.edge_samples.append((curve, t))
                samples.append(xyz(curve.Value(t)))
        self.near_edge = Nearest(np.array(samples))

    def distances(self, points):
        feet = self.near(points)
        found = np.empty(len(points))
        outside = []
        for i, (point, k) in enumerate(zip(points, feet)):
            target = gp_Pnt(*map(float, point))
            found[i], u, v = foot_on_surface(self.surface, target, *self.uv[k], self.bounds)
            if self.classifier.Perform(gp_Pnt2d(u, v)) not in (TopAbs_IN, TopAbs_ON):
                outside.append(i)
        if outside:
            for i, k in zip(outside, self.near_edge(points[outside])):
                found[i] = self.to_edge(points[i], k)
        return found

    def to_edge(self, point, k):
        curve, t = self.edge_samples[k]
        target = gp_Pnt(*map(float, point))
        low, high = curve.FirstParameter(), curve.LastParameter()
        best = np.inf
        p, d = gp_Pnt(), gp_Vec()
        for _ in range(12):
            curve.D1(t, p, d)
            gap = gp_Vec(p, target)
            best = min(best, gap.Magnitude())
            if d.SquareMagnitude() == 0.0:
                break
            t = min(max(t + gap.Dot(d) / d.SquareMagnitude(), low), high)
        return best


def distance(shape, path):
    points = np.loadtxt(path, usecols=(0, 1, 2), ndmin=2)
    found = np.min([FaceProbe(f).distances(points) for f in faces_of(shape)], axis=0)
    return {
        "points": len(points),
        "rms": float(np.sqrt(np.mean(found**2))),
        "max": float(np.max(found)),
        "p95": float(np.quantile(found, 0.95)),
    }


def report(path, points, is_healed):
    reader, roots, shape = read(path, heal=True)
    answer = {"file": os.path.basename(path), "roots": roots}
    answer["file_faults"] = file_faults(reader, path)
    if shape is None or shape.IsNull():
        return answer | {"faces": 0, "valid": False}
    faces = faces_of(shape)
    faults = argument_faults(shape)
    answer |= {
        "shape": str(shape.ShapeType()).rsplit("_", 1)[-1].lower(),
        "faces": len(faces),
        "edges": len(parts(shape, TopAbs_EDGE)),
        "vertices": len(parts(shape, TopAbs_VERTEX)),
        "wires_inner": sum(len(children(f, TopAbs_WIRE)) - 1 for f in faces),
        "valid": BRepCheck_Analyzer(shape).IsValid(),
        "argument_check": not faults,
        "argument_faults": faults,
        "max_tolerance_edge": tolerance(edges_of(shape)),
        "max_tolerance_vertex": tolerance(map(TopoDS.Vertex_s, parts(shape, TopAbs_VERTEX))),
        "pcurves_kept": pcurves_kept(shape, pcurves_in_file(reader, path)),
        "bbox": bounding_box(shape),
        "area": area_of(shape),
        "name": name_of(reader, path),
    }
    answer["surface_type"], answer["net"] = surface_facts(faces[0]) if faces else (None, None)
    if points:
        answer["distance"] = distance(shape, points)
    if is_healed:
        return answer
    _, _, raw = read(path, heal=False)
    answer["valid_unhealed"] = BRepCheck_Analyzer(raw).IsValid()
    answer["loops"] = loops_of(raw)
    answer["oriented_loops"] = oriented(answer["loops"])
    return answer


def main():
    parser = argparse.ArgumentParser(description="What OpenCASCADE makes of a CAD file, as JSON.")
    parser.add_argument("file")
    parser.add_argument("--points", help="text file of x y z, to measure to the trimmed face")
    # The wires of trimmed surfaces (IGES 144) are not connected without healing, and the check of
    # some of them ends the process.
    parser.add_argument("--healed", action="store_true", help="only what healing makes of the file")
    options = parser.parse_args()
    json.dump(report(options.file, options.points, options.healed), ANSWER)
    ANSWER.write("\n")
    ANSWER.flush()


if __name__ == "__main__":
    main()
    # Some of OpenCASCADE's destructors crash at exit, after the result.
    sys.stderr.flush()
    os._exit(0)
