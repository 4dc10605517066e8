"""Measures the regions that the stage finds in CAD exports against the true faces of the parts.

  python measure.py PARTS --regions PROGRAM [--set coarse|fine|export] [--variants exact,dec3] [--only part,part] [-v]
  python measure.py PARTS --regions PROGRAM --set stl_only
  python measure.py SCANS --regions PROGRAM --set scans --only name,name

PARTS holds truth/NAME.json and stl/NAME.SET.stl.gz, PROGRAM is the built example `regions`. A true face is found if a region of
its kind has its parameters and its area; a region that is no true face's is extra. Parts are analytic if all their faces are.
"""

import argparse
import gzip
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

import variants

KINDS = ["plane", "cylinder", "cone", "sphere", "torus"]
# A region has the area of a face if neither is larger by this factor: facets of coarse meshes are chords.
AREA_RATIO = 1.3
# Places and radii may be off by this share of the diagonal, directions by this angle (rad).
PLACE, ANGLE = 2e-3, 2e-2


def posed(face, pose):
    """A true face in the coordinates of a variant."""
    scale = np.cbrt(np.linalg.det(pose[:3, :3]))
    turn = pose[:3, :3] / scale
    out = {"kind": face["kind"], "area": face["area"] * scale**2, "width": face["width"] * scale}
    for key in ("dir", "n"):
        if key in face:
            out["dir"] = turn @ np.array(face[key])
    for key in ("o", "c", "apex"):
        if key in face:
            out["o" if key == "c" else key] = pose[:3, :3] @ np.array(face[key]) + pose[:3, 3]
    if "n" in face:
        out["o"] = pose[:3, :3] @ (np.array(face["n"]) * face["d"]) + pose[:3, 3]
    for key in ("r", "R"):
        if key in face:
            out[key] = face[key] * scale
    if "angle" in face:
        out["angle"] = np.radians(face["angle"])
    return out


def off(face, region, diagonal):
    """How far the parameters are off, in units of what is allowed. Infinite for other kinds."""
    if face["kind"] != region["kind"]:
        return np.inf
    if any(x is None for key in ("origin", "apex") for x in region.get(key, [])):
        return np.inf
    o, origin = face["o"] if "o" in face else face["apex"], np.array(region["origin"])
    place = PLACE * diagonal
    if face["kind"] == "sphere":
        return max(np.linalg.norm(o - origin), abs(face["r"] - region["radius"])) / place
    axis = np.array(region["axis"])
    angle = np.arcsin(min(1.0, np.linalg.norm(np.cross(axis, face["dir"])))) / ANGLE
    if face["kind"] == "plane":
        return max(angle, abs((o - origin) @ axis) / place)
    if face["kind"] == "cone":
        apex = np.array(region["apex"])
        return max(angle, abs(face["angle"] - region["angle"]) / ANGLE, np.linalg.norm(apex - face["apex"]) / place / 10)
    across = (o - origin) - (o - origin) @ axis * axis
    if face["kind"] == "cylinder":
        return max(angle, np.linalg.norm(across) / place, abs(face["r"] - region["radius"]) / place)
    return max(angle, np.linalg.norm(o - origin) / place, abs(face["R"] - region["major"]) / place, abs(face["r"] - region["radius"]) / place)


def matched(faces, regions, diagonal):
    """Pairs of true faces and regions, the nearest in area first."""
    pairs = []
    for i, face in enumerate(faces):
        for j, region in enumerate(regions):
            ratio = max(face["area"] / max(region["area"], 1e-300), region["area"] / face["area"])
            if ratio <= AREA_RATIO and off(face, region, diagonal) <= 1.0:
                pairs.append((ratio, i, j))
    found, used = {}, set()
    for _, i, j in sorted(pairs):
        if i not in found and j not in used:
            found[i] = j
            used.add(j)
    return found


def regions_of(program, data, suffix=".stl"):
    """What the program prints for a file."""
    with tempfile.NamedTemporaryFile(suffix=suffix) as file:
        file.write(data)
        file.flush()
        done = subprocess.run([program, "--faces", file.name], capture_output=True, text=True)
    if done.returncode != 0:
        return {"failed": done.stderr[-300:]}
    return json.loads(done.stdout)


def short(face):
    number = lambda x: [y and round(float(y), 4) for y in x] if np.ndim(x) else round(float(x), 4)
    return " ".join(f"{k}={number(v)}" for k, v in face.items() if v is not None and k not in ("kind", "origin_of"))


def judged(truth, found, pose, verbose):
    """The figures of one part."""
    diagonal = found["diagonal"]
    analytic = [f for f in truth["face"] if f["kind"] in KINDS]
    faces = [posed(f, pose) for f in analytic]
    regions = [r for r in found["faces"] if r["origin_of"] != "Facet"]
    pairs = matched(faces, regions, diagonal)
    used = set(pairs.values())
    missing = [f for i, f in enumerate(faces) if i not in pairs]
    extra = [r for j, r in enumerate(regions) if j not in used]
    if verbose:
        for f in missing:
            print("   missing", f["kind"], short(f))
        for r in extra:
            print("   extra", r["kind"], r["origin_of"], short(r))
    kinds = {k: truth["kinds"].get(k, 0) for k in KINDS}
    return {
        "analytic": len(analytic) == len(truth["face"]),
        "faces": len(faces),
        "right": len(pairs),
        "extra": len(extra),
        "extra_curved": sum(r["kind"] != "plane" for r in extra),
        "cylinders": kinds["cylinder"],
        "cylinders_right": sum(faces[i]["kind"] == "cylinder" for i in pairs),
        "same": all(found[k] == kinds[k] for k in KINDS) and found["facets"] == 0,
        "explained": found["triangles_explained"],
        "seconds": found["seconds"][1],
        "triangles": found["triangles"],
        "is_significant": found.get("is_significant"),
    }


def summary(rows):
    """One line for analytic parts and one for the others."""
    for wanted, name in ((True, "analytic"), (False, "others")):
        part = [r for r in rows if r["analytic"] == wanted]
        if not part:
            continue
        total = lambda key: sum(r[key] for r in part)
        seconds = sorted((r["seconds"] for r in part), reverse=True)
        print(
            f"{name:9} parts {len(part)}  same {total('same')}  right {total('right')}/{total('faces')}"
            f" ({100 * total('right') / total('faces'):.1f} %)  cylinders {total('cylinders_right')}/{total('cylinders')}"
            f" ({100 * total('cylinders_right') / max(1, total('cylinders')):.1f} %)  extra {total('extra')}"
            f" ({100 * total('extra') / total('faces'):.1f} %, curved {total('extra_curved')})"
            f"  explained median {np.median([r['explained'] for r in part]):.3f}"
            f"  significant {sum(bool(r['is_significant']) for r in part)}  s sum {sum(seconds):.1f} most {seconds[0]:.1f}"
        )


def without_truth(args, files):
    for file in files:
        data = gzip.open(file).read() if file.suffix == ".gz" else file.read_bytes()
        name = file.name.removesuffix(".gz")
        found = regions_of(args.regions, data, pathlib.Path(name).suffix)
        if "failed" in found:
            print(f"{name:24} {found['failed'].strip()[-100:]}")
            continue
        kinds = " ".join(f"{found[k]:4}" for k in KINDS)
        small = sum(r["origin_of"] == "Flat" and r["triangles"] == 1 for r in found["faces"])
        print(
            f"{name:24} {found['triangles']:8} {found['rounding']:11} pairs {found['pairs'][0]:7} {found['pairs'][1]:7}"
            f" {kinds}  facets {found['facets']:6} single {small:6} explained {found['triangles_explained']:.3f}"
            f" significant {found.get('significant', 0):.3f} {found.get('is_significant')}  {found['seconds'][1]:7.2f} s",
            flush=True,
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--regions", required=True)
    parser.add_argument("--set", default="coarse")
    parser.add_argument("--variants", default="exact")
    parser.add_argument("--only", default="")
    parser.add_argument("-v", action="store_true")
    args = parser.parse_args()
    only = [x for x in args.only.split(",") if x]
    chosen = lambda name: not only or any(name.startswith(x) for x in only)
    if args.set in ("stl_only", "scans"):
        folder = args.folder / args.set if args.set == "stl_only" else args.folder
        return without_truth(args, sorted(f for f in folder.rglob("*.*") if chosen(f.name)))
    names = sorted(f.stem for f in (args.folder / "truth").glob("*.json"))
    for kind in args.variants.split(","):
        rows = []
        for name in filter(chosen, names):
            truth = json.loads((args.folder / "truth" / f"{name}.json").read_text())
            file = args.folder / ("export/%s.stl.gz" % name if args.set == "export" else "stl/%s.%s.stl.gz" % (name, args.set))
            if not file.exists():
                continue
            data, pose = gzip.open(file).read(), np.eye(4)
            if args.set == "export":
                pose = np.array(truth["export_pose"])
            else:
                data, pose = variants.variant(kind, variants.read_stl(data))
            found = regions_of(args.regions, data)
            if "failed" in found:
                print(name, found["failed"])
                continue
            row = judged(truth, found, pose, args.v)
            rows.append(row)
            print(
                f"{name:22} {row['triangles']:6} {'same' if row['same'] else '    '} {row['right']:4}/{row['faces']:<4} extra {row['extra']:4}"
                f" ({row['extra_curved']}) explained {row['explained']:.3f} {row['is_significant']} {row['seconds']:.2f} s",
                flush=True,
            )
        print(f"--- {args.set} {kind}")
        summary(rows)
        sys.stdout.flush()


if __name__ == "__main__":
    main()
