"""One fit by one other program in its own process. `fit.py` runs it.

    python benches/peers/fit_peers.py gismo|fitpack|geomdl|freecad SAMPLES.npz N OUT.npy

SAMPLES has uv and p. The surface has N x N control points over uniform knots in [0, 1]. The
script writes the surface at the points `at` to OUT, where it is compared with the truth, and
prints the CPU seconds of all threads for the fit alone.
"""

import json
import os
import sys
import time

import numpy as np


def uniform(n):
    """The clamped cubic knot vector of n functions."""
    return np.concatenate([np.zeros(3), np.linspace(0, 1, n - 2), np.ones(3)])


def spline(net, n, at):
    """A surface with n x n control points (and 3) at the given parameters."""
    from scipy.interpolate import BSpline

    knots, net = uniform(n), net.reshape(n, n, 3)
    bu, bv = (BSpline.design_matrix(np.ascontiguousarray(at[:, k]), knots, 3) for k in (0, 1))
    rows = np.stack([(bu @ net[:, :, k]) for k in range(3)], -1)
    return np.stack([np.asarray(bv.multiply(rows[:, :, k]).sum(1)).ravel() for k in range(3)], -1)


def gismo(uv, p, n, at):
    import pygismo

    knots = [pygismo.nurbs.gsKnotVector(uniform(n), 3) for _ in range(2)]
    basis = pygismo.nurbs.gsTensorBSplineBasis2(*knots)
    begun = time.process_time()
    fit = pygismo.modelling.gsFitting(np.asfortranarray(uv.T), np.asfortranarray(p.T), basis)
    # Without it the equations are singular in holes.
    fit.compute(1e-9)
    cpu = time.process_time() - begun
    return cpu, np.asarray(fit.result().eval(np.asfortranarray(at.T))).T


def fitpack(uv, p, n, at):
    from scipy.interpolate import LSQBivariateSpline

    inner = np.linspace(0, 1, n - 2)[1:-1]
    begun = time.process_time()
    axes = [LSQBivariateSpline(uv[:, 0], uv[:, 1], p[:, k], inner, inner, bbox=[0, 1, 0, 1])
            for k in range(3)]
    cpu = time.process_time() - begun
    return cpu, np.stack([axis.ev(at[:, 0], at[:, 1]) for axis in axes], -1)


def geomdl(uv, p, n, at):
    """It needs grids and computes its own parameters, at which it is compared."""
    from geomdl import fitting

    side = int(round(len(p) ** 0.5))
    begun = time.process_time()
    fitting.approximate_surface(p.tolist(), side, side, 3, 3, ctrlpts_size_u=n, ctrlpts_size_v=n)
    return time.process_time() - begun, None


def freecad(uv, p, n, at):
    """It needs only points, which it projects. It runs in FreeCAD's own Python."""
    import ReverseEngineering

    points = [tuple(x) for x in p.tolist()]
    begun = time.process_time()
    ReverseEngineering.approxSurface(Points=points, UDegree=3, VDegree=3, NbUPoles=n, NbVPoles=n)
    return time.process_time() - begun, None


def main(peer, samples, n, out):
    data = np.load(samples)
    cpu, surface = globals()[peer](data["uv"], data["p"], int(n), data["at"])
    if surface is not None:
        np.save(out, surface)
    print(json.dumps({"cpu_s": cpu}), flush=True)
    # FreeCAD's console would wait for more input.
    os._exit(0)


if "FIT_PEER" in os.environ:
    main(*os.environ["FIT_PEER"].split("\n"))
elif __name__ == "__main__":
    main(*sys.argv[1:])
