"""Compares scan2step with other programs, all of which are from PyPI or Debian.

    python3.11 -m venv VENV
    VENV/bin/pip install -r benches/peers/requirements.txt
    VENV/bin/python benches/peers/run.py [read|fill|clouds|fit ...]

The script makes its scans, runs every program on them in its own process, and prints Markdown
tables: the CPU seconds, their ratio to those of scan2step in the same run, and the distance from
the true surface if there is one. All four comparisons take about forty minutes. Each of them is a
script with its own options: read.py, fill.py, clouds.py, fit.py. FreeCAD is searched as freecadcmd
(Debian: freecad-python3). The script needs Linux.
"""

import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))
import clouds
import fill
import fit
import read

TASKS = {
    "read": ("Reading and meshing a million points", lambda: read.main([])),
    "fill": ("Filling holes", lambda: fill.main(fill.SCANS)),
    "clouds": ("Triangles of clouds of points", lambda: clouds.main([])),
    "fit": ("Fitting a surface", lambda: fit.main(["gismo", "fitpack", "geomdl", "freecad"])),
}


def main():
    wanted = sys.argv[1:] or list(TASKS)
    if unknown := set(wanted) - set(TASKS):
        sys.exit(f"no such comparison: {', '.join(sorted(unknown))}; there are {', '.join(TASKS)}")
    for task in wanted:
        title, run = TASKS[task]
        print(f"\n# {title}\n", flush=True)
        run()


if __name__ == "__main__":
    main()
