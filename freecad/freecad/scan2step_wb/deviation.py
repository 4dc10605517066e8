"""The deviation as colours on a copy of the scan's mesh."""

import numpy as np

from . import feature

#: Blue below, white at zero, red above.
SCALE = np.array([(0.13, 0.27, 0.62), (0.55, 0.70, 0.90), (0.90, 0.90, 0.88), (0.93, 0.62, 0.51), (0.62, 0.11, 0.17)])

#: The colour of vertices that are not on the result.
GREY = (0.5, 0.5, 0.5)

#: The share of vertices within the ends of the scale.
WITHIN = 98


def scale_end(deviations):
    """The deviation at the end of the scale."""
    known = np.abs(deviations[~np.isnan(deviations)])
    return float(np.percentile(known, WITHIN)) if known.size and known.max() > 0 else 1.0


def colours(deviations, end):
    """A colour for each vertex: (n, 3), from 0 to 1."""
    share = np.clip(0.5 + 0.5 * np.nan_to_num(deviations) / end, 0.0, 1.0)
    steps = np.linspace(0.0, 1.0, len(SCALE))
    painted = np.stack([np.interp(share, steps, SCALE[:, k]) for k in range(3)], axis=1)
    painted[np.isnan(deviations)] = GREY
    return painted


def show(document, result):
    """Adds a coloured copy of the scan to a document. Returns the copy and the end of its scale."""
    found = feature.deviations(result)
    end = scale_end(found)
    document.openTransaction("Deviation colours")
    copy = document.addObject("Mesh::Feature", f"{result.Name}_deviation")
    copy.Mesh = result.Source.Mesh.copy()
    copy.Label = f"{result.Label}: deviation ±{end:.3g} mm"
    copy.addProperty("App::PropertyColorList", "VertexColors", "Deviation", "A colour for each vertex")
    copy.addProperty("App::PropertyFloatList", "Millimetres", "Deviation", "The deviation of each vertex")
    copy.addProperty("App::PropertyFloat", "ScaleEnd", "Deviation", "The deviation at the end of the scale in mm")
    copy.VertexColors = [tuple(map(float, colour)) for colour in colours(found, end)]
    copy.Millimetres = found.tolist()
    copy.ScaleEnd = end
    document.recompute()
    if copy.ViewObject is not None:
        copy.ViewObject.Coloring = True
        result.ViewObject.Visibility = False
        result.Source.ViewObject.Visibility = False
    document.commitTransaction()
    return copy, end
