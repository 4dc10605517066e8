"""Makes random parts, converts their meshes to exact solids, and prints a table.

    target/occ/bin/python benches/exact/csg.py SEEDS ... [--ours PROGRAM] [--out FOLDER] [--arguments] [--stop]

SEEDS are numbers, or ranges as 0-299. PROGRAM is a built scan2step, which runs on one thread. tests/roundtrip/random_parts.py makes the parts. FOLDER keeps
what it made of each seed: SEED.stl, SEED.json (the truth), SEED.step and SEED.report.json. Parts that are there
already are not made again.

The columns: operations, triangles, valid (without healing), same (the same faces by kind as the part, and all of the
area is on surfaces that were found), the relative error of the volume, that of the mesh, patches that fell back to
facets, the share of the area that is facets, seconds of PROGRAM, verdict and remarks. With --arguments, the check
of the arguments of Boolean operations runs too. With --stop, conversions that turn to B-spline faces are stopped,
which saves most of the time; then the table does not have the reason.

Verdicts: `right` is the part itself, its volume right within 1e-6. `near` has the same volume, but other faces or small
facets. `partial` is a valid solid with facets, whose volume is off by no more than that of the mesh may be. `splines`
is no exact solid.
`wrong volume`, `invalid`, `crash` and `slow` are failures.
"""

import argparse
import json
import subprocess
import sys
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/roundtrip"), str(ROOT / "benches/exact")]
sys.dont_write_bytecode = True

from run import apart  # noqa: E402

SECONDS = 120

# What the program says before it makes B-spline faces.
SCANS = "shape: a solid, as"

# The volume of a part whose faces are all right is right within this share.
EXACT = 1e-6


def main():
    options = arguments()
    options.out.mkdir(parents=True, exist_ok=True)
    counts = {}
    columns = "seed operations triangles valid same volume mesh fallbacks facets_pct s verdict remarks"
    print(" | ".join(columns.split()))
    for seed in (seed for some in options.seeds for seed in some):
        row = run(options, seed)
        for key in (row["verdict"], *row["counts"]):
            counts[key] = counts.get(key, 0) + 1
        print(" | ".join(str(row.get(column, "")) for column in columns.split()), flush=True)
    print(", ".join(f"{value} {key}" for key, value in sorted(counts.items(), key=lambda c: -c[1])))


def run(options, seed):
    file = lambda end: options.out / f"{seed}.{end}"
    if not file("stl").exists():
        said = apart(made, str(options.out), seed)
        if not file("stl").exists():
            return {"seed": seed, "verdict": "no part", "remarks": said.get("remark", ""), "counts": []}
    truth = json.loads(file("json").read_text())
    row = {"seed": seed, "operations": truth["operations"], "triangles": truth["triangles"], "counts": []}
    row["mesh"] = f"{truth['volume_of_mesh'] / truth['volume'] - 1:.0e}"
    for end in ("step", "report.json"):
        file(end).unlink(missing_ok=True)
    start = time.monotonic()
    files = [file("stl"), file("step"), "--report", file("report.json")]
    said, status = converted([options.ours, "convert", *files, "--threads", "1"], options.stop)
    row["s"] = f"{time.monotonic() - start:.1f}"
    if status == "slow":
        return row | {"verdict": "slow", "remarks": f"no answer after {SECONDS} s"}
    if status == "stopped":
        return row | {"verdict": "splines"}
    if status:
        why = " ".join(line for line in said if "panicked" in line or "error" in line)
        return row | {"verdict": "crash", "remarks": f"{status}: {why}"}
    report = json.loads(file("report.json").read_text())
    bodies = report.get("components") or [report]
    if not all("exact" in body for body in bodies):
        why = {str(body["shape"]["fallback"]) for body in bodies if "exact" not in body} - {"None"}
        reason = [line for line in said if line.startswith("hint") and "exact" in line]
        return row | {"verdict": "splines", "remarks": "; ".join([*sorted(why), *reason])}
    found = apart(measured, str(file("step")), options.arguments)
    return row | judged(truth, bodies, found)


def converted(command, stops):
    """What the program says, and its status: a number, or how it was stopped."""
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    is_late = threading.Event()

    def late():
        is_late.set()
        process.kill()

    timer = threading.Timer(SECONDS, late)
    timer.start()
    said = []
    for line in process.stderr:
        said.append(line.rstrip())
        # The way of scans begins.
        if stops and line.startswith(SCANS):
            process.kill()
            process.wait()
            timer.cancel()
            return said, "stopped"
    process.wait()
    timer.cancel()
    return said, "slow" if is_late.is_set() else process.returncode


def judged(truth, bodies, found):
    """What to say of an exact solid."""
    fallbacks = [facets for body in bodies for facets in body["exact"]["facets"]]
    area = sum(body["shape"]["area_mm2"] for body in bodies)
    explained = sum(body["shape"]["area_mm2"] * body["exact"]["explained_pct"] for body in bodies) / area
    row = {"fallbacks": len(fallbacks), "facets_pct": f"{100 - explained:.2g}", "counts": []}
    if "volume" not in found:
        return row | {"verdict": "invalid", "remarks": found.get("remark", str(found))}
    same = found["kinds"] == truth["kinds"] and not fallbacks and explained > 100 - 1e-9
    off = found["volume"] - truth["volume"]
    row |= {"valid": int(found["valid"]), "same": int(same), "volume": f"{off / truth['volume']:.0e}"}
    allowed = EXACT * truth["volume"] if same else truth["guard"] + truth["rounding"]
    verdict = "right" if same else "near" if abs(off) <= EXACT * truth["volume"] else "partial"
    if abs(off) > allowed:
        verdict = "wrong volume"
    if not found["valid"]:
        verdict = "invalid"
    if found.get("argument_faults"):
        row["counts"].append("with faulty arguments")
    kinds = sorted(set(found["kinds"]) | set(truth["kinds"]))
    other = [(k, found["kinds"].get(k, 0), truth["kinds"].get(k, 0)) for k in kinds]
    remarks = [f"{kind} {ours}/{true}" for kind, ours, true in other if ours != true]
    why = {}
    for facets in fallbacks:
        reason = "".join("#" if c.isdigit() else c for c in f"{facets['surface']}: {facets['why']}")
        why[reason] = why.get(reason, 0) + 1
    remarks += [f"{count} {reason}" for reason, count in sorted(why.items(), key=lambda w: -w[1])]
    if found.get("argument_faults"):
        remarks.append(f"faults {found['argument_faults']}")
    if truth["off_steps"] > 1.0:
        remarks.append(f"vertices off by {truth['off_steps']:.1f} steps")
    return row | {"verdict": verdict, "remarks": "; ".join(remarks)}


def made(folder, seed):
    import random_parts

    random_parts.make(folder, seed)
    return {}


def measured(path, arguments):
    import check_occ
    import random_parts

    found = random_parts.check(path)
    if arguments:
        found["argument_faults"] = check_occ.argument_faults(check_occ.read(path, heal=False)[2])
    return found


def numbers(text):
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("seeds", metavar="SEEDS", nargs="+", type=numbers)
    parser.add_argument("--ours", type=Path, default=ROOT / "target/debug/scan2step")
    parser.add_argument("--out", type=Path, default=ROOT / "target/random_parts")
    parser.add_argument("--arguments", action="store_true")
    parser.add_argument("--stop", action="store_true")
    return parser.parse_args()


if __name__ == "__main__":
    main()
