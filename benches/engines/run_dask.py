"""Converts scans with Dask, and kills workers meanwhile.

    PYTHON benches/engines/run_dask.py [SEED]

PYTHON has the packages scan2step and distributed.
"""

import sys
import tempfile
from pathlib import Path

import common


def main(seed):
    from distributed import Client, LocalCluster
    from scan2step.dask import convert_file

    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        paths = common.scans(folder / "scans")
        expected = common.on_one_machine(paths, folder / "alone")
        made = folder / "dask"
        outs = [common.out(made, path) for path in paths]
        cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
        with cluster, Client(cluster) as client:
            pids = lambda: [w.pid for w in cluster.workers.values() if w.pid]
            killer = common.Killer(pids, seed, lambda: any(made.glob("*.step")))
            killer.start()
            tasks = client.map(convert_file, paths, outs, retries=5, **common.OPTIONS)
            rows = client.gather(tasks)
            common.check("Dask", rows, expected, made, killer.killed)
            before = common.times(made)
            client.gather(client.map(convert_file, paths, outs, pure=False, **common.OPTIONS))
            assert common.times(made) == before, "a finished scan was converted again"
            print("Dask: a second run converted nothing again")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1)
