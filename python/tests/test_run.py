"""Progress, Ctrl-C, threads, forks and processes. Each has a deadline."""

from __future__ import annotations

import hashlib
import multiprocessing
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from typing import List, Tuple

import pytest
from conftest import FIXTURES

import scan2step

RING = str(FIXTURES / "ring.obj")


def digest(threads: int) -> str:
    return hashlib.sha256(scan2step.convert(RING, threads=threads).step()).hexdigest()


def test_progress_is_told_on_the_calling_thread(ring: str) -> None:
    told: List[Tuple[str, float]] = []
    threads = set()

    def progress(stage: str, share: float) -> None:
        told.append((stage, share))
        threads.add(threading.get_ident())

    scan2step.convert(ring, progress=progress)
    stages = [stage for stage, _ in told]
    for stage in ("mesh", "smooth", "fill", "layout", "fit", "deviation"):
        assert stage in stages
    assert all(0.0 <= share <= 1.0 for _, share in told)
    assert threads == {threading.get_ident()}


def test_what_progress_raises_stops_and_passes_through(ring: str) -> None:
    class Enough(Exception):
        pass

    def progress(stage: str, share: float) -> None:
        if stage == "smooth":
            raise Enough("no more")

    with pytest.raises(Enough):
        scan2step.convert(ring, progress=progress)
    assert scan2step.convert(ring).kind == "solid"


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_stops_within_a_second(ring: str) -> None:
    script = (
        "import scan2step, signal, sys, time\n"
        # A shell starts its background jobs with this signal ignored, and so did this process then.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "def told(stage, share):\n"
        "    if stage == 'layout': print('begun', flush=True)\n"
        "try:\n"
        "    for _ in range(100): scan2step.convert(sys.argv[1], progress=told)\n"
        "except KeyboardInterrupt:\n"
        "    print('stopped', time.monotonic(), flush=True)\n"
        "    print(scan2step.convert(sys.argv[1]).kind)\n"
    )
    child = subprocess.Popen(
        [sys.executable, "-c", script, ring], stdout=subprocess.PIPE, text=True
    )
    assert child.stdout is not None
    assert child.stdout.readline() == "begun\n"
    begin = time.monotonic()
    child.send_signal(signal.SIGINT)
    said = [line.split() for line in child.stdout if line != "begun\n"]
    assert [line[0] for line in said] == ["stopped", "solid"], said
    # The child has the same clock, and this process may hear of it late on a busy machine.
    assert float(said[0][1]) - begin < 1.0
    assert child.wait(60) == 0


def test_other_threads_go_on_meanwhile(ring: str) -> None:
    beats = 0
    done = threading.Event()

    def beat() -> None:
        nonlocal beats
        while not done.is_set():
            beats += 1
            time.sleep(0.001)

    thread = threading.Thread(target=beat)
    thread.start()
    begin = time.monotonic()
    scan2step.convert(ring)
    seconds = time.monotonic() - begin
    done.set()
    thread.join()
    assert beats > 50 * seconds


def test_four_threads_at_once_make_the_same_bytes() -> None:
    with ThreadPoolExecutor(4) as pool:
        made = list(pool.map(digest, [1, 2, 3, 1]))
    assert len(set(made)) == 1


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_processes_work_after_use(method: str) -> None:
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"there is no {method} here")
    own = digest(2)
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert pool.map_async(digest, [1, 2]).get(timeout=120) == [own, own]
