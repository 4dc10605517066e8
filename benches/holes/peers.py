"""Fills the holes of the cases of cases.py with other programs and measures the fills
with the figures of evaluate.py.

    python3 -m venv VENV
    VENV/bin/pip install -r benches/peers/requirements.txt
    cargo build --release
    VENV/bin/python benches/holes/peers.py target/release/scan2step [--only PATTERN]
        [--peers LIST] [--seed K] [--json FILE] [--largest] [--shared DIR]

The script prints a Markdown table with a row for each case and program. --json has the
same and more.

The programs get the original scan. For the -noisy cases they get the scan that scan2step
has smoothed (its 2-smooth.ply, without islands and loose rim triangles). Vertices where
several fans meet are separated first, and joined again before the fill is measured. Every
boundary loop except the longest is filled. This includes the rims of islands, which the
programs cannot distinguish from holes. --largest omits the islands.

cgal-c1         triangulate_refine_and_fair_hole, density sqrt(2), continuity 1
cgal-c2         the same, continuity 2
meshlib         fillHoleNicely with defaults, except for maxEdgeLen, which is the mean
                edge of the rim, and maxEdgeSplits, which has no limit. It also splits
                longer edges of the rim and the measured faces beside them: 'lost'
meshlib-1000    the same with the default of maxEdgeSplits, 1000
meshlab         meshing_close_holes, refined to the mean edge of the scan; it does not
                tell which face belongs to which hole

Each program runs in its own process. 'timeout', 'signal N' and 'error' are results. A
refused hole is one that the program left open. A lost triangle is one of the input that
the output does not have. `s` is the CPU seconds of all threads for the fills alone. The
other columns are those of evaluate.py. CGAL computes in double precision, and MeshLib and
MeshLab compute in single precision.
"""

import argparse
import json
import math
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

DENSITY = math.sqrt(2)
NO_LIMIT = 10_000_000
MEMORY = 8 << 30


def main():
    options = arguments()
    virtual_scan(options.shared)
    results = []
    print(header(), flush=True)
    for name in cases.chosen(options.only):
        if name.startswith("hundred") and options.only == "*":
            continue
        with tempfile.TemporaryDirectory(dir=options.work) as folder:
            case = cases.CASES[name](options.seed)
            scan = prepared(name, case, options, Path(folder))
            for peer in options.peers:
                result = {"case": name, "peer": peer} | measure(peer, case, scan, options, Path(folder))
                results.append(result)
                print(row(result), flush=True)
                if options.json:
                    options.json.write_text(json.dumps(results, indent=1))
    failed = [r for r in results if r.get("message")]
    print("".join(f"\n- {r['case']}, {r['peer']}: {r['message']}" for r in failed))


def arguments():
    as_it_is = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=as_it_is)
    parser.add_argument("program", type=Path, help="scan2step, for its smoothing")
    parser.add_argument("--only", default="*", metavar="PATTERN", help="of names of cases")
    parser.add_argument("--peers", default="cgal-c1,cgal-c2,meshlib", metavar="LIST",
                        help=f"of {', '.join(PEERS)}")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path, metavar="FILE")
    parser.add_argument("--largest", action="store_true", help="leave islands out")
    parser.add_argument("--timeout", type=float, default=300.0, metavar="SECONDS")
    parser.add_argument("--work", type=Path, help="where temporary files go")
    parser.add_argument("--shared", type=Path, help="the folder of virtual_scan.py")
    options = parser.parse_args()
    options.program = options.program.resolve()
    options.peers = options.peers.split(",")
    if unknown := set(options.peers) - set(PEERS):
        parser.error(f"no such peer: {', '.join(sorted(unknown))}")
    return options


def prepared(name, case, options, folder):
    """The points and triangles that the programs get, with manifold vertices, and the
    number of each vertex before it was separated. None if scan2step failed."""
    points, triangles = case.points, case.triangles
    if name.endswith("-noisy"):
        points, triangles = smoothed(case, options, folder) or (None, None)
        if points is None:
            return None
    if options.largest:
        points, triangles = largest(points, triangles)
    parted, of = part(triangles, len(points))
    return np.asarray(points, float), parted, of


def smoothed(case, options, folder):
    """The output of scan2step before the fill, even if it fails later and removes its
    files."""
    file = folder / "scan.ply"
    virtual_scan(options.shared).write_ply(file, case.points, case.triangles)
    runs.convert(options.program, file, folder / "run", case.arguments, options.timeout,
                 until_fill=True)
    published = folder / "run" / "stages" / "2-smooth.ply"
    held = sorted((folder / "run" / "held").glob("*"), key=lambda f: f.stat().st_mtime_ns)
    for path in [published, *reversed(held)]:
        if path.exists() and (mesh := read_ply(path)):
            return mesh
    return None


def read_ply(path):
    """The points and triangles of a stage before the fill. None for other files."""
    text, end, data = path.read_bytes().partition(b"end_header\n")
    if not end or b"origin" in text or b"double x" not in text:
        return None
    vertices, faces = [int(line.split()[2]) for line in text.splitlines() if line.startswith(b"element")]
    face = np.dtype([("n", "u1"), ("corners", "<i4", 3)])
    if len(data) != 24 * vertices + face.itemsize * faces:
        return None
    points = np.frombuffer(data, "<f8", 3 * vertices).reshape(-1, 3)
    return points, np.frombuffer(data, face, faces, points.nbytes)["corners"].astype(np.int64)


def as_mesh(points, triangles):
    return meshes.Filled(points, triangles, np.zeros(len(points), bool), np.full(len(triangles), -1))


def largest(points, triangles):
    mesh = as_mesh(points, triangles)
    triangles = np.delete(triangles, meshes.islands(mesh), 0)
    used, triangles = np.unique(triangles, return_inverse=True)
    return points[used], triangles.reshape(-1, 3)


def part(triangles, count):
    """Gives each fan of triangles at a vertex its own vertex, and returns the former
    number of each vertex. No edge may have more than two triangles."""
    edges = meshes.Edges(triangles, count)
    two = np.flatnonzero(edges.uses == 2)
    joins = []
    for end in (0, 1):
        vertex = edges.ends[two, end]
        joins.append([3 * edges.faces[two, k] + np.argmax(triangles[edges.faces[two, k]] == vertex[:, None], 1)
                      for k in (0, 1)])
    a, b = np.concatenate(joins, 1)
    graph = coo_array((np.ones(len(a), bool), (a, b)), shape=2 * [triangles.size])
    _, fan = connected_components(graph, directed=False)
    _, first, new = np.unique(fan, return_index=True, return_inverse=True)
    return new.reshape(-1, 3), triangles.reshape(-1)[first]


def measure(peer, case, scan, options, folder):
    if scan is None:
        return {"outcome": "no smoothed scan"}
    points, triangles, of = scan
    given, filled = folder / "given.npz", folder / "filled.npz"
    np.savez(given, points=points[of], triangles=triangles)
    filled.unlink(missing_ok=True)
    command = [sys.executable, "-B", __file__, "fill", peer, given, filled]
    try:
        process = subprocess.run(list(map(str, command)), timeout=options.timeout,
                                 capture_output=True, text=True)
    except subprocess.TimeoutExpired:
        return {"outcome": "timeout"}
    said = (process.stderr or process.stdout).strip().splitlines()
    if process.returncode or not filled.exists():
        code = process.returncode
        return {"outcome": f"signal {-code}" if code < 0 else "error",
                "message": said[-1] if said else ""}
    return judged(scan, case, np.load(filled))


def judged(scan, case, out):
    """Joins the vertices that were separated, and evaluates the result."""
    points, given, of = scan
    known = len(of)
    number = np.concatenate([of, len(points) + np.arange(len(out["points"]) - known)])
    whole = np.concatenate([points, out["points"][known:]])
    triangles = number[out["triangles"]]
    mesh = meshes.Filled(whole, triangles, np.arange(len(whole)) >= len(points), out["hole"])
    lost = len(rows(of[given]) - rows(triangles[mesh.measured]))
    return evaluate.judge(mesh, case) | {
        "outcome": "", "refused": int(out["refused"]), "lost": lost, "seconds": float(out["seconds"])}


def rows(triangles):
    return set(map(tuple, np.sort(triangles, 1).tolist()))


COLUMNS = ["case", "peer", "outcome", "holes", "refused", "lost", "vertices", "rms", "max", "area rms",
           "area max", "folded", "cuts", "edges", "s"]


def header():
    return "| " + " | ".join(COLUMNS) + " |\n|" + " --- |" * len(COLUMNS)


def row(r):
    cells = [r["case"], r["peer"], r["outcome"]]
    if "holes" in r:
        number = evaluate.number
        cells += [
            str(len(r["holes"])), str(r["refused"]), str(r["lost"]), str(r["added_vertices"]),
            number(r["rms_mm"], 4), number(r["max_mm"], 3),
            number(r["area_rms_mm"], 4), number(r["area_max_mm"], 3),
            str(r["folded"]), f"{r['cuts_fill']} / {r['cuts_measured']}",
            str(r["nonmanifold_edges"]), number(r["seconds"], 2),
        ]
    return "| " + " | ".join(cells + [""] * (len(COLUMNS) - len(cells))) + " |"


# The process of another program.


def fill(peer, given, filled):
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    scan = np.load(given)
    function, *settings = PEERS[peer]
    np.savez(filled, **function(scan["points"], scan["triangles"], *settings))


def cgal(points, triangles, continuity):
    from CGAL.CGAL_Polygon_mesh_processing import triangulate_refine_and_fair_hole

    mesh = polyhedron(points, triangles)
    rims = sorted(cgal_rims(mesh), key=lambda rim: rim[1])[:-1]
    hole, seconds, refused, fresh = [np.full(len(triangles), -1)], 0.0, 0, []
    for k, (halfedge, _) in enumerate(rims):
        faces, vertices = [], []
        begun = time.process_time()
        triangulate_refine_and_fair_hole(mesh, halfedge, faces, vertices, DENSITY, continuity)
        seconds += time.process_time() - begun
        refused += not faces
        fresh += [(k, face) for face in faces]
    places = np.empty((mesh.size_of_vertices(), 3))
    for number, vertex in enumerate(mesh.vertices()):
        vertex.set_id(number)
        p = vertex.point()
        places[number] = p.x(), p.y(), p.z()
    # The lists of a Polyhedron_3 grow at their end, so the vertices of the scan come first.
    added = [corners(face) for _, face in fresh]
    hole.append(np.array([k for k, _ in fresh], int))
    assert mesh.size_of_facets() == len(triangles) + len(added)
    assert np.array_equal(places[: len(points)], points)
    return {"points": places, "hole": np.concatenate(hole), "refused": refused, "seconds": seconds,
            "triangles": np.concatenate([triangles, np.array(added, int).reshape(-1, 3)])}


def polyhedron(points, triangles):
    """Uses a file, because single points are slow."""
    from CGAL.CGAL_Polyhedron_3 import Polyhedron_3

    with tempfile.NamedTemporaryFile("w", suffix=".off") as file:
        file.write(f"OFF\n{len(points)} {len(triangles)} 0\n")
        file.writelines("%.17g %.17g %.17g\n" % tuple(p) for p in points.tolist())
        file.writelines("3 %d %d %d\n" % tuple(t) for t in triangles.tolist())
        file.flush()
        mesh = Polyhedron_3(file.name)
    if (mesh.size_of_vertices(), mesh.size_of_facets()) != (len(points), len(triangles)):
        sys.exit("CGAL does not take the scan for a manifold")
    return mesh


def cgal_rims(mesh):
    """A halfedge of each boundary loop, and the length of the loop."""
    # The vertex that a border halfedge points to identifies it, because handles have no hash.
    for number, vertex in enumerate(mesh.vertices()):
        vertex.set_id(number)
    seen = set()
    for halfedge in mesh.halfedges():
        if not halfedge.is_border() or halfedge.vertex().id() in seen:
            continue
        length, at = 0.0, halfedge.deepcopy()
        while at.vertex().id() not in seen:
            seen.add(at.vertex().id())
            a, b = at.prev().vertex().point(), at.vertex().point()
            length += math.dist((a.x(), a.y(), a.z()), (b.x(), b.y(), b.z()))
            at = at.next()
        yield halfedge.deepcopy(), length


def corners(face):
    side = face.halfedge()
    return [h.vertex().id() for h in (side, side.next(), side.next().next())]


def meshlib(points, triangles, splits):
    from meshlib import mrmeshnumpy, mrmeshpy

    mesh = mrmeshnumpy.meshFromFacesVerts(triangles.astype(np.int32), points)
    rims = sorted(mesh.topology.findHoleRepresentiveEdges(), key=mesh.holePerimeter)[:-1]
    hole, seconds, refused = {}, 0.0, 0
    for k, rim in enumerate(rims):
        count, at = 1, mesh.topology.prev(rim.sym())
        while at != rim:
            count, at = count + 1, mesh.topology.prev(at.sym())
        settings = mrmeshpy.FillHoleNicelySettings()
        settings.subdivideSettings.maxEdgeLen = mesh.holePerimeter(rim) / count
        if splits:
            settings.subdivideSettings.maxEdgeSplits = splits
        begun = time.process_time()
        faces = mrmeshpy.fillHoleNicely(mesh, rim, settings)
        seconds += time.process_time() - begun
        mine = np.flatnonzero(mrmeshnumpy.getNumpyBitSet(faces))
        refused += not len(mine)
        hole[k] = mine
    all_triangles = mrmeshnumpy.getNumpyFaces(mesh.topology).astype(np.int64)
    number = np.full(len(all_triangles), -1)
    for k, mine in hole.items():
        number[mine] = k
    places = mrmeshnumpy.getNumpyVerts(mesh).astype(float)
    n = len(points)
    # These are in single precision.
    assert np.abs(places[:n] - points).max() < 1e-4
    places[:n] = points
    return {"points": places, "triangles": all_triangles, "hole": number, "refused": refused,
            "seconds": seconds}


def meshlab(points, triangles):
    import pymeshlab

    whole = pymeshlab.MeshSet()
    whole.add_mesh(pymeshlab.Mesh(points, triangles.astype(np.int32)))
    edges = meshes.Edges(triangles, len(points))
    rims = sorted(rim_sizes(edges, len(points)))
    length = np.linalg.norm(np.diff(points[edges.ends], axis=1)[:, 0], axis=1).mean()
    begun = time.process_time()
    # All loops except the longest one, in edges.
    whole.meshing_close_holes(maxholesize=int(rims[-2] + 1), refinehole=True,
                              refineholeedgelen=pymeshlab.PureValue(length))
    seconds = time.process_time() - begun
    mesh = whole.current_mesh()
    places, faces = mesh.vertex_matrix(), mesh.face_matrix().astype(np.int64)
    assert np.array_equal(faces[: len(triangles)], triangles)
    places[: len(points)] = points
    left = len(rim_sizes(meshes.Edges(faces, len(places)), len(places))) - 1
    hole = np.r_[np.full(len(triangles), -1), np.zeros(len(faces) - len(triangles), int)]
    return {"points": places, "triangles": faces, "hole": hole, "refused": left, "seconds": seconds}


def rim_sizes(edges, count):
    """The edges of each boundary loop."""
    rim = edges.ends[edges.uses == 1]
    graph = coo_array((np.ones(len(rim), bool), rim.T), shape=2 * [count])
    return np.unique(connected_components(graph, directed=False)[1][rim[:, 0]], return_counts=True)[1]


PEERS = {"meshlab": (meshlab,), "cgal-c1": (cgal, 1), "cgal-c2": (cgal, 2), "meshlib": (meshlib, NO_LIMIT),
         "meshlib-1000": (meshlib, None)}

if __name__ == "__main__":
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    import meshes

    if sys.argv[1:2] == ["fill"]:
        fill(*sys.argv[2:])
    else:
        import cases
        import evaluate
        import run as runs
        from scans import virtual_scan

        main()
