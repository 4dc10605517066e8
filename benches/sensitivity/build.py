"""Builds the program with constants that can be varied, from a copy of the project."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import constants

ROOT = Path(__file__).resolve().parent.parent.parent
HERE = Path(__file__).resolve().parent

# Cargo.toml names targets in all of these folders.
COPIED = ["Cargo.toml", "Cargo.lock", "README.md", "LICENSE-APACHE", "LICENSE-DEPENDENCIES", "LICENSE-MIT"]
COPIED += ["benches", "docs", "examples", "fixtures", "formats", "python", "src", "tests"]


def program(folder):
    """The path of the built program, and the constants that it can vary, in their order. The sources
    are read once, so that work on them goes on meanwhile."""
    copy = folder / "copy"
    if not copy.exists():
        copy.mkdir(parents=True)
        for name in COPIED:
            source = ROOT / name
            if source.is_dir():
                ignored = shutil.ignore_patterns("target", "pictures", "*.png")
                shutil.copytree(source, copy / name, ignore=ignored)
            else:
                shutil.copy(source, copy / name)
        shutil.copytree(copy / "src", folder / "original/src")
    constants.write(copy / "src/varied.rs", (HERE / "varied.rs").read_text())
    known = folder / "refused.json"
    refused_before = json.loads(known.read_text()) if known.exists() else []
    varied = [c for c in constants.found(folder / "original") if c.key not in refused_before]
    while True:
        constants.rewritten(folder / "original", copy, varied)
        executable, errors = built(copy, folder / "target")
        if executable:
            return executable, varied
        refused = [c for c in varied if is_refused(c, errors, varied)]
        if not refused:
            raise SystemExit("\n".join(e["rendered"] for e in errors))
        print("not variable:", *[c.key for c in refused])
        refused_before += [c.key for c in refused]
        known.write_text(json.dumps(refused_before))
        varied = [c for c in varied if c not in refused]


def built(copy, target):
    """The path of the program, or None and the errors of the compiler."""
    command = ["cargo", "build", "--release", "--bin", "scan2step", "--message-format", "json"]
    command += ["--target-dir", target]
    output = subprocess.run(command, cwd=copy, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    lines = [json.loads(line) for line in output.stdout.splitlines()]
    paths = [line["executable"] for line in lines if line.get("executable")]
    if output.returncode == 0:
        return paths[-1], []
    messages = [line["message"] for line in lines if line["reason"] == "compiler-message"]
    errors = [message for message in messages if message["level"] == "error"]
    return None, errors or [{"rendered": output.stderr.decode(), "spans": []}]


def is_refused(constant, errors, constants):
    """Whether an error of the compiler is at a use of the constant. Its name may be that of another
    constant, which belongs to the file with the error."""
    def is_use(span):
        own = {c.name for c in constants if c.file == span["file_name"]}
        return constant.file == span["file_name"] or constant.name not in own

    return any(
        re.search(rf"\b{constant.name}\b", line["text"]) and is_use(span)
        for error in errors
        for span in error["spans"]
        for line in span["text"]
    )
