#!/usr/bin/env python3
"""Reads a 3MF file with lib3mf, and describes the places of its meshes.

    python places_3mf.py FILE

The script prints one JSON object: `places` has for each place of a mesh the number of its triangles and its bounds in mm, `left_out`
the number of places of objects that are no models. It prints `null` if lib3mf does not open the file.
"""

import json
import sys

import lib3mf
from lib3mf import get_wrapper

#: mm by the number of the unit: micrometre, millimetre, centimetre, inch, foot, metre.
UNITS = [0.001, 1.0, 10.0, 25.4, 304.8, 1000.0]


def after(outer, inner):
    """The map that applies `inner` first. Both are four rows of three numbers: the images of the axes, and the offset."""
    rows = []
    for k, row in enumerate(inner):
        offset = outer[3] if k == 3 else [0.0] * 3
        rows.append([sum(row[i] * outer[i][j] for i in range(3)) + offset[j] for j in range(3)])
    return rows


def rows_of(transform):
    return [list(row) for row in transform.Fields]


def meshes(thing, placement):
    """The mesh objects below an object, each with its map."""
    if thing.IsMeshObject():
        return [(thing, placement)]
    found = []
    for k in range(thing.GetComponentCount()):
        component = thing.GetComponent(k)
        inner = rows_of(component.GetTransform()) if component.HasTransform() else IDENTITY
        found += meshes(component.GetObjectResource(), after(placement, inner))
    return found


IDENTITY = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]


def main():
    wrapper = get_wrapper()
    model = wrapper.CreateModel()
    reader = model.QueryReader("3mf")
    try:
        reader.ReadFromFile(sys.argv[1])
    except lib3mf.ELib3MFException:
        print("null")
        return
    mm = UNITS[int(model.GetUnit())]
    places, left_out = [], 0
    items = model.GetBuildItems()
    while items.MoveNext():
        item = items.GetCurrent()
        start = rows_of(item.GetObjectTransform()) if item.HasObjectTransform() else IDENTITY
        for mesh, rows in meshes(item.GetObjectResource(), start):
            if mesh.GetTriangleCount() == 0 or int(mesh.GetType()) not in (0, 1):
                left_out += 1
                continue
            corners = {k for t in mesh.GetTriangleIndices() for k in t.Indices}
            points = [mesh.GetVertex(k).Coordinates for k in corners]
            moved = [after(rows, [list(p)] * 4)[3] for p in points]
            bounds = [[mm * pick(p[k] for p in moved) for k in range(3)] for pick in (min, max)]
            places.append({"triangles": mesh.GetTriangleCount(), "bounds": bounds})
    print(json.dumps({"places": places, "left_out": left_out}))


main()
