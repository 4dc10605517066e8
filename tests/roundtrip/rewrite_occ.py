#!/usr/bin/env python3
"""Reads a STEP or IGES file with OpenCASCADE and writes it again.

    python rewrite_occ.py FILE FOLDER

Writes FOLDER/occ.step, occ-inch.step, occ144.igs, occ514.igs, and
occ-plain.step, which has no pcurves. Needs cadquery-ocp-novtk 7.9.
"""

import os
import sys

from OCP.IFSelect import IFSelect_RetDone
from OCP.IGESControl import IGESControl_Reader, IGESControl_Writer
from OCP.Interface import Interface_Static
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Reader, STEPControl_Writer


def check(status, what):
    if status != IFSelect_RetDone:
        raise SystemExit(f"{what}: {status}")


def read(path):
    step = path.lower().endswith((".step", ".stp"))
    reader = STEPControl_Reader() if step else IGESControl_Reader()
    check(reader.ReadFile(path), path)
    reader.TransferRoots()
    return reader.OneShape()


def write_step(shape, path, unit="MM", pcurves=1):
    writer = STEPControl_Writer()
    Interface_Static.SetCVal_s("write.step.unit", unit)
    Interface_Static.SetIVal_s("write.surfacecurve.mode", pcurves)
    check(writer.Transfer(shape, STEPControl_AsIs), path)
    check(writer.Write(path), path)


def write_iges(shape, path, brep):
    writer = IGESControl_Writer("MM", brep)
    if not writer.AddShape(shape):
        raise SystemExit(f"{path}: refused")
    writer.ComputeModel()
    if not writer.Write(path):
        raise SystemExit(f"{path}: cannot be written")


def main():
    source, folder = sys.argv[1:]
    shape = read(source)
    place = lambda name: os.path.join(folder, name)
    write_step(shape, place("occ.step"))
    write_step(shape, place("occ-inch.step"), unit="INCH")
    write_iges(shape, place("occ144.igs"), 0)
    write_iges(shape, place("occ514.igs"), 1)
    write_step(shape, place("occ-plain.step"), pcurves=0)


if __name__ == "__main__":
    main()
    # Some of OpenCASCADE's destructors crash at exit, after the work.
    sys.stderr.flush()
    os._exit(0)
