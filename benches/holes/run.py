"""Runs scan2step on a scan and watches it. Returns the times of its stages, and the filled
mesh even if a later stage fails.

The program removes the files of the stages when it fails. While it runs, they are in their
folder with temporary names. This script gives each of them a second name as soon as it
appears, and finds the file of the fill by its header.
"""

import os
import re
import signal
import subprocess
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

from meshes import is_filled

STAGE = re.compile(r"^(\w+)\s+([0-9.]+) s(?:\s|$)")
LOOK_EVERY_S = 0.003


@dataclass
class Run:
    """`code` is the exit code, or None if this script ended the run. `seconds` and
    `cpu_s` are those of each stage that ended."""

    code: int | None = None
    ended: str = ""
    stderr: list = field(default_factory=list)
    seconds: dict = field(default_factory=dict)
    cpu_s: dict = field(default_factory=dict)
    filled: Path | None = None


def convert(program, scan, folder, arguments, timeout, until_fill=False, stages=True):
    """One run. Its files are in the folder, and its report is report.json there."""
    folder.mkdir(parents=True, exist_ok=True)
    command = [program, "convert", scan, folder / "out.step", "--verbose", "--color", "never",
               "--report", folder / "report.json", *arguments]
    if stages:
        command += ["--stages", folder / "stages"]
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL,
                               stderr=subprocess.PIPE, text=True)
    run = Run()
    listener = threading.Thread(target=listen, args=(process, run), daemon=True)
    listener.start()
    watch(process, run, folder, timeout, until_fill, stages)
    listener.join(10)
    return run


def listen(process, run):
    last = 0.0
    for text in process.stderr:
        run.stderr.append(text.rstrip("\n"))
        stage = STAGE.match(text)
        if not stage:
            continue
        now = cpu_s(process.pid, last)
        run.seconds[stage[1]] = float(stage[2])
        run.cpu_s[stage[1]] = now - last
        last = now


def cpu_s(pid, otherwise):
    """The user and system time of all threads of another process so far."""
    try:
        return time.clock_gettime((~pid << 3) | 2)
    except OSError:
        return otherwise


def watch(process, run, folder, timeout, until_fill, stages):
    begun, names = time.monotonic(), {}
    while process.poll() is None:
        if stages:
            hold(folder, names)
        if until_fill and done_with_fill(run, names, stages):
            run.ended = "after the fill"
            break
        if time.monotonic() - begun > timeout:
            run.ended = f"after {timeout:g} s, in the stage after '{last(run)}'"
            break
        time.sleep(LOOK_EVERY_S)
    if run.ended:
        process.send_signal(signal.SIGKILL)
    code = process.wait()
    run.code = None if run.ended else code
    run.filled = filled(folder, names)


def last(run):
    return list(run.seconds)[-1] if run.seconds else "start"


def hold(folder, names):
    """Gives every new file of the stages a second name."""
    held = folder / "held"
    held.mkdir(exist_ok=True)
    for file in (folder / "stages").glob(".scan2step-*.part"):
        if file.name not in names:
            try:
                os.link(file, held / file.name)
                names[file.name] = held / file.name
            except FileNotFoundError:
                pass


def done_with_fill(run, names, stages):
    return "fill" in run.seconds and (not stages or any(map(complete, names.values())))


def complete(file):
    with open(file, "rb") as opened:
        return is_filled(opened.read(1000), file.stat().st_size)


def filled(folder, names):
    published = folder / "stages" / "3-filled.ply"
    return next(filter(complete, filter(Path.exists, [published, *names.values()])), None)
