#!/usr/bin/env python3
"""Imports what a script of this folder needs once, and then runs scripts, each in a process of its own.

    python serve.py SCRIPT

Each line of the input is a JSON list: the name of a script, and its arguments. The answer is a line with a JSON
object: the status of the script, its output, and what it said besides. A script runs in a fork of this process, so
that the state that it leaves behind, or its crash, does not reach the next one. The server ends with its input.

The import takes a second, most scripts take less.
"""

import gc
import importlib
import json
import os
import runpy
import sys
import tempfile
import traceback

FOLDER = os.path.dirname(os.path.abspath(__file__))


def run(name, arguments):
    """Runs a script as Python does, and returns the status of its end."""
    sys.argv = [os.path.join(FOLDER, name), *arguments]
    try:
        runpy.run_path(sys.argv[0], run_name="__main__")
    except SystemExit as end:
        if end.code is None or isinstance(end.code, int):
            return end.code or 0
        print(end.code, file=sys.stderr)
        return 1
    except BaseException:
        traceback.print_exc()
        return 1
    return 0


def fork(name, arguments, output, said):
    """Runs a script in a fork, and returns the status of its end, which is negative after a signal."""
    process = os.fork()
    if process == 0:
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        os.dup2(output.fileno(), 1)
        os.dup2(said.fileno(), 2)
        status = run(name, arguments)
        sys.stdout.flush()
        sys.stderr.flush()
        # Some of OpenCASCADE's destructors crash at exit, after the work.
        os._exit(status)
    return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])


def text(file):
    file.seek(0)
    return file.read().decode("utf-8", "replace")


def main():
    # Importers print to stdout. Keep the real one for the answers.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    needs = sys.argv[1].removesuffix(".py")
    importlib.import_module(needs)
    # The script itself keeps the output that it finds, so each fork imports it again.
    del sys.modules[needs]
    # The forks share what was imported as long as nobody writes to it.
    gc.freeze()
    for request in sys.stdin:
        name, *arguments = json.loads(request)
        with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as said:
            status = fork(name, arguments, output, said)
            json.dump({"status": status, "output": text(output), "said": text(said)}, answers)
        answers.write("\n")
        answers.flush()


if __name__ == "__main__":
    main()
