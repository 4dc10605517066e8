"""``python -m scan2step convert SCAN OUT...``: the functions of this package from a shell.

The program scan2step has more commands (``batch``) and options. The options here are those of the functions.
"""

from __future__ import annotations

import argparse
import ast
import inspect as signatures
import io
import json
import os
import sys
from typing import Any, Callable, Dict, List, Optional

from . import Scan2StepError, __version__, check, convert, inspect


def main(arguments: Optional[List[str]] = None) -> int:
    """Runs a command. Returns 0, 1 after an error, and 3 if a named tolerance is missed."""
    for stream in (sys.stdout, sys.stderr):
        # A name that a terminal cannot show is no reason to fail.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    given = _parser().parse_args(arguments)
    options = {key: value for key, value in vars(given).items() if value is not None}
    command = options.pop("command")
    try:
        return _run(command, options)
    except BrokenPipeError:
        # Whoever reads the output wants no more.
        sys.stdout = open(os.devnull, "w", encoding="utf-8")
        return 1
    except (Scan2StepError, TypeError, ValueError, OSError) as error:
        help = getattr(error, "help", "see --help")
        print(f"error: {error}", f"help: {help}", sep="\n", file=sys.stderr)
        return 1 if isinstance(error, (Scan2StepError, OSError)) else 2


def _run(command: str, options: Dict[str, Any]) -> int:
    if command == "convert":
        out = options.pop("out")
        made = convert(**options)
        made.write(*out)
        print(made)
        return 0 if made.tolerance_met or "tolerance" not in options else 3
    found = inspect(**options) if command == "inspect" else check(**options)
    print(json.dumps(found, indent=2))
    return 3 if found.get("tolerance_met") is False else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m scan2step")
    parser.add_argument("--version", action="version", version=__version__)
    commands = parser.add_subparsers(dest="command", required=True)
    _command(commands, convert, ["scan", "out"])
    _command(commands, inspect, ["scan"])
    _command(commands, check, ["cad", "scan"])
    return parser


def _command(commands: Any, function: Callable[..., Any], places: List[str]) -> None:
    """A command with an option for each keyword of a function."""
    told = (function.__doc__ or "").splitlines()[0]
    command = commands.add_parser(function.__name__, help=told, description=told)
    for place in places:
        command.add_argument(place, **({"nargs": "+"} if place == "out" else {}))
    for name, parameter in signatures.signature(function).parameters.items():
        if parameter.kind is parameter.KEYWORD_ONLY and name != "progress":
            option = "--" + name.replace("_", "-")
            if parameter.default is False:
                command.add_argument(option, action="store_const", const=True)
            else:
                command.add_argument(option, type=_value, metavar="VALUE")


def _value(text: str) -> Any:
    """A number or a list as Python writes it, else a word. A net may be written as 13x9."""
    sides = text.split("x")
    if len(sides) == 2 and all(side.isdigit() for side in sides):
        return int(sides[0]), int(sides[1])
    try:
        return ast.literal_eval(text)
    except (ValueError, SyntaxError):
        return text


if __name__ == "__main__":
    sys.exit(main())
