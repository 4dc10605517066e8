"""An assembly in a document: each part once, and links to it where the file has it."""

import FreeCAD

from . import convert


def add(document, assembly, label):
    """Adds the parts of a ``scan2step.Assembly`` to a document: a group with each part once, and an ``App::Part`` with
    the tree of the file, whose places are ``App::Link``s. Returns the ``App::Part``."""
    document.openTransaction("Assembly")
    store = document.addObject("App::DocumentObjectGroup", "Parts")
    store.Label = f"{label}: parts"
    features = {}
    for part in assembly.parts:
        if part.error is not None:
            FreeCAD.Console.PrintWarning(f"scan2step: {part.name} is left out: {part.error}\n")
            continue
        feature = document.addObject("Part::Feature", "Shape")
        feature.Shape = convert.shape(part.made)
        # Labels are unique in a document, and those of places are the names in the file.
        feature.Label = f"{part.name}: part"
        store.addObject(feature)
        features[part.number] = feature
        if feature.ViewObject is not None:
            feature.ViewObject.Visibility = False
            if part.colour is not None:
                feature.ViewObject.ShapeColor = rgb(part.colour)
    whole = document.addObject("App::Part", "Assembly")
    whole.Label = label
    made = []
    nodes = assembly.tree
    roots = [node for node in nodes if node.parent is None]
    for node in nodes:
        if node.part is not None:
            made.append(link(document, node, features))
        elif node.parent is None and len(roots) == 1:
            # The root of the file is the whole if it is the only one.
            whole.Label = node.name or label
            made.append(whole)
            continue
        else:
            group = document.addObject("App::Part", "Group")
            group.Label = node.name or "Group"
            made.append(group)
        (whole if node.parent is None else made[node.parent]).addObject(made[-1])
    document.recompute()
    document.commitTransaction()
    return whole


def link(document, node, features):
    """A link to a part in its place."""
    part, place = node.part, node.place
    made = document.addObject("App::Link", "Place")
    made.LinkedObject = features[part.number]
    made.LinkPlacement = FreeCAD.Placement(FreeCAD.Matrix(*place.matrix.ravel()))
    made.Label = node.name or part.name
    if made.ViewObject is not None and place.colour is not None:
        made.ViewObject.OverrideMaterial = True
        made.ViewObject.ShapeMaterial.DiffuseColor = (*rgb(place.colour), 0.0)
    return made


def rgb(colour):
    return tuple(channel / 255 for channel in colour)
