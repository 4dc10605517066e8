"""The fit beside other programs, and beside the truth of virtual scans.

    python3 -m venv VENV
    VENV/bin/pip install -r benches/fit/requirements.txt
    VENV/bin/python benches/fit/run.py [ours|gismo|fitpack|geomdl|freecad|linear|paper ...]

Prints Markdown tables: CPU seconds of all threads, of the fit alone, and root mean
square distance of the surface from the true one, outside the holes and in them.
Samples have their true parameters; holes are not filled. Peers are run on the
largest case each finishes in reasonable time. `linear` shows the cost as points and
nets grow, `paper` the comparison of section 3.5.1.

The scans are made by virtual_scan.py, which is not part of the project; without
it (../shared beside the checkout) nothing is measured, and that is said.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
SHARED = ROOT.parent / "shared"
HERE = Path(__file__).resolve().parent
CASES = [(scan, n) for scan in ("relief250k", "relief1m") for n in (67, 131, 259)]
# Which case each slower peer is measured on.
SLOW = {"fitpack": ("relief250k", 35), "geomdl": ("relief250k", 35), "freecad": ("roll40k", 13)}
REPEATS = 3


def main():
    if not (SHARED / "virtual_scan.py").exists():
        sys.exit(f"NOT MEASURED: {SHARED / 'virtual_scan.py'} is absent; it is not part of the project")
    sys.dont_write_bytecode = True
    sys.path[:0] = [str(SHARED), str(HERE)]
    wanted = sys.argv[1:] or ["gismo", "fitpack", "geomdl", "freecad", "linear", "paper"]
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
        cargo = ["cargo", "build", "--release", "--example", "fit", "--message-format", "json"]
        lines = subprocess.run(cargo, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout
        built = [json.loads(line) for line in lines.splitlines()]
        self.program = [b["executable"] for b in built if b.get("target", {}).get("name") == "fit"][-1]
        self.folder, self.made = folder, {}

    def scan(self, name, grid=None, whole=False):
        """Files of samples, and the places where surfaces are compared."""
        import numpy as np
        import virtual_scan as vs

        key = (name, grid, whole)
        if key in self.made:
            return self.made[key]
        truth, m, n, sigma, holes = vs.SCANS[name]
        if grid or whole:
            vs.SCANS["case"] = (truth, grid or m, grid or n, sigma, [])
        points, _, uv = vs.scan("case" if grid or whole else name)
        t = (np.arange(300) + 0.5) / 300
        at = np.stack([x.ravel() for x in np.meshgrid(t, t, indexing="ij")], 1)
        inside = np.zeros(len(at), bool)
        for hole in holes:
            inside |= hole(at[:, 0], at[:, 1])
        stem = self.folder / f"{name}-{grid}-{whole}"
        np.hstack([uv, points]).astype("<f8").tofile(stem)
        np.savez(stem.with_suffix(".npz"), uv=uv, p=points, at=at)
        self.made[key] = stem, len(points), at, inside
        return self.made[key]

    def ours(self, stem, n, method="refined", out=None):
        """The run with the median CPU time."""
        command = [self.program, stem, str(n), str(n), method] + ([out] if out else [])
        runs = [json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
                for _ in range(REPEATS)]
        return sorted(runs, key=lambda r: r["cpu_s"])[REPEATS // 2]

    def beside(self, peer, name, n):
        import numpy as np
        from peers import spline

        stem, count, at, inside = self.scan(name, whole=peer == "geomdl")
        net = self.folder / "net"
        cpu = self.ours(stem, n, out=net)["cpu_s"]
        case = f"{name}, {n}²"
        row(case, "scan2step", f"{cpu:.3f}", "1", *errors(name, spline(np.fromfile(net), n, at), inside))
        if peer == "ours":
            return
        out = self.folder / "out.npy"
        out.unlink(missing_ok=True)
        args = [peer, stem.with_suffix(".npz"), str(n), out]
        environment, command = None, [sys.executable, "-B", HERE / "peers.py", *args]
        if peer == "freecad":
            if not shutil.which("freecadcmd"):
                return row(case, peer, "not measured: freecadcmd is absent", "", "", "")
            environment = os.environ | {"FIT_PEER": "\n".join(map(str, args))}
            command = ["freecadcmd", HERE / "peers.py"]
        run = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        told = [line for line in run.stdout.decode().splitlines() if line.startswith("{")]
        if not told:
            return row(case, peer, f"failed: {run.stderr.decode().strip()[-80:]}", "", "", "")
        took = json.loads(told[-1])["cpu_s"]
        found = errors(name, np.load(out), inside) if out.exists() else ("", "")
        row(case, peer, f"{took:.3f}", f"{took / cpu:.0f}", *found)

    def linear(self):
        title("points", *(f"{n}²" for n in (13, 35, 67, 131, 259, 515)))
        for grid in (100, 316, 500, 1000, 2000):
            stem, count, _, _ = self.scan("relief1m", grid)
            runs = [self.ours(stem, n) for n in (13, 35, 67, 131, 259, 515)]
            row(count, *(f"{r['cpu_s']:.4f} ({r['steps']})" for r in runs))

    def paper(self):
        title("paper2500, 13 × 13", "mean error", "to global")
        stem, *_ = self.scan("paper2500")
        runs = {m: self.ours(stem, 13, m)["mean_mm"] for m in ("global", "refined", "blend")}
        for method, mean in runs.items():
            row(method, f"{mean:.6f}", f"{mean / runs['global']:.4f}")


def errors(name, surface, inside):
    import numpy as np
    import virtual_scan as vs

    d = vs.truth_distance(name, surface)
    rms = lambda x: f"{np.sqrt(np.mean(np.square(x))):.4f}" if len(x) else ""
    return rms(d[~inside]), rms(d[inside])


if __name__ == "__main__":
    main()
