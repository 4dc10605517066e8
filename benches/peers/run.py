"""scan2step beside other programs, all of them from PyPI or Debian.

    python3.11 -m venv VENV
    VENV/bin/pip install -r benches/peers/requirements.txt
    VENV/bin/python benches/peers/run.py [read|fill|fit ...]

Makes its scans itself, runs every program on them in a process of its own, and
prints Markdown tables: CPU seconds and their ratio to scan2step's in the same run,
and the distance to the true surface where there is one. All three take some twenty
minutes. Each can be run by itself, with options of its own: read.py, fill.py,
fit.py. FreeCAD, for its row, is looked for as freecadcmd (Debian:
freecad-python3). Needs Linux.
"""

import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))
import fill
import fit
import read

TASKS = {
    "read": ("Reading and meshing a million points", lambda: read.main([])),
    "fill": ("Filling holes", lambda: fill.main(fill.SCANS)),
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
