#!/usr/bin/env python3
"""Reads an assembly's STEP or IGES file with OpenCASCADE (XCAF) without healing and describes its tree.

    python check_assembly_occ.py FILE

The script prints one JSON object: `products` has the names of all products, and `places` one object for each place of a
part: the path of the names of places, the name of the product, its volume in mm^3, its centre of mass in mm, its colour
(sRGB), the number of its solids, and whether it is valid. `colours` counts the faces that have a colour of their own.
"""

import json
import os
import sys

from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.IGESCAFControl import IGESCAFControl_Reader
from OCP.IFSelect import IFSelect_RetDone
from OCP.Interface import Interface_Static
from OCP.Quantity import Quantity_Color, Quantity_TOC_sRGB
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label, TDF_LabelSequence
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_FACE, TopAbs_SOLID
from OCP.TopExp import TopExp
from OCP.TopLoc import TopLoc_Location
from OCP.TopTools import TopTools_IndexedMapOfShape
from OCP.XCAFDoc import (
    XCAFDoc_ColorGen,
    XCAFDoc_ColorSurf,
    XCAFDoc_ColorTool,
    XCAFDoc_DocumentTool,
    XCAFDoc_ShapeTool,
)


def name_of(label):
    name = TDataStd_Name()
    found = label.FindAttribute(TDataStd_Name.GetID_s(), name)
    return name.Get().ToExtString() if found else None


def colour_of(label):
    colour = Quantity_Color()
    for kind in (XCAFDoc_ColorSurf, XCAFDoc_ColorGen):
        if XCAFDoc_ColorTool.GetColor_s(label, kind, colour):
            return [round(x, 4) for x in colour.Values(Quantity_TOC_sRGB)]
    return None


def members(label):
    found = TDF_LabelSequence()
    XCAFDoc_ShapeTool.GetComponents_s(label, found)
    return [found.Value(i) for i in range(1, found.Length() + 1)]


def count(shape, kind):
    found = TopTools_IndexedMapOfShape()
    TopExp.MapShapes_s(shape, kind, found)
    return found.Extent()


def part(label, path, location, own):
    shape = XCAFDoc_ShapeTool.GetShape_s(label)
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape.Moved(location), properties, 1e-7)
    centre = properties.CentreOfMass()
    return {
        "path": path,
        "product": name_of(label),
        "volume": properties.Mass(),
        "centre": [centre.X(), centre.Y(), centre.Z()],
        "colour": own or colour_of(label) or colour_of_first(label),
        "solids": count(shape, TopAbs_SOLID),
        "valid": BRepCheck_Analyzer(shape).IsValid(),
    }


def colour_of_first(label):
    """IGES has colours on what is in a subfigure."""
    found = TDF_LabelSequence()
    XCAFDoc_ShapeTool.GetSubShapes_s(label, found)
    return next(filter(None, (colour_of(found.Value(i)) for i in range(1, found.Length() + 1))), None)


def places(label, path, location, own=None):
    if XCAFDoc_ShapeTool.IsReference_s(label):
        # The whole of an IGES file is an instance, too.
        of = TDF_Label()
        XCAFDoc_ShapeTool.GetReferredShape_s(label, of)
        return places(of, path, location.Multiplied(XCAFDoc_ShapeTool.GetLocation_s(label)), own)
    if not XCAFDoc_ShapeTool.IsAssembly_s(label):
        return [part(label, path, location, own)]
    found = []
    for member in members(label):
        of = TDF_Label()
        XCAFDoc_ShapeTool.GetReferredShape_s(member, of)
        inner = location.Multiplied(XCAFDoc_ShapeTool.GetLocation_s(member))
        found += places(of, path + [name_of(member)], inner, colour_of(member))
    return found


def face_colours(label):
    found = TDF_LabelSequence()
    XCAFDoc_ShapeTool.GetSubShapes_s(label, found)
    labels = [found.Value(i) for i in range(1, found.Length() + 1)]
    is_face = lambda of: XCAFDoc_ShapeTool.GetShape_s(of).ShapeType() == TopAbs_FACE
    return sum(1 for of in labels if is_face(of) and colour_of(of) is not None)


def main():
    document = TDocStd_Document(TCollection_ExtendedString("XmlXCAF"))
    is_iges = sys.argv[1].lower().endswith((".igs", ".iges"))
    reader = IGESCAFControl_Reader() if is_iges else STEPCAFControl_Reader()
    Interface_Static.SetIVal_s("read.stdsameparameter.mode", 0)
    for switch in (reader.SetNameMode, reader.SetColorMode):
        switch(True)
    # The reader of IGES files prints what it counts.
    output = os.dup(1)
    os.dup2(2, 1)
    read = reader.ReadFile(sys.argv[1]) == IFSelect_RetDone and reader.Transfer(document)
    os.dup2(output, 1)
    if not read:
        sys.exit("cannot be read")
    shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    roots, all_shapes = TDF_LabelSequence(), TDF_LabelSequence()
    shapes.GetFreeShapes(roots)
    shapes.GetShapes(all_shapes)
    labels = [all_shapes.Value(i) for i in range(1, all_shapes.Length() + 1)]
    root = roots.Value(1)
    print(
        json.dumps(
            {
                "roots": roots.Length(),
                "root": name_of(root),
                "products": sorted(name_of(label) or "" for label in labels),
                "places": places(root, [name_of(root)], TopLoc_Location()),
                "face_colours": sum(map(face_colours, labels)),
            }
        )
    )


if __name__ == "__main__":
    main()
