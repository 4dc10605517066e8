"""What a file with several parts became."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Dict, List, NamedTuple, Optional, Tuple

from . import _scan2step
from ._conversion import Colour, Conversion, Face, _time_stamp

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Floats = npt.NDArray[np.float64]


class Place(NamedTuple):
    """A place of a part."""

    #: The names of the groups around it, and its own.
    path: Tuple[str, ...]
    #: The rigid map from the part to the whole: (4, 4), in mm.
    matrix: Floats
    #: The colour of this place, from 0 to 255, if it is another one than that of the part.
    colour: Colour


class Part:
    """A part: what its mesh became, once, and where it is. It does not change."""

    def __init__(self, number: int, made: Optional[Conversion], row: Dict[str, Any]) -> None:
        self._number = number
        self._made = made
        self._row = row

    @property
    def number(self) -> int:
        """Its position among the parts."""
        return self._number

    @property
    def name(self) -> str:
        """The name of the product."""
        return str(self._row["name"])

    @property
    def colour(self) -> Colour:
        """The colour, from 0 to 255, if the part has one."""
        return _colour(self._row["colour"])

    @property
    def places(self) -> List[Place]:
        """Where it is."""
        import numpy as np

        def place(row: Dict[str, Any]) -> Place:
            matrix = np.array([*row["matrix"], [0.0, 0.0, 0.0, 1.0]])
            return Place(tuple(row["path"]), matrix, _colour(row.get("colour")))

        return [place(row) for row in self._row["places"]]

    @property
    def made(self) -> Conversion:
        """What its mesh became, in its own frame.

        :raises ValueError: the part could not be converted: see :attr:`error`.
        """
        if self._made is None:
            raise ValueError(f"{self.name} could not be converted: {self.error}")
        return self._made

    @property
    def error(self) -> Optional[str]:
        """Why the part could not be converted. ``None`` if it was."""
        error: Optional[str] = self._row["error"]
        return error

    def __repr__(self) -> str:
        count = len(self._row["places"])
        places = "1 place" if count == 1 else f"{count} places"
        return f"<scan2step.Part {self.name} in {places}: {self._made or self.error}>"


class Node(NamedTuple):
    """A node of the tree of an assembly."""

    #: The position of the node that it is in. ``None`` for a root.
    parent: Optional[int]
    #: Its name. It may be empty.
    name: str
    #: The part that is there. ``None`` for a group, and for the place of a part that could not be converted.
    part: Optional[Part]
    #: The place of the part.
    place: Optional[Place]


class Assembly(Conversion):
    """Parts in their places. It does not change. Lengths are mm.

    What a :class:`Conversion` says of points of the scan, the parts say of theirs.
    """

    def __init__(self, made: _scan2step.Assembly, name: str) -> None:
        self._assembly = made
        self._name = name
        self._report: Dict[str, Any] = json.loads(made.report_json())

    @property
    def kind(self) -> str:
        """``"assembly"``."""
        return "assembly"

    @property
    def parts(self) -> List[Part]:
        """The parts, in the order in which the file places them first."""

        def part(number: int, row: Dict[str, Any]) -> Part:
            made = self._assembly.part(number)
            return Part(number, None if made is None else Conversion(made, row["name"]), row)

        return [part(number, row) for number, row in enumerate(self._report["parts"])]

    @property
    def tree(self) -> List[Node]:
        """The tree of the file: parents come before their children."""
        parts = self.parts

        def node(row: Tuple[Optional[int], str, Optional[List[int]]]) -> Node:
            parent, name, at = row
            if at is None:
                return Node(parent, name, None, None)
            part = parts[at[0]]
            return Node(parent, name, part, part.places[at[1]])

        return [node(row) for row in self._assembly.nodes]

    def _each(self) -> List[Conversion]:
        return [part.made for part in self.parts if part.error is None]

    @property
    def faces(self) -> List[Face]:
        """The faces of all parts, each part once and in its own frame."""
        return [face for made in self._each() for face in made.faces]

    def _bodies(self) -> List[Dict[str, Any]]:
        return [body for made in self._each() for body in made._bodies()]

    @property
    def tolerance(self) -> float:
        """The largest tolerance of a part."""
        return max(made.tolerance for made in self._each())

    @property
    def tolerance_met(self) -> bool:
        """Whether all parts keep their tolerances."""
        return all(made.tolerance_met for made in self._each())

    @property
    def noise(self) -> float:
        """The largest noise of a part."""
        return max(made.noise for made in self._each())

    @property
    def rms(self) -> float:
        """The largest root mean square deviation of a part."""
        return max(made.rms for made in self._each())

    @property
    def max(self) -> float:
        """The largest deviation of a part."""
        return max(made.max for made in self._each())

    @property
    def volume(self) -> Optional[float]:
        """The volume of all parts in all places in mm³, if all are solids."""
        whole = 0.0
        for part in self.parts:
            if part.error is None:
                volume = part.made.volume
                if volume is None:
                    return None
                whole += volume * len(part.places)
        return whole

    @property
    def area(self) -> float:
        """The area of all parts in all places in mm²."""
        return sum(part.made.area * len(part.places) for part in self.parts if part.error is None)

    @property
    def origin(self) -> Tuple[float, float, float]:
        """Zero: parts are placed where the file has them."""
        return 0.0, 0.0, 0.0

    @property
    def hints(self) -> List[str]:
        """What could be better, and what to do about it."""
        return self._assembly.hints

    @property
    def report(self) -> Dict[str, Any]:
        """All figures, as the program's ``--report FILE.json`` has them."""
        report: Dict[str, Any] = json.loads(self._assembly.report_json())
        return report

    def _report_json(self) -> str:
        return self._assembly.report_json()

    @property
    def deviations(self) -> Floats:
        """Those of a part are in ``assembly.parts[n].made.deviations``.

        :raises ValueError: always.
        """
        raise ValueError("each part has the deviations of its own mesh: assembly.parts[0].made.deviations")

    @property
    def smoothed_deviations(self) -> Floats:
        """Those of a part are in ``assembly.parts[n].made.smoothed_deviations``.

        :raises ValueError: always.
        """
        raise ValueError("each part has the deviations of its own mesh: assembly.parts[0].made.smoothed_deviations")

    def distance(self, points: Any) -> Floats:
        """The distances of points (k, 3) from the nearest part in its place: (k,), in mm."""
        import numpy as np

        rows = np.asarray(points, float).reshape(-1, 3)
        nearest = np.full(len(rows), np.inf)
        for part in self.parts:
            if part.error is None:
                for place in part.places:
                    turn, shift = place.matrix[:3, :3], place.matrix[:3, 3]
                    nearest = np.minimum(nearest, part.made.distance((rows - shift) @ turn))
        return nearest

    def step(self, schema: str = "ap242", colour: Colour = None) -> bytes:
        """The STEP file: the same bytes as the program writes.

        :param schema: ``"ap203"``, ``"ap214"`` or ``"ap242"``.
        :param colour: no effect: parts have their own.
        """
        return self._assembly.step(schema, _time_stamp())

    def iges(self, form: str = "trimmed", colour: Colour = None, file_name: str = "") -> bytes:
        """The IGES file.

        :param form: ``"trimmed"`` for trimmed surfaces (144), ``"brep"`` for shells and solids.
        :param colour: no effect: parts have their own.
        :param file_name: the name that the file says it has.
        """
        return self._assembly.iges(form, _time_stamp(), file_name)

    def html(self) -> str:
        """The report as a page that needs nothing else."""
        return self._assembly.html()

    def png(self) -> bytes:
        """The picture of the report: 1600 × 1000 pixels."""
        return self._assembly.png()

    def to_build123d(self) -> Any:
        """The result as a ``Compound`` of build123d with the tree of the file as its children, with labels and colours.

        A part is made once, and its places share it.
        """
        from .occ import assembly_to_build123d

        return assembly_to_build123d(self)

    def to_cadquery(self) -> Any:
        """The result as an ``Assembly`` of CadQuery, with names and colours. A part is made once, and its places share it."""
        from .occ import assembly_to_cadquery

        return assembly_to_cadquery(self)

    def __repr__(self) -> str:
        parts = self._report["parts"]
        places = sum(len(row["places"]) for row in parts)
        return f"<scan2step.Assembly {self._name}: {len(parts)} parts in {places} places>"

    def __reduce__(self) -> Any:
        raise TypeError("an Assembly cannot be pickled: return step() and report")


def _colour(row: Any) -> Colour:
    return None if row is None else (row[0], row[1], row[2])
