"""What this package raises."""

from __future__ import annotations

from typing import Optional, Tuple


#: Options that have another name in the library.
_OPTIONS = {
    "unit": "units",
    "cut": "fill_only_holes_below",
    "within": "box",
    "without_plane": "remove_plane",
    "faces": "face_count",
    "scan": "scan_number",
}


class Scan2StepError(Exception):
    """Why a scan could not be read, converted or written.

    ``str(error)`` says what is wrong, and :attr:`help` what to do.
    """

    help: str
    #: The place in mm that the error is about, if it has one.
    point: Optional[Tuple[float, float, float]]
    #: The option that the error is about.
    option: Optional[str]

    def __init__(
        self,
        message: str,
        help: str = "",
        *,
        point: Optional[Tuple[float, float, float]] = None,
        option: Optional[str] = None,
        hole: Optional[int] = None,
        path: Optional[str] = None,
        place: Optional[str] = None,
    ) -> None:
        super().__init__(message)
        for name, own in _OPTIONS.items():
            help = help.replace(f"`{name}`", f"`{own}`")
        self.help = help
        self.point = point
        self.option = _OPTIONS.get(option, option) if option else None
        self.hole = hole
        self.path = path
        self.place = place


class FileError(Scan2StepError):
    """A file cannot be read or written. ``path`` and ``place`` say where."""


class OptionError(Scan2StepError, ValueError):
    """An option has a value that cannot be. ``option`` names it."""


class ScanError(Scan2StepError, ValueError):
    """A scan cannot be converted. ``point`` is the place in mm, if there is one."""


class TopologyError(ScanError):
    """The scan has one side, or is no disk with holes where a face was asked for."""


class TrimError(ScanError):
    """A trim loop crosses itself or another one. ``hole`` is the number of its hole."""


class FillError(ScanError):
    """A hole cannot be filled."""


class MemoryBoundError(Scan2StepError):
    """The conversion may need more memory than ``max_memory`` allows."""


class InternalError(Scan2StepError):
    """A fault of scan2step itself. Please report it."""
