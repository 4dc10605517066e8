"""Conversions as shapes of OpenCASCADE, build123d and CadQuery. Each package is imported on the first call."""

from __future__ import annotations

import io
from typing import Any

from ._conversion import Conversion
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
