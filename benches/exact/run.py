"""Makes exact solids of CAD parts' meshes, judges them against the parts, and prints a table.

    target/occ/bin/python benches/exact/run.py PARTS [--only NAME ...] [--ours PROGRAM] [--out FOLDER] [--shape] [--kind MESH]

PARTS is a folder with judge.py, truth/NAME.json and stl/NAME.MESH.stl.gz, where MESH is `coarse` or `fine`.
PROGRAM is a built examples/exact. With --shape, the distances between the surfaces are measured too, which
takes longer.

The columns: valid (with healing off, then with it), same (the same faces by kind as the part), faces and extra
faces, the relative error of the volume, facets among the faces, faces that fell back to facets, the seconds of
PROGRAM, and what else is to be said.
"""

import argparse
import gzip
import json
import math
import multiprocessing
import os
import subprocess
import sys
import time
from pathlib import Path

SECONDS = 300


def main():
    options = arguments()
    sys.path.insert(0, str(options.parts.resolve()))
    sys.dont_write_bytecode = True
    import judge

    options.out.mkdir(parents=True, exist_ok=True)
    sums = dict.fromkeys(("parts", "valid", "same"), 0)
    print("part | valid | healed | same | faces | extra | volume | facets | fell back | s | remarks")
    for truth in sorted((options.parts / "truth").glob("*.json")):
        name = truth.stem
        mesh = options.parts / "stl" / f"{name}.{options.kind}.stl.gz"
        record = json.loads(truth.read_text())
        if not mesh.exists() or (options.only and name not in options.only):
            continue
        if not record["meshes"][options.kind].get("closed", True):
            continue
        row = run(judge, options, name, mesh, truth, record)
        sums["parts"] += 1
        sums["valid"] += row[1] == "1"
        sums["same"] += row[3] == "1"
        print(" | ".join(row), flush=True)
    print(", ".join(f"{value} {key}" for key, value in sums.items()))


def run(judge, options, name, mesh, truth, record):
    stl, out = options.out / f"{name}.stl", options.out / f"{name}.step"
    stl.write_bytes(gzip.decompress(mesh.read_bytes()))
    out.unlink(missing_ok=True)
    start = time.monotonic()
    try:
        done = subprocess.run([options.ours, stl, out], capture_output=True, text=True, timeout=SECONDS)
        said, failed = done.stdout, done.stderr.strip().replace("\n", " ") if done.returncode else ""
    except subprocess.TimeoutExpired:
        said, failed = "", f"no answer after {SECONDS} s"
    took = f"{time.monotonic() - start:.1f}"
    if failed or not said:
        return [name, "0", "0", "0", "", "", "", "", "", took, failed[:200]]
    made = json.loads(said.splitlines()[-1])
    (options.out / f"{name}.json").write_text(json.dumps(made, indent=1))
    found = apart(measure, judge, str(out), str(truth), record, options.shape)
    why = {}
    for fallback in made["fallbacks"]:
        reason = "".join("#" if c.isdigit() else c for c in fallback["why"])
        why[reason] = why.get(reason, 0) + 1
    remarks = "; ".join([f"{count} {reason}" for reason, count in sorted(why.items(), key=lambda w: -w[1])][:3])
    remarks = "; ".join(part for part in (found.get("remark", ""), remarks) if part)
    fields = [found.get(key, "?") for key in ("valid", "healed", "same", "faces", "extra", "volume")]
    return [name, *fields, str(made["facets"]), str(len(made["fallbacks"])), took, remarks]


def measure(judge, out, truth, record, shape):
    """Properties of a file in OpenCASCADE as texts."""
    raw = judge.read(out, False)
    if raw is None or not len(judge.smap(raw, judge.TopAbs_FACE)):
        return {"valid": "0", "remark": "OpenCASCADE reads nothing"}
    valid = judge.BRepCheck_Analyzer(raw).IsValid()
    healed = raw if valid else judge.read(out)
    part = judge.Part(healed)
    found, true = part.kinds(), record["kinds"]
    kinds = [kind for kind in judge.KINDS if found.get(kind, 0) != true.get(kind, 0)]
    extra = sum(max(0, found.get(kind, 0) - true.get(kind, 0)) for kind in judge.KINDS)
    error = part.volume / record["volume"] - 1 if part.volume else math.nan
    answer = {
        "valid": str(int(valid)),
        "healed": str(int(valid or judge.BRepCheck_Analyzer(healed).IsValid())),
        "same": str(int(not kinds)),
        "faces": f"{part.ng}/{record['faces']}",
        "extra": str(extra),
        "volume": f"{error:.0e}",
        "remark": " ".join(f"{kind} {found.get(kind, 0)}/{true.get(kind, 0)}" for kind in kinds),
    }
    if shape:
        found = judge.judge(out, truth, n=3000)
        answer["extra"] = str(found["extra"])
        answer["remark"] += f" right {found['right']}, off {found['r2t_max']:.0e} mm"
    return answer


def apart(work, *given):
    """The result of a function in its own process, which may crash or hang."""
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe(duplex=False)

    def call():
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        try:
            theirs.send(work(*given))
        except Exception as fault:  # the table says it
            theirs.send({"remark": f"{type(fault).__name__}: {fault}"})

    process = context.Process(target=call)
    process.start()
    theirs.close()
    found = {"remark": "OpenCASCADE crashed or hung"}
    try:
        if ours.poll(SECONDS):
            found = ours.recv()
    except EOFError:
        pass
    process.kill()
    process.join()
    return found


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("parts", type=Path)
    parser.add_argument("--only", nargs="+", default=[])
    parser.add_argument("--ours", type=Path, default=Path("target/debug/examples/exact"))
    parser.add_argument("--out", type=Path, default=Path("target/exact"))
    parser.add_argument("--shape", action="store_true")
    parser.add_argument("--kind", default="coarse")
    return parser.parse_args()


if __name__ == "__main__":
    main()
