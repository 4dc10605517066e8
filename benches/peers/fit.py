"""Compares the fit with other programs and with the truth of virtual scans.

    VENV/bin/python benches/peers/fit.py [ours|gismo|fitpack|geomdl|freecad|linear|paper ...]

`run.py` explains how to make VENV. The script prints Markdown tables: the CPU seconds of all
threads for the fit alone, and the root mean square distance of the surface from the true one,
outside the holes and in them. Samples have their true parameters, and holes are not filled.
Each program runs on the largest case that it finishes in a reasonable time. `linear` shows the
growth of the cost with points and nets. `paper` is the comparison of section 3.5.1 of Tekumalla
and Cohen (2005). The script needs Linux.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path[:0] = [str(HERE), str(HERE.parent)]
import made

CASES = [(scan, n) for scan in ("relief250k", "relief1m") for n in (67, 131, 259)]
# The case on which each slower program is measured. geomdl needs complete grids.
SLOW = {"fitpack": ("relief250k", 35), "geomdl": ("grid250k", 35), "freecad": ("roll40k", 13)}
NETS = (13, 35, 67, 131, 259, 515)
REPEATS = 3


def main(wanted):
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(Path(folder))
        peers = [w for w in wanted if w in ("ours", "gismo", *SLOW)]
        if peers:
            title("case", "program", "CPU s", "ratio", "rms outside holes", "in holes")
        for peer in peers:
            for scan, n in CASES if peer in ("ours", "gismo") else [SLOW[peer]]:
                bench.beside(peer, scan, n)
        if "linear" in wanted:
            bench.linear()
        if "paper" in wanted:
            bench.paper()


def title(*columns):
    print("\n| " + " | ".join(columns) + " |\n|" + " --- |" * len(columns), flush=True)


def row(*cells):
    print("| " + " | ".join(str(c) for c in cells) + " |", flush=True)


class Bench:
    def __init__(self, folder):
        self.program, self.folder, self.made = made.built("fit"), folder, {}

    def scan(self, name):
        """The files of samples, and the points at which surfaces are compared."""
        import numpy as np

        if name in self.made:
            return self.made[name]
        uv, points = made.samples(name)
        if name.startswith("grid"):
            # The order is row by row again. A point is displaced by less than half a step.
            side = round(len(uv) ** 0.5) - 1
            order = np.lexsort(np.round(uv.T[::-1] * side))
            uv, points = uv[order], points[order]
        at, inside = made.places(name)
        stem = self.folder / name
        np.hstack([uv, points]).astype("<f8").tofile(stem)
        np.savez(stem.with_suffix(".npz"), uv=uv, p=points, at=at)
        self.made[name] = stem, len(points), at, inside
        return self.made[name]

    def ours(self, stem, n, method="refined", out=None):
        """The run with the median CPU time."""
        command = [self.program, stem, str(n), str(n), method] + ([out] if out else [])
        runs = [json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
                for _ in range(REPEATS)]
        return sorted(runs, key=lambda r: r["cpu_s"])[REPEATS // 2]

    def beside(self, peer, name, n):
        import numpy as np
        from fit_peers import spline

        stem, _, at, inside = self.scan(name)
        net = self.folder / "net"
        cpu = self.ours(stem, n, out=net)["cpu_s"]
        case = f"{name}, {n}²"
        row(case, "scan2step", f"{cpu:.3f}", "1", *errors(name, spline(np.fromfile(net), n, at), inside))
        if peer == "ours":
            return
        out = self.folder / "out.npy"
        out.unlink(missing_ok=True)
        args = [peer, stem.with_suffix(".npz"), str(n), out]
        environment, command = None, [sys.executable, "-B", HERE / "fit_peers.py", *args]
        if peer == "freecad":
            if not shutil.which("freecadcmd"):
                return row(case, peer, "not measured: freecadcmd is absent", "", "", "")
            environment = os.environ | {"FIT_PEER": "\n".join(map(str, args))}
            command = ["freecadcmd", HERE / "fit_peers.py"]
        run = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        told = [line for line in run.stdout.decode().splitlines() if line.startswith("{")]
        if not told:
            return row(case, peer, f"failed: {run.stderr.decode().strip()[-80:]}", "", "", "")
        took = json.loads(told[-1])["cpu_s"]
        found = errors(name, np.load(out), inside) if out.exists() else ("", "")
        row(case, peer, f"{took:.3f}", f"{took / cpu:.0f}", *found)

    def linear(self):
        title("points", *(f"{n}²" for n in NETS))
        for name in ("relief10k", "relief100k", "relief250k", "relief1m", "relief4m"):
            stem, count, _, _ = self.scan(name)
            runs = [self.ours(stem, n) for n in NETS]
            row(f"{count:,}", *(f"{r['cpu_s']:.3f}" for r in runs))
    def paper(self):
        title("paper2500, 13 × 13", "mean error", "to global")
        stem, *_ = self.scan("paper2500")
        runs = {m: self.ours(stem, 13, m)["mean_mm"] for m in ("global", "refined", "blend")}
        for method, mean in runs.items():
            row(method, f"{mean:.6f}", f"{mean / runs['global']:.4f}")


def errors(name, surface, inside):
    rms = lambda points: f"{made.rms(name, points):.4f}" if len(points) else ""
    return rms(surface[~inside]), rms(surface[inside])


if __name__ == "__main__":
    main(sys.argv[1:] or ["gismo", "fitpack", "geomdl", "freecad", "linear", "paper"])
