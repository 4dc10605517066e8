"""Measures the regions found in scans against the true faces.

  python measure.py CACHE RESULTS [name ...] [-v]

CACHE holds NAME.npz of truth.py, RESULTS holds NAME.json of the example `scanned_regions`. A true face is right if a region of its
kind has more than half of the vertices that either has; a cone of at most 1 degree may be a cylinder. Wide faces are at least four
edges of the scan wide, thin ones two to four, and both have at least 12 vertices. A region of at least 50 vertices is extra if it
overlaps no true analytic face so well. `z` is how far radii of right cylinders are off, in their own standard deviations.
"""

import json
import pathlib
import sys

import numpy as np

ELEMENTARY = ["plane", "cylinder", "cone", "sphere", "torus"]
FEWEST, EXTRA, OVERLAP, DRAFT = 12, 50, 0.5, 1.0


def labels_of(result, count):
    """The region of each vertex: that of most of its triangles."""
    label = np.full(count, -1)
    for number, region in enumerate(result["regions"]):
        label[region["vertices"]] = number
    return label


def measured(truth, result, verbose):
    scan = json.loads(str(truth["scan"]))
    faces = json.loads(str(truth["parameters"]))
    kind, width, group = truth["kind"], truth["width"] / scan["edge"], truth["group"]
    if "points" in result:
        from scipy.spatial import cKDTree

        group = group[cKDTree(truth["points"]).query(np.array(result["points"]) * result["mm"])[1]]
    label = labels_of(result, len(group))
    regions = result["regions"]
    table = np.zeros((len(kind), len(regions) + 1), int)
    np.add.at(table, (group, label), 1)
    size, found = table.sum(1), table[:, :-1].sum(0)
    overlap = table[:, :-1] / np.maximum(size[:, None] + found[None] - table[:, :-1], 1)
    names = np.array([r["kind"] for r in regions])
    is_analytic = np.isin(kind, ELEMENTARY)
    draft = np.array([k == "cone" and f.get("angle", 90) <= DRAFT for k, f in zip(kind, faces)])
    same = (kind[:, None] == names[None]) | (draft[:, None] & (names == "cylinder")[None])
    good = (overlap > OVERLAP) & same
    enough = is_analytic & (size >= FEWEST)
    wide, thin = enough & (width >= 4), enough & (width >= 2) & (width < 4)
    right = good.any(1) if len(regions) else np.zeros(len(kind), bool)
    extra = (found >= EXTRA) & ~((overlap > OVERLAP) & is_analytic[:, None]).any(0)
    z = []
    for g, r in zip(*np.nonzero(good)):
        if kind[g] == "cylinder" and names[r] == "cylinder" and wide[g]:
            region, face = regions[r], faces[g]
            variance = region["variances"][4]
            axis, turn = np.array(region["axis"]), np.array(face["dir"])
            angle = np.linalg.norm(np.cross(axis, turn))
            turned = np.sqrt(sum(region["variances"][:2]))
            z.append(((region["size"]["radius"] - face["r"]) / np.sqrt(variance), angle / turned))
    free = np.bincount(group[label < 0], minlength=len(kind))
    out = {
        "wide": [int((right & wide).sum()), int(wide.sum())],
        "thin": [int((right & thin).sum()), int(thin.sum())],
        "extra": int(extra.sum()),
        "faces": len(kind),
        "free": [float((label < 0).mean()), float(np.isin(group, np.nonzero(~is_analytic)[0]).mean())],
        "sigma": result["deviation"] / scan["sigma"],
        "rho": result["correlation"],
        "cpu": result["seconds"][1],
        "z": z,
        "vertices": len(group),
    }
    if verbose:
        for g in np.nonzero((wide | thin) & ~right)[0]:
            order = np.argsort(-table[g, :-1])[:3]
            best = [(int(r), str(names[r]), int(table[g, r]), int(found[r]), round(float(overlap[g, r]), 2)) for r in order if table[g, r]]
            print(f"   {'wide' if wide[g] else 'thin'} missed: face {g} {kind[g]} width {width[g]:.1f} n {size[g]} free {free[g]}: {best}", {k: v for k, v in faces[g].items() if k in ("r", "R", "angle")})
        for r in np.nonzero(extra)[0]:
            order = np.argsort(-table[:, r])[:4]
            print(f"   extra {r} {names[r]} n {found[r]} {regions[r]['size']}:", [(int(g), str(kind[g]), int(table[g, r]), int(size[g]), round(float(width[g]), 1)) for g in order if table[g, r]])
    return out


def main():
    arguments = [a for a in sys.argv[1:] if a != "-v"]
    cache, results = map(pathlib.Path, arguments[:2])
    names = arguments[2:] or sorted(p.stem for p in results.glob("*.json") if (cache / f"{p.stem}.npz").exists())
    total = {"wide": [0, 0], "thin": [0, 0], "extra": 0, "faces": 0}
    z, cpu = [], []
    for name in names:
        truth = np.load(cache / f"{name}.npz")
        got = measured(truth, json.loads((results / f"{name}.json").read_text()), "-v" in sys.argv)
        for key in ("wide", "thin"):
            total[key] = [a + b for a, b in zip(total[key], got[key])]
        total["extra"] += got["extra"]
        total["faces"] += got["faces"]
        z += got["z"]
        cpu.append(got["cpu"] * 50_000 / got["vertices"])
        free = "/".join(f"{100 * x:.0f}%" for x in got["free"])
        ratio = lambda key: "{}/{}".format(*got[key])
        print(f"{name:24} wide {ratio('wide'):8} thin {ratio('thin'):8} extra {got['extra']:3} free {free:9} sigma {got['sigma']:.2f} rho {got['rho'][0]:.2f} cpu {got['cpu']:.1f}", flush=True)
    share = lambda key: "{}/{} = {:.1f}%".format(*total[key], 100 * total[key][0] / max(total[key][1], 1))
    print(f"{len(names)} parts: wide {share('wide')}, thin {share('thin')}, extra {total['extra']} = {100 * total['extra'] / max(total['faces'], 1):.1f}% of {total['faces']} faces, cpu/50k median {np.median(cpu):.1f} most {max(cpu):.1f}")
    if z:
        z = np.abs(np.array(z))
        print(f"{len(z)} cylinders: |z| radius median {np.median(z[:, 0]):.2f} <3 {100 * (z[:, 0] < 3).mean():.1f}%, axis median {np.median(z[:, 1]):.2f} <3 {100 * (z[:, 1] < 3).mean():.1f}%")


if __name__ == "__main__":
    main()
