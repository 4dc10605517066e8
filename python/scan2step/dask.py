"""One scan as one task of Dask, Ray or any other engine.

A task may run twice or be killed at any time: its files appear whole or not at all, and are the same
bytes whoever makes them. So the engine's retries mean machines, and never scans.
"""

from __future__ import annotations

import hashlib
import json
import os
from typing import Any, Dict, Optional

from . import __version__, convert
from ._errors import Scan2StepError
from ._scan import Path


def convert_file(path: Path, out: Path, *, threads: int = 1, **options: Any) -> Dict[str, Any]:
    """Converts one scan to one CAD file, and returns a row of figures.

    The row is also written beside ``out``, as ``NAME.row.json``. A scan whose row has the same content,
    options and version is not converted again, if its file is still there.

    A scan that cannot be converted is no exception, because no second try helps it: its row has
    ``status`` ``"failed"``, ``error`` and ``help``.

    :param path: the scan.
    :param out: the CAD file. Its folder is made if it is missing.
    :param threads: how many threads a scan gets. Engines have a worker for each core.
    :param options: those of :func:`scan2step.convert`.
    :returns: ``file``, ``out``, ``status`` (``"ok"``, ``"missed"`` or ``"failed"``), and the figures:
        ``shape``, ``faces``, ``tolerance_mm``, ``rms_mm``, ``max_mm``, ``sha256``; or ``error``, ``help``.
    """
    path, out = os.fsdecode(path), os.fsdecode(out)
    row: Dict[str, Any] = {"file": path, "out": out}
    try:
        key = _key(path, options)
        known = _known(out, key)
        if known is not None:
            return {**known, **row}
        os.makedirs(os.path.dirname(os.path.abspath(out)), exist_ok=True)
        made = convert(path, threads=threads, **options)
        made.write(out)
        row.update(
            status="ok" if made.tolerance_met else "missed",
            shape=made.kind,
            faces=len(made.faces),
            tolerance_mm=made.tolerance,
            rms_mm=made.rms,
            max_mm=made.max,
            sha256=_sha256(out),
            key=key,
        )
        _write(out + ".row.json", json.dumps(row, indent=1))
    except (Scan2StepError, OSError) as error:
        help = error.help if isinstance(error, Scan2StepError) else "check the path"
        return {"file": path, "out": out, "status": "failed", "error": str(error), "help": help}
    return row


def _key(path: str, options: Dict[str, Any]) -> str:
    """What a result depends on."""
    # The part is named by the file.
    name = os.path.basename(path)
    told = json.dumps([_sha256(path), name, options, __version__], sort_keys=True, default=_plain)
    return hashlib.sha256(told.encode()).hexdigest()


def _known(out: str, key: str) -> Optional[Dict[str, Any]]:
    """The row of an earlier run, if its file is still what it was."""
    try:
        with open(out + ".row.json", encoding="utf-8") as file:
            row: Dict[str, Any] = json.load(file)
        return row if row["key"] == key and _sha256(out) == row["sha256"] else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _plain(value: Any) -> Any:
    """Arrays and numbers of numpy as lists and numbers of Python."""
    return value.tolist() if hasattr(value, "tolist") else repr(value)


def _sha256(path: str) -> str:
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def _write(path: str, text: str) -> None:
    temporary = f"{path}.{os.getpid()}.part"
    try:
        with open(temporary, "w", encoding="utf-8") as file:
            file.write(text)
        os.replace(temporary, path)
    except OSError:
        if os.path.exists(temporary):
            os.unlink(temporary)
        raise
