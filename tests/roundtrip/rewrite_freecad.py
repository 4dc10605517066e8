#!/usr/bin/env python3
"""Does the typical next steps of a user with a STEP file in FreeCAD, and writes the results.

    /usr/bin/python3 rewrite_freecad.py FILE FOLDER DISTANCE

The script writes FOLDER/NAME.step and NAME.igs, where NAME is fc-plain (unchanged), fc-cut (the half
that a box leaves), fc-offset (DISTANCE mm above) or fc-thick (the solid between the two). It prints
their areas in mm² as a JSON object.
"""

import json
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from check_freecad import ANSWER, FreeCAD, Part, bounding_box, load, shapes_of  # noqa: E402


def half(shape):
    box = bounding_box(shape)
    margin = box.DiagonalLength * 0.1 + 1.0
    corner = FreeCAD.Vector(box.XMin - margin, box.YMin - margin, box.ZMin - margin)
    lengths = (box.XLength * 0.47, box.YLength + margin, box.ZLength + margin)
    return shape.cut(Part.makeBox(*(length + margin for length in lengths), corner))


def main():
    source, folder, distance = sys.argv[1:]
    import Import

    document = load(os.path.abspath(source))
    (thing,) = shapes_of(document)
    shape, distance = thing.Shape, float(distance)
    results = {
        "fc-plain": shape,
        "fc-cut": half(shape),
        "fc-offset": shape.makeOffsetShape(distance, 1e-3),
        "fc-thick": shape.makeOffsetShape(distance, 1e-3, fill=True),
    }
    areas = {}
    for name, result in results.items():
        if result.isNull() or not result.isValid():
            raise SystemExit(f"{name} failed")
        part = document.addObject("Part::Feature", name.replace("-", "_"))
        part.Shape = result
        areas[name] = result.Area
        for end in ("step", "igs"):
            Import.export([part], os.path.join(folder, f"{name}.{end}"))
    json.dump(areas, ANSWER)
    ANSWER.write("\n")
    ANSWER.flush()


if __name__ == "__main__":
    main()
    sys.stderr.flush()
    os._exit(0)
