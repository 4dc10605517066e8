"""What the Python package costs beside the program.

    PYTHON benches/python.py SCAN.ply

PYTHON has the package scan2step, built with --release. The script prints a Markdown table: the median CPU
seconds of seven alternating runs of the program, of the package with the file, and of the package with arrays
(without numpy's import and the reading); the time to import; the time to copy arrays in; the size of a wheel
is that of its file.
"""

import json
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))
import made

RUNS = 7

FILE = "import sys, scan2step; scan2step.convert(sys.argv[1]).write(sys.argv[2])"
ARRAYS = """
import json, resource, sys, time, scan2step
cpu = lambda: sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
scan = scan2step.read(sys.argv[1])
vertices, faces = scan.vertices, scan.faces
begin, t = cpu(), time.perf_counter()
from scan2step._scan import scan_of
scan_of(vertices, faces)
copied = time.perf_counter() - t
begin = cpu()
scan2step.convert(vertices, faces, name="scan").write(sys.argv[2])
print(json.dumps([cpu() - begin, copied]))
"""
IMPORT = """
import time, numpy, json, tempfile, html, base64
t = time.perf_counter()
import scan2step
print(time.perf_counter() - t)
"""


def cpu(command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    out = subprocess.run(command, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return sum(after[:2]) - sum(before[:2]), out


def main(scan):
    program = made.built("scan2step", "bin")
    times = {"program": [], "file": [], "arrays": []}
    copied, imported = [], []
    with tempfile.TemporaryDirectory() as folder:
        out = str(Path(folder) / "part.step")
        for _ in range(RUNS):
            times["program"].append(cpu([program, "convert", scan, out, "--quiet"])[0])
            times["file"].append(cpu([sys.executable, "-c", FILE, scan, out])[0])
            seconds, copy = json.loads(cpu([sys.executable, "-c", ARRAYS, scan, out])[1])
            times["arrays"].append(seconds)
            copied.append(copy)
            imported.append(float(cpu([sys.executable, "-c", IMPORT])[1]))
    middle = {name: statistics.median(all) for name, all in times.items()}
    print("| way | CPU s | beside the program |\n| --- | --- | --- |")
    for name, seconds in middle.items():
        print(f"| {name} | {seconds:.3f} | {100 * (seconds / middle['program'] - 1):+.1f} % |")
    print(f"\nimport: {1e3 * statistics.median(imported):.1f} ms beyond numpy's; arrays in: {1e3 * statistics.median(copied):.1f} ms")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) == 2 else sys.exit(__doc__))
