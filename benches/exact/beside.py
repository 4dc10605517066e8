"""Compares exact solids with FreeCAD's way from a mesh to a solid, and prints a Markdown table.

    target/occ/bin/python benches/exact/beside.py PARTS [--ours PROGRAM] [--out FOLDER] [--parts NAME ...]

PARTS is a folder with truth/NAME.json and stl/NAME.coarse.stl.gz. PROGRAM is a built scan2step, which runs
on one thread. FreeCAD makes a shape from the mesh, sews it, makes a solid of it and refines it, which joins
neighbours on one plane.

The columns: faces, after the true number; whether OpenCASCADE finds the file valid without healing, and with it; the
relative error of the volume; CPU seconds of the whole process; the size of the STEP file.
"""

import argparse
import gzip
import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.dont_write_bytecode = True
sys.path[:0] = [str(HERE), str(ROOT / "tests/roundtrip")]

from run import apart  # noqa: E402

COLUMNS = ["part", "triangles", "program", "faces", "valid", "volume off by", "CPU s", "STEP kB"]

# Parts of all kinds, from 9 to 90 faces.
PARTS = ["occt_screw", "pp_barrel_flange", "iso7040_nut", "mini_steel_sheet", "u2_knob_housing", "so_handle"]
PARTS += ["oat_dec_motor", "so_camera_mount", "bq_corner_sheet", "pp_13_teeth_blade", "u2_head_bottom", "u3_pulley"]

# Programs are stopped after so many seconds.
PATIENCE = 600

FREECAD = """
import Mesh, Part
shape = Part.Shape()
shape.makeShapeFromMesh(Mesh.Mesh({stl!r}).Topology, 0.0)
shape.sewShape()
solid = Part.Solid(Part.Shell(shape.Faces))
solid.removeSplitter().exportStep({step!r})
"""


def main():
    options = arguments()
    options.out.mkdir(parents=True, exist_ok=True)
    print("| " + " | ".join(COLUMNS) + " |\n|" + " --- |" * len(COLUMNS), flush=True)
    for name in options.parts:
        truth = json.loads((options.folder / "truth" / f"{name}.json").read_text())
        stl = options.out / f"{name}.stl"
        stl.write_bytes(gzip.decompress((options.folder / "stl" / f"{name}.coarse.stl.gz").read_bytes()))
        triangles = (stl.stat().st_size - 84) // 50
        for program, work in (("scan2step", ours), ("FreeCAD", freecad)):
            step = options.out / f"{name}.{program}.step"
            step.unlink(missing_ok=True)
            seconds = cpu(lambda: work(options, stl, step))
            cells = [name, triangles, program, *judged(step, truth), f"{seconds:.1f}"]
            cells.append(f"{step.stat().st_size / 1e3:.0f}" if step.exists() else "")
            print("| " + " | ".join(map(str, cells)) + " |", flush=True)


def judged(step, truth):
    """The cells on faces, validity and volume."""
    if not step.exists():
        return ["none", "", ""]
    found = apart(measured, str(step))
    if "faces" not in found:
        return [found["remark"], "", ""]
    off = found["volume"] / truth["volume"] - 1
    faces = f"{found['faces']} of {truth['faces']}" + (", B-splines" if found["splines"] else "")
    return [faces, found["valid"], f"{off:.0e}"]


def measured(step):
    import check_occ as occ
    from check_solid_occ import surfaces_of, volume_of
    from OCP.BRepCheck import BRepCheck_Analyzer

    raw = occ.read(step, heal=False)[2]
    is_valid = lambda shape: BRepCheck_Analyzer(shape).IsValid()
    valid = "yes" if is_valid(raw) else "healed" if is_valid(occ.read(step, heal=True)[2]) else "no"
    splines = surfaces_of(raw).count("BSplineSurface")
    return {"faces": len(occ.faces_of(raw)), "splines": splines, "valid": valid, "volume": volume_of(raw)}


def ours(options, stl, step):
    command = [options.ours, "convert", stl, step, "--quiet", "--threads", "1"]
    run(command)


def freecad(_options, stl, step):
    with tempfile.NamedTemporaryFile("w", suffix=".py") as file:
        file.write(FREECAD.format(stl=str(stl), step=str(step)))
        file.flush()
        run(["freecadcmd", file.name])


def run(command):
    try:
        subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        print(f"{command[0]}: stopped after {PATIENCE} s", file=sys.stderr)


def cpu(work):
    """The CPU seconds of the processes that a call starts."""
    times = lambda: sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
    before = times()
    work()
    return times() - before


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", metavar="PARTS", type=Path)
    parser.add_argument("--ours", type=Path, default=ROOT / "target/debug/scan2step")
    parser.add_argument("--out", type=Path, default=ROOT / "target/beside")
    parser.add_argument("--parts", nargs="+", default=PARTS)
    return parser.parse_args()


if __name__ == "__main__":
    main()
