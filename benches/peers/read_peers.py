"""One task with one other program in its own process. `read.py` runs it.

    python benches/peers/read_peers.py trimesh|open3d|pymeshlab import|read|mesh [FILE]

The script prints one line of JSON with the result and the peak memory of the process in MB (10^6
bytes). "mesh" welds coincident vertices, removes degenerate and duplicate triangles, opens or
removes non-manifold parts, makes the orientation consistent, and counts components and boundary
loops.
"""

import json
import sys


def with_trimesh(task, path):
    import numpy
    import trimesh

    if task == "import":
        return {}
    mesh = trimesh.load_mesh(path, process=False)
    if task == "read":
        return counts(len(mesh.vertices), len(mesh.faces))
    mesh.merge_vertices()
    # Without a height it removes only faces without area.
    mesh.update_faces(mesh.nondegenerate_faces(height=None))
    mesh.update_faces(mesh.unique_faces())
    # It only tests if no triangle is inverted, as in this scan. Otherwise it walks.
    trimesh.repair.fix_winding(mesh)
    components = mesh.body_count
    manifold = bool(numpy.bincount(mesh.edges_unique_inverse).max() <= 2)
    found = counts(len(mesh.vertices), len(mesh.faces))
    return found | topology(components, loops(components, mesh.euler_number), manifold)


def with_open3d(task, path):
    import open3d

    if task == "import":
        return {}
    mesh = open3d.io.read_triangle_mesh(path)
    if task == "read":
        return counts(len(mesh.vertices), len(mesh.triangles))
    mesh.remove_duplicated_vertices()
    mesh.remove_degenerate_triangles()
    mesh.remove_duplicated_triangles()
    mesh.remove_non_manifold_edges()
    mesh.remove_unreferenced_vertices()
    mesh.orient_triangles()
    components = len(mesh.cluster_connected_triangles()[1])
    manifold = mesh.is_edge_manifold(allow_boundary_edges=True) and mesh.is_vertex_manifold()
    found = counts(len(mesh.vertices), len(mesh.triangles))
    euler = mesh.euler_poincare_characteristic()
    return found | topology(components, loops(components, euler), manifold)


def with_pymeshlab(task, path):
    import pymeshlab

    if task == "import":
        return {}
    meshes = pymeshlab.MeshSet()
    # For STL it welds the vertices while reading, unless it is told not to.
    options = {"unify_vertices": False} if path.endswith(".stl") else {}
    meshes.load_new_mesh(path, **options)
    if task == "read":
        mesh = meshes.current_mesh()
        return counts(mesh.vertex_number(), mesh.face_number())
    meshes.meshing_remove_duplicate_vertices()
    meshes.meshing_remove_duplicate_faces()
    meshes.meshing_remove_null_faces()
    meshes.meshing_repair_non_manifold_edges()
    meshes.meshing_repair_non_manifold_vertices()
    meshes.meshing_remove_unreferenced_vertices()
    meshes.meshing_re_orient_faces_coherently()
    found = meshes.get_topological_measures()
    return counts(found["vertices_number"], found["faces_number"]) | topology(
        found["connected_components_number"],
        found["number_holes"],
        found["is_mesh_two_manifold"],
    )


def counts(vertices, triangles):
    return {"vertices": vertices, "triangles": triangles}


def topology(components, loops, manifold):
    return {"components": int(components), "loops": int(loops), "manifold": bool(manifold)}


def loops(components, euler):
    """The boundary loops of a mesh whose components are of genus 0."""
    return 2 * components - euler


def peak_rss_mb():
    # ru_maxrss is not used, because it begins with the peak of the parent process.
    with open("/proc/self/status") as status:
        line = next(line for line in status if line.startswith("VmHWM:"))
    return int(line.split()[1]) * 1024 / 1e6


def main():
    tool, task, path = (*sys.argv[1:], "")[:3]
    run = {"trimesh": with_trimesh, "open3d": with_open3d, "pymeshlab": with_pymeshlab}[tool]
    print(json.dumps(run(task, path) | {"peak_rss_mb": peak_rss_mb()}))


if __name__ == "__main__":
    main()
