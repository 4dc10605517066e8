#!/usr/bin/env python3
"""Reads a solid's STEP or IGES file with OpenCASCADE without healing and describes the result.

    python check_solid_occ.py FILE

The script prints one JSON object. Lengths are in millimetres.
"""

import json
import os
import sys

import check_occ as occ
from OCP.BRep import BRep_Tool
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.TopAbs import (
    TopAbs_EDGE,
    TopAbs_FACE,
    TopAbs_SHELL,
    TopAbs_SOLID,
    TopAbs_VERTEX,
)
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS
from OCP.TopTools import TopTools_IndexedDataMapOfShapeListOfShape


def volume_of(shape):
    properties = GProp_GProps()
    # The plain rule of fixed order is 2e-7 off on a rational torus.
    BRepGProp.VolumePropertiesGK_s(shape, properties, 1e-12, True, True, False, False, False)
    return properties.Mass()


def uses_of_edges(shape):
    """How many edges have each number of faces; seams count twice, and poles are no edges."""
    counts = {}
    faces = TopTools_IndexedDataMapOfShapeListOfShape()
    TopExp.MapShapesAndAncestors_s(shape, TopAbs_EDGE, TopAbs_FACE, faces)
    for i in range(1, faces.Extent() + 1):
        if BRep_Tool.Degenerated_s(TopoDS.Edge_s(faces.FindKey(i))):
            continue
        number = str(faces.FindFromIndex(i).Extent())
        counts[number] = counts.get(number, 0) + 1
    return counts


def surfaces_of(shape):
    """The kind of each face's surface, in alphabetical order."""
    faces = occ.parts(shape, TopAbs_FACE)
    kinds = (type(BRep_Tool.Surface_s(TopoDS.Face_s(face))).__name__ for face in faces)
    return sorted(kind.removeprefix("Geom_") for kind in kinds)


def tolerance_of(shape):
    edges = map(TopoDS.Edge_s, occ.parts(shape, TopAbs_EDGE))
    return max(BRep_Tool.Tolerance_s(edge) for edge in edges)


def report(path):
    shape = occ.read(path, heal=False)[2]
    kinds = {"solids": TopAbs_SOLID, "shells": TopAbs_SHELL, "faces": TopAbs_FACE}
    kinds |= {"edges": TopAbs_EDGE, "vertices": TopAbs_VERTEX}
    answer = {name: len(occ.parts(shape, kind)) for name, kind in kinds.items()}
    return answer | {
        "valid": BRepCheck_Analyzer(shape).IsValid(),
        "volume": volume_of(shape),
        "uses": uses_of_edges(shape),
        "surfaces": surfaces_of(shape),
        "tolerance": tolerance_of(shape),
        "argument_faults": occ.argument_faults(shape),
    }


if __name__ == "__main__":
    json.dump(report(sys.argv[1]), occ.ANSWER)
    occ.ANSWER.write("\n")
    occ.ANSWER.flush()
    sys.stderr.flush()
    os._exit(0)
