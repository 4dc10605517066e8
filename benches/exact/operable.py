"""Converts meshes of CAD parts, and tells of each exact solid whether Boolean operations accept it.

    target/occ/bin/python benches/exact/operable.py MESH.stl[.gz] ... [--ours PROGRAM] [--out FOLDER]

PROGRAM is a built scan2step, which runs on one thread. Each line has the part, the number of its faces, whether it
is valid without healing, and the faults that OpenCASCADE's analyzer of arguments finds with healing off and on: FreeCAD's
"Check geometry" uses it. The last line has the shares. A file is left alone if it does not become exact.
"""

import argparse
import gzip
import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tests/roundtrip"), str(ROOT / "benches/exact")]

from run import SECONDS, apart  # noqa: E402


def main():
    options = arguments()
    options.out.mkdir(parents=True, exist_ok=True)
    counts = dict.fromkeys(("exact", "valid", "accepted", "accepted when healed"), 0)
    print("part | faces | valid | faults | faults when healed")
    for mesh in options.meshes:
        name = mesh.name.split(".stl")[0]
        stl, step, report = (options.out / f"{name}.{end}" for end in ("stl", "step", "json"))
        stl.write_bytes(gzip.decompress(mesh.read_bytes()) if mesh.suffix == ".gz" else mesh.read_bytes())
        report.unlink(missing_ok=True)
        command = [options.ours, "convert", stl, step, "--report", report, "--threads", "1", "--quiet"]
        try:
            subprocess.run(command, capture_output=True, timeout=SECONDS)
        except subprocess.TimeoutExpired:
            print(f"{name} | no answer after {SECONDS} s", flush=True)
        told = json.loads(report.read_text()) if report.exists() else {}
        bodies = told.get("components") or [told]
        if not all("exact" in body for body in bodies):
            print(f"{name} | not exact", flush=True)
            continue
        found = apart(checked, str(step))
        said = lambda faults: "none" if faults == [] else str(faults)
        row = [found.get("faces", ""), found.get("valid", ""), said(found.get("raw")), said(found.get("healed"))]
        print(" | ".join(map(str, [name, *row, found.get("remark", "")])), flush=True)
        counts["exact"] += 1
        counts["valid"] += bool(found.get("valid"))
        counts["accepted"] += found.get("raw") == []
        counts["accepted when healed"] += found.get("healed") == []
    print(", ".join(f"{value} {key}" for key, value in counts.items()))


def checked(step):
    import check_occ as occ
    from OCP.BRepCheck import BRepCheck_Analyzer

    raw, healed = (occ.read(step, heal)[2] for heal in (False, True))
    faults = {name: sorted(set(occ.argument_faults(shape))) for name, shape in (("raw", raw), ("healed", healed))}
    return faults | {"faces": len(occ.faces_of(raw)), "valid": BRepCheck_Analyzer(raw).IsValid()}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("meshes", metavar="MESH", nargs="+", type=Path)
    parser.add_argument("--ours", type=Path, default=ROOT / "target/debug/scan2step")
    parser.add_argument("--out", type=Path, default=ROOT / "target/operable")
    return parser.parse_args()


if __name__ == "__main__":
    main()
