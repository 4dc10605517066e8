"""What the engines' scripts share: scans, killing, and comparing with one machine."""

import hashlib
import os
import random
import shutil
import signal
import sys
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

#: Scans of a run. One of them is broken.
COUNT = 24
OPTIONS = {"tolerance": 0.6}


def scans(folder):
    """Makes scans: the relief of the fixtures in several sizes, and a broken one."""
    import numpy as np
    import scan2step

    read = scan2step.read(ROOT / "fixtures/relief.ply")
    folder.mkdir(parents=True, exist_ok=True)
    for k in range(COUNT):
        with open(folder / f"scan{k:02}.obj", "w") as file:
            for x, y, z in read.vertices * np.array([1.0, 1.0, 0.5 + 0.05 * k]):
                file.write(f"v {float(x)!r} {float(y)!r} {float(z)!r}\n")
            for a, b, c in read.faces + 1:
                file.write(f"f {a} {b} {c}\n")
    (folder / "broken.obj").write_text("v 0 0 nothing\n")
    return sorted(folder.iterdir())


def out(folder, scan):
    return folder / f"{Path(scan).stem}.step"


def digests(folder):
    """The digest of each CAD file. A file with another name is an error."""
    found = {}
    for path in sorted(folder.rglob("*")):
        if path.suffix == ".step":
            found[path.name] = hashlib.sha256(path.read_bytes()).hexdigest()
        elif path.is_file() and ".part" in path.name:
            sys.exit(f"half a file was left: {path}")
    return found


def on_one_machine(paths, folder):
    """The digests of a run without an engine."""
    from scan2step.dask import convert_file

    shutil.rmtree(folder, ignore_errors=True)
    for path in paths:
        convert_file(path, out(folder, path), **OPTIONS)
    return digests(folder)


class Killer(threading.Thread):
    """Kills a worker three times, at random moments."""

    def __init__(self, pids, seed, begun):
        super().__init__(daemon=True)
        self.pids, self.begun, self.killed = pids, begun, []
        self.random = random.Random(seed)

    def run(self):
        # Workers have to have something to lose.
        while not self.begun():
            time.sleep(0.02)
        for _ in range(3):
            time.sleep(self.random.uniform(0.1, 0.8))
            pids = self.pids()
            if pids:
                pid = self.random.choice(pids)
                try:
                    os.kill(pid, signal.SIGKILL)
                except ProcessLookupError:
                    continue
                self.killed.append(pid)


def check(name, rows, expected, folder, killed):
    """Compares an engine's run with that on one machine, and prints a line."""
    found = digests(folder)
    assert found == expected, f"{set(expected) ^ set(found)} differ"
    status = [row["status"] for row in rows]
    assert len(rows) == COUNT + 1 and status.count("failed") == 1, status
    print(f"{name}: {len(rows)} rows, {len(found)} files, {len(killed)} workers killed; bytes as on one machine")


def times(folder):
    return {path.name: path.stat().st_mtime_ns for path in folder.glob("*.step")}
