"""Conversions as shapes of OpenCASCADE, build123d and CadQuery. Each package is imported on the first call."""

from __future__ import annotations

import io
from typing import Any, Callable, Dict, List, NamedTuple

from ._assembly import Assembly, Place
from ._conversion import Colour, Conversion
from ._errors import InternalError


def to_occ(made: Conversion) -> Any:
    """A ``TopoDS_Shape`` of OCP: a face if there is one face alone, a shell, a solid or a compound."""
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.STEPControl import STEPControl_Reader
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer

    reader = STEPControl_Reader()
    status = reader.ReadStream("scan2step", io.BytesIO(made.step()))
    if status != IFSelect_RetDone:
        raise InternalError("OpenCASCADE does not read the STEP file", "please report it")
    reader.TransferRoots()
    shape = reader.OneShape()
    if made.kind == "face" and len(made.faces) == 1:
        return TopExp_Explorer(shape, TopAbs_FACE).Current()
    return shape


def to_build123d(made: Conversion) -> Any:
    """A ``Face``, ``Shell``, ``Solid`` or ``Compound`` of build123d."""
    import build123d

    return build123d.Shape.cast(to_occ(made)) if hasattr(build123d.Shape, "cast") else build123d.Compound.cast(to_occ(made))


def to_cadquery(made: Conversion) -> Any:
    """A ``Face``, ``Shell``, ``Solid`` or ``Compound`` of CadQuery."""
    import cadquery

    return cadquery.Shape.cast(to_occ(made))


def _located(shape: Any, place: Place) -> Any:
    """A ``TopoDS_Shape`` in a place. It shares the shape of the part."""
    from OCP.gp import gp_Trsf
    from OCP.TopLoc import TopLoc_Location

    motion = gp_Trsf()
    motion.SetValues(*(float(x) for row in place.matrix[:3] for x in row))
    return shape.Located(TopLoc_Location(motion))


class _Branch(NamedTuple):
    """A group with its children, or the shape of a part in its place with its colour."""

    name: str
    children: List["_Branch"]
    shape: Any
    colour: Colour


def _tree(assembly: Assembly) -> _Branch:
    """The tree of an assembly. Its root is that of the file, if there is one alone. Groups without parts are left out."""
    shapes: Dict[int, Any] = {}
    branches: List[_Branch] = []
    whole = _Branch(assembly._name, [], None, None)
    nodes = assembly.tree
    for node in nodes:
        shape, colour = None, None
        if node.part is not None and node.place is not None:
            key = id(node.part)
            if key not in shapes:
                shapes[key] = to_occ(node.part.made)
            shape, colour = _located(shapes[key], node.place), node.place.colour or node.part.colour
        branches.append(_Branch(node.name, [], shape, colour))
    for node, branch in reversed(list(zip(nodes, branches))):
        if branch.shape is not None or branch.children:
            into = whole if node.parent is None else branches[node.parent]
            into.children.insert(0, branch)
    alone = len(whole.children) == 1 and whole.children[0].shape is None
    return whole.children[0] if alone else whole


def assembly_to_build123d(assembly: Assembly) -> Any:
    """A ``Compound`` of build123d with children."""
    import build123d

    cast: Callable[[Any], Any] = build123d.Shape.cast if hasattr(build123d.Shape, "cast") else build123d.Compound.cast

    def made(branch: _Branch) -> Any:
        if branch.shape is None:
            return build123d.Compound(label=branch.name, children=[made(child) for child in branch.children])
        shape = cast(branch.shape)
        shape.label = branch.name
        if branch.colour is not None:
            shape.color = build123d.Color(*(channel / 255 for channel in branch.colour))
        return shape

    return made(_tree(assembly))


def assembly_to_cadquery(assembly: Assembly) -> Any:
    """An ``Assembly`` of CadQuery. Names that come again get a number, because they must differ there."""
    import cadquery

    taken: Dict[str, int] = {}

    def unique(name: str) -> str:
        taken[name] = taken.get(name, 0) + 1
        return name if taken[name] == 1 else unique(f"{name} ({taken[name]})")

    def made(branch: _Branch) -> Any:
        into = cadquery.Assembly(name=unique(branch.name))
        for child in branch.children:
            if child.shape is None:
                into.add(made(child))
                continue
            colour = child.colour and cadquery.Color(*(channel / 255 for channel in child.colour))
            into.add(cadquery.Shape.cast(child.shape), name=unique(child.name), color=colour)
        return into

    return made(_tree(assembly))
