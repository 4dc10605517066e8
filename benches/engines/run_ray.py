"""Converts scans with Ray, and kills workers meanwhile.

    PYTHON benches/engines/run_ray.py [SEED]

PYTHON has the packages scan2step, ray and psutil.
"""

import sys
import tempfile
from pathlib import Path

import common


def main(seed):
    import psutil
    import ray
    from scan2step.dask import convert_file

    def workers():
        running = psutil.process_iter(["name", "cmdline"])
        return [p.pid for p in running if "ray::convert" in " ".join(p.info["cmdline"] or [])]

    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        paths = common.scans(folder / "scans")
        expected = common.on_one_machine(paths, folder / "alone")
        made = folder / "ray"
        ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
        task = ray.remote(num_cpus=1, max_retries=5)(convert_file)
        killer = common.Killer(workers, seed, lambda: any(made.glob("*.step")))
        killer.start()
        started = [task.remote(p, common.out(made, p), **common.OPTIONS) for p in paths]
        common.check("Ray", ray.get(started), expected, made, killer.killed)
        before = common.times(made)
        ray.get([task.remote(p, common.out(made, p), **common.OPTIONS) for p in paths])
        assert common.times(made) == before, "a finished scan was converted again"
        print("Ray: a second run converted nothing again")
        ray.shutdown()


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1)
