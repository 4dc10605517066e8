"""Makes triangles of a cloud with one other program in its own process. `clouds.py` runs it.

    python benches/peers/clouds_peers.py PEER POINTS SPACING OUT.npz

POINTS are float64 triples. The script prints one line of JSON with the CPU seconds of all threads
for the work alone, and the peak memory of the process in MB (10^6 bytes).

Ball pivoting and Poisson need normals that agree. Open3D gets them along the z axis, which suits
the relief of `clouds.py`; MeshLab makes them from the points, as its users do.
"""

import json
import sys
import time

import numpy as np


def open3d_cloud(points):
    import open3d

    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    cloud.estimate_normals(open3d.geometry.KDTreeSearchParamKNN(24))
    cloud.orient_normals_to_align_with_direction(np.array([0.0, 0.0, 1.0]))
    return open3d, cloud


def open3d_balls(points, spacing):
    open3d, cloud = open3d_cloud(points)
    radii = open3d.utility.DoubleVector([1.25 * spacing, 2 * spacing, 3 * spacing])
    mesh = open3d.geometry.TriangleMesh.create_from_point_cloud_ball_pivoting(cloud, radii)
    return np.asarray(mesh.vertices), np.asarray(mesh.triangles)


def open3d_poisson(points, spacing):
    """Without the twentieth of the vertices that fewest points support."""
    open3d, cloud = open3d_cloud(points)
    extent = np.ptp(points, axis=0).max()
    depth = round(np.log2(extent / spacing)) + 1
    mesh, density = open3d.geometry.TriangleMesh.create_from_point_cloud_poisson(cloud, depth=depth)
    density = np.asarray(density)
    mesh.remove_vertices_by_mask(density < np.quantile(density, 0.05))
    return np.asarray(mesh.vertices), np.asarray(mesh.triangles)


def meshlab(points):
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(points))
    return meshes


def meshlab_balls(points, spacing):
    meshes = meshlab(points)
    meshes.generate_surface_reconstruction_ball_pivoting()
    return result(meshes)


def meshlab_poisson(points, spacing):
    meshes = meshlab(points)
    meshes.compute_normal_for_point_clouds()
    meshes.generate_surface_reconstruction_screened_poisson()
    return result(meshes)


def result(meshes):
    mesh = meshes.current_mesh()
    return mesh.vertex_matrix(), mesh.face_matrix()


PEERS = {
    "open3d-balls": open3d_balls,
    "open3d-poisson": open3d_poisson,
    "meshlab-balls": meshlab_balls,
    "meshlab-poisson": meshlab_poisson,
}


def main():
    peer, given, spacing, out = sys.argv[1:]
    points = np.fromfile(given).reshape(-1, 3)
    __import__(peer.split("-")[0].replace("meshlab", "pymeshlab"))
    begun = time.process_time()
    vertices, triangles = PEERS[peer](points, float(spacing))
    seconds = time.process_time() - begun
    np.savez(out, points=vertices, triangles=triangles)
    with open("/proc/self/status") as status:
        line = next(line for line in status if line.startswith("VmHWM:"))
    print(json.dumps({"cpu_s": seconds, "peak_rss_mb": int(line.split()[1]) * 1024 / 1e6}))


if __name__ == "__main__":
    main()
