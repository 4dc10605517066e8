"""Fills the holes of the cases of cases.py with scan2step and measures the fills.

    python3 -m venv VENV
    VENV/bin/pip install numpy scipy
    cargo build --release
    VENV/bin/python benches/holes/evaluate.py target/release/scan2step [--only PATTERN]
        [--seed K] [--json FILE] [--pictures DIR] [--timed] [--shared DIR]

The script prints a Markdown table with a row for each case. --json has the same and
more for every hole. The mesh after the fill is measured. If a later stage fails, the
table has its exit code, and the message is below the table. For meshes of more than
200 MB, only the time is measured. The script needs Linux. CPU seconds are those of
all threads and hardly depend on other programs.

The columns are as follows. Lengths are in mm, and angles are in degrees.

holes, method   holes that were filled; the method in the report ('?': no report)
lost            measured triangles of the scan that the filled mesh does not have
exit            the exit code of the program; 'end' if this script ended it
rms, max        distance of added vertices to the true surface
area rms, max   the same for points that are spread evenly over the filled faces
folded          filled faces whose normal is opposite to the true one, or which have
                no area; in brackets the measured ones
cuts            filled faces that intersect another filled one / a measured one
edges           edges with more than two faces
fans            vertices with more than one fan of faces
loops           boundary loops: 1 is right; 'not the outer' if it is the wrong one
                (the program uses the longest one; --outer names the right one)
turned          edges whose two faces have opposite orientations
angles          least angle of filled triangles: percentiles 0, 1, 5, 50
edge/rim        length of edges inside the fill to that of the nearest rim's
                edge: percentiles 5, 50, 95
seam            angle across rims: median, 95th percentile; in brackets that of
                measured edges at the rim
fill s, CPU     wall-clock and CPU seconds of the fill stage; with --timed, and in
                the hundred-* cases, in a run without --stages (otherwise they
                include the writing of a mesh)
"""

import argparse
import json
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

import cases
import meshes
import run as runs
from intersections import cutting_pairs
from scans import virtual_scan
from surfaces import dot

SAMPLES_A_FACE = 4
SAMPLES = (3_000, 100_000)
MANY_BYTES = 200_000_000


def main():
    options = arguments()
    vs = virtual_scan(options.shared)
    results = []
    print(header(), flush=True)
    for name in cases.chosen(options.only):
        if name.startswith("hundred") and not options.hundred and options.only == "*":
            continue
        with tempfile.TemporaryDirectory(dir=options.work) as folder:
            result = measure(name, options, Path(folder), vs)
        results.append(result)
        print(row(result), flush=True)
        if options.json:
            options.json.write_text(json.dumps(results, indent=1))
    print_failures(results)
    print_summary(results)


def arguments():
    as_it_is = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=as_it_is)
    parser.add_argument("program", type=Path)
    parser.add_argument("--only", default="*", metavar="PATTERN", help="of names of cases")
    parser.add_argument("--hundred", action="store_true",
                        help="with the hundred-* cases, which take long; --only finds them, too")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path, metavar="FILE")
    parser.add_argument("--pictures", type=Path, metavar="DIR", help="two views of every hole")
    parser.add_argument("--most", type=int, default=12, help="holes of a case that are pictured")
    parser.add_argument("--timed", action="store_true", help="a run more, for the time alone")
    parser.add_argument("--until-fill", action="store_true", help="end the program after the fill")
    parser.add_argument("--outer", action="store_true",
                        help="tell scan2step which boundary is the outer one")
    parser.add_argument("--timeout", type=float, default=600.0, metavar="SECONDS")
    parser.add_argument("--arguments", default="", help="more for scan2step, in one word")
    parser.add_argument("--work", type=Path, help="where temporary files go")
    parser.add_argument("--shared", type=Path, help="the folder of virtual_scan.py")
    options = parser.parse_args()
    options.program = options.program.resolve()
    return options


def measure(name, options, folder, vs):
    case = cases.CASES[name](options.seed)
    scan = folder / f"{name}.ply"
    vs.write_ply(scan, case.points, case.triangles)
    extra = [*case.arguments, *options.arguments.split()]
    if options.outer:
        extra += ["--outer", ",".join(map(str, case.outer))]
    run = runs.convert(options.program, scan, folder / "run", extra, options.timeout,
                       options.until_fill or case.timing)
    result = {"case": name, "exit": run.code, "ended": run.ended, "seconds": run.seconds,
              "cpu_s": run.cpu_s, "message": message(run), "triangles": len(case.triangles)}
    if options.timed or case.timing:
        alone = runs.convert(options.program, scan, folder / "alone", extra, options.timeout,
                             until_fill=True, stages=False)
        result |= {"seconds": alone.seconds, "cpu_s": alone.cpu_s}
    result["report"] = report(folder / "run" / "report.json")
    if run.filled and run.filled.stat().st_size < MANY_BYTES:
        mesh = meshes.read_filled(run.filled)
        result |= judge(mesh, case)
        if options.pictures:
            from pictures import draw
            draw(mesh, result, options.pictures / name, options.most)
    return result


def message(run):
    """The last message of the program, unless the run succeeded."""
    said = [line for line in run.stderr if not runs.STAGE.match(line)]
    errors = [line for line in said if line.startswith(("error", "thread", "tolerance not"))]
    if run.code == 0:
        return ""
    return run.ended and f"ended {run.ended}" or (errors or said or [""])[-1]


def report(file):
    """The report's figures of the holes and of the input."""
    if not file.exists():
        return None
    whole = json.loads(file.read_text())
    return {"holes": whole.get("fill", {}).get("holes", []), "input": whole.get("input", {})}


def judge(mesh, case):
    """All figures of a filled mesh."""
    faces = looked_at(mesh, case.truth)
    samples = sampled(mesh, case.truth)
    added = np.flatnonzero(mesh.added)
    vertices = case.truth.foot(mesh.points[added])[0] if len(added) else np.empty(0)
    cuts = cutting(mesh)
    edges = at_edges(mesh)
    owner = vertex_hole(mesh)[added]
    number = mesh.hole[mesh.fill]
    holes = []
    for hole in np.unique(number):
        mine = lambda of: np.asarray(of) == hole
        rim = int(mine(edges["hole"]["seam"]).sum())
        holes.append({"hole": int(hole), "rim_edges": rim} | figures(
            vertices[mine(owner)], samples[1][mine(number[samples[0]])],
            faces["folded"][mine(number)], faces["angles"][mine(number)],
            {k: v[mine(number)] for k, v in cuts.items()},
            {k: v[mine(edges["hole"][k])] for k, v in edges["values"].items()}))
    whole = figures(vertices, samples[1], faces["folded"], faces["angles"], cuts, edges["values"])
    return whole | meshes.topology(mesh) | {
        "holes": holes,
        "lost": len(case.triangles) - len(mesh.measured),
        "folded_measured": faces["folded_measured"],
        "outer_is_open": meshes.is_boundary(mesh, case.outer),
        "islands": len(set(meshes.components(mesh, mesh.measured))) - 1,
        "unused_vertices": int(len(mesh.points) - len(np.unique(mesh.triangles))),
    }


def figures(vertices, samples, folded, angles, cuts, edges):
    """The figures of one hole or of all holes."""
    rms = lambda x: float(np.sqrt(np.mean(np.square(x)))) if len(x) else None
    most = lambda x: float(np.max(x)) if len(x) else None
    return {
        "added_vertices": len(vertices),
        "added_triangles": len(folded),
        "rms_mm": rms(vertices), "max_mm": most(vertices),
        "area_rms_mm": rms(samples), "area_max_mm": most(samples),
        "folded": int(folded.sum()),
        "cuts_fill": int(cuts["fill"].sum()), "cuts_measured": int(cuts["measured"].sum()),
        "min_angle": percentiles(angles, [0, 1, 5, 50]),
        "edge_to_rim": percentiles(edges["to_rim"], [5, 50, 95]),
        "seam": percentiles(edges["seam"], [50, 95]),
        "beside": percentiles(edges["beside"], [50, 95]),
        "inside": percentiles(edges["inside"], [50, 95]),
    }


def percentiles(values, which):
    return [float(x) for x in np.percentile(values, which)] if len(values) else []


def looked_at(mesh, truth):
    """The side of the true surface that the faces face. The whole mesh may be
    inverted, which the measured faces show."""
    normal = truth.foot(mesh.centroids)[1]
    side = dot(mesh.normals, normal)
    if np.median(side[mesh.measured]) < 0:
        side = -side
    folded = ~(side > 0)
    return {"folded": folded[mesh.fill], "folded_measured": int(folded[mesh.measured].sum()),
            "angles": meshes.min_angles(mesh, mesh.fill)}


def sampled(mesh, truth):
    """Points that are spread over the fill by area: the number of the filled face
    and the distance from the true surface for each."""
    if len(mesh.fill) == 0 or mesh.areas[mesh.fill].sum() == 0:
        return np.empty(0, int), np.empty(0)
    random = np.random.default_rng(0)
    share = mesh.areas[mesh.fill] / mesh.areas[mesh.fill].sum()
    count = np.clip(SAMPLES_A_FACE * len(mesh.fill), *SAMPLES)
    face = np.repeat(np.arange(len(share)), random.multinomial(count, share))
    weights = random.dirichlet([1, 1, 1], len(face))
    corners = mesh.points[mesh.triangles[mesh.fill[face]]]
    return face, truth.foot(np.einsum("ij,ijk->ik", weights, corners))[0]


def cutting(mesh):
    """The filled faces that intersect filled faces, and those that intersect measured faces."""
    cuts = {kind: np.zeros(len(mesh.fill), bool) for kind in ("fill", "measured")}
    place = np.full(len(mesh.triangles), -1)
    place[mesh.fill] = np.arange(len(mesh.fill))
    for hole in np.unique(mesh.hole[mesh.fill]):
        fill = np.flatnonzero(mesh.hole == hole)
        a, b = place[cutting_pairs(mesh.points, mesh.triangles, fill)].T
        cuts["fill"][np.concatenate([a[b >= 0], b[b >= 0]])] = True
        cuts["measured"][a[b < 0]] = True
    return cuts


def at_edges(mesh):
    """Figures of edges, and the hole that each edge belongs to."""
    from scipy.spatial import cKDTree

    kind, faces = meshes.kinds(mesh), mesh.edges.faces
    inside, seam = np.flatnonzero(kind == 2), np.flatnonzero(kind == 1)
    at_rim = np.zeros(len(mesh.points), bool)
    at_rim[mesh.edges.ends[seam]] = True
    beside = np.flatnonzero((kind == 0) & at_rim[mesh.edges.ends].any(1))
    values = {"seam": meshes.bends(mesh, seam), "inside": meshes.bends(mesh, inside),
              "beside": meshes.bends(mesh, beside), "to_rim": np.empty(0)}
    of_seam = mesh.hole[faces[seam]].max(1)
    vertex = np.full(len(mesh.points), -1)
    vertex[mesh.edges.ends[seam]] = of_seam[:, None]
    hole = {"seam": of_seam, "inside": mesh.hole[faces[inside, 0]],
            "beside": vertex[mesh.edges.ends[beside]].max(1), "to_rim": np.empty(0, int)}
    if len(seam) and len(inside):
        middles = lambda which: mesh.points[mesh.edges.ends[which]].mean(1)
        _, nearest = cKDTree(middles(seam)).query(middles(inside))
        values["to_rim"] = meshes.lengths(mesh, inside) / meshes.lengths(mesh, seam)[nearest]
        hole["to_rim"] = hole["inside"]
    return {"values": values, "hole": hole}


def vertex_hole(mesh):
    hole = np.full(len(mesh.points), -1)
    hole[mesh.triangles[mesh.fill].ravel()] = np.repeat(mesh.hole[mesh.fill], 3)
    return hole


COLUMNS = ["case", "holes", "method", "lost", "exit", "rms", "max", "area rms", "area max",
           "folded", "cuts", "edges", "fans", "loops", "turned", "angles", "edge/rim",
           "seam", "fill s", "CPU"]


def header():
    return "| " + " | ".join(COLUMNS) + " |\n|" + " --- |" * len(COLUMNS)


def row(r):
    stage = lambda of: number(r[of].get("fill"), 2)
    code = "end" if r["exit"] is None else str(r["exit"])
    if "holes" not in r:
        cells = [r["case"], "not judged", "", "", code] + [""] * 13 + [stage("seconds"), stage("cpu_s")]
        return "| " + " | ".join(cells) + " |"
    seam, beside = (" ".join(number(x, 1) for x in r[of]) for of in ("seam", "beside"))
    cells = [
        r["case"], str(len(r["holes"])), methods(r), str(r["lost"]), code,
        number(r["rms_mm"], 4), number(r["max_mm"], 3),
        number(r["area_rms_mm"], 4), number(r["area_max_mm"], 3),
        f"{r['folded']} ({r['folded_measured']})", f"{r['cuts_fill']} / {r['cuts_measured']}",
        str(r["nonmanifold_edges"]), str(r["more_fans"]),
        str(r["loops"]) + ("" if r["outer_is_open"] else ", not the outer"),
        str(r["disagreeing_edges"]),
        " ".join(number(x, 0 if k else 1) for k, x in enumerate(r["min_angle"])),
        " ".join(number(x, 2) for x in r["edge_to_rim"]), f"{seam} ({beside})",
        stage("seconds"), stage("cpu_s"),
    ]
    return "| " + " | ".join(cells) + " |"


def methods(r):
    if not r["report"]:
        return "?"
    count = Counter(hole.get("method", "?") for hole in r["report"]["holes"])
    return ", ".join(f"{n} {method}" if n > 1 else method for method, n in count.most_common())


def number(x, digits):
    return "" if x is None else f"{x:.{digits}f}"


def print_failures(results):
    failed = [r for r in results if r["message"] and not r["ended"] == "after the fill"]
    if failed:
        print("\nWhat went wrong later:\n")
    for r in failed:
        print(f"- {r['case']}: {r['message']}")


def faults(r):
    """The kinds of faults of a filled mesh."""
    if "holes" not in r:
        return ["not judged"]
    wrong = {
        "folded": r["folded"], "cuts": r["cuts_fill"] + r["cuts_measured"],
        "edges": r["nonmanifold_edges"], "fans": r["more_fans"], "loops": r["loops"] != 1,
        "wrong outer": not r["outer_is_open"], "turned": r["disagreeing_edges"],
        "euler": r["euler"] != 1, "unused vertices": r["unused_vertices"],
    }
    return [kind for kind, count in wrong.items() if count]


def print_summary(results):
    count = Counter(fault for r in results for fault in faults(r))
    clean = sum(not faults(r) for r in results)
    told = ", ".join(f"{kind} {n}" for kind, n in count.most_common())
    print(f"\n{clean} of {len(results)} cases without a fault. Cases with: {told or 'none'}.")


if __name__ == "__main__":
    main()
