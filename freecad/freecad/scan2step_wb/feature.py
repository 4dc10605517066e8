"""The result of a conversion in a document."""

import FreeCAD
import numpy as np

from . import convert
from .stateless import Stateless

#: Figures of a result, each with its type in FreeCAD and what it means.
FIGURES = {
    "Kind": ("App::PropertyString", "face, shell or solid"),
    "ToleranceFound": ("App::PropertyLength", "The tolerance that the result was made for"),
    "ToleranceMet": ("App::PropertyBool", "Whether the result keeps it"),
    "Noise": ("App::PropertyLength", "Standard deviation of the noise of the scan"),
    "Rms": ("App::PropertyLength", "Root mean square deviation of the scan as measured"),
    "Largest": ("App::PropertyLength", "Largest deviation of the scan as measured"),
    "Faces": ("App::PropertyInteger", "The number of faces"),
    "Version": ("App::PropertyString", "The version of scan2step"),
    "Stale": ("App::PropertyBool", "Whether the scan or an option has changed since the conversion"),
    "Deviations": ("App::PropertyFloatList", "The signed deviation of each vertex of the scan in mm; NaN: not on the result"),
    "Report": ("App::PropertyString", "All figures as JSON"),
    "Step": ("App::PropertyString", "The STEP file of the result"),
    "Fingerprint": ("App::PropertyString", "Of the scan and the options of the conversion"),
}

#: What the property editor does not show.
HIDDEN = ("Deviations", "Report", "Step", "Fingerprint")


class ScanResult(Stateless):
    """A ``Part::FeaturePython`` that is converted from a scan.

    A recompute never converts, because that would freeze the window. It marks the object stale.
    """

    def __init__(self, obj):
        obj.Proxy = self
        obj.addProperty("App::PropertyLink", "Source", "Scan", "The mesh or the points of the scan")
        for name, (kind, default, told) in convert.OPTIONS.items():
            obj.addProperty(kind, property_name(name), "Options", told)
            setattr(obj, property_name(name), default)
        for name, (kind, told) in FIGURES.items():
            obj.addProperty(kind, name, "Figures", told)
            obj.setEditorMode(name, 2 if name in HIDDEN else 1)

    def execute(self, obj):
        if not obj.Fingerprint:
            return
        is_stale = obj.Source is None or convert.fingerprint(obj.Source, values(obj)) != obj.Fingerprint
        if obj.Stale != is_stale:
            obj.Stale = is_stale


class ScanObserver:
    """Touches results whose scan changes. FreeCAD does not do so when a mesh is replaced."""

    def slotChangedObject(self, obj, name):
        if name in ("Mesh", "Points") and not getattr(obj.Document, "Restoring", False):
            for user in obj.InList:
                if isinstance(getattr(user, "Proxy", None), ScanResult):
                    user.touch()


FreeCAD.addDocumentObserver(ScanObserver())


def property_name(option):
    """``face_count`` becomes ``FaceCount``."""
    name = "".join(word.capitalize() for word in option.split("_"))
    # An object's own Shape is its result.
    return {"Shape": "TargetShape"}.get(name, name)


def values(obj):
    """The values of an object's options."""
    found = {}
    for name in convert.OPTIONS:
        value = getattr(obj, property_name(name))
        found[name] = value.Value if hasattr(value, "Value") else value
    return found


def apply(document, source, prepared, chosen, obj=None):
    """Puts a conversion into a document in one step that can be undone. Replaces ``obj`` if there is one."""
    document.openTransaction("Scan to CAD")
    try:
        if obj is None:
            obj = document.addObject("Part::FeaturePython", f"{source.Name}_{prepared.kind}")
            ScanResult(obj)
            if FreeCAD.GuiUp:
                from .view import ScanResultView

                ScanResultView(obj.ViewObject)
            obj.Label = f"{source.Label} ({prepared.kind})"
            obj.Source = source
        for name, value in chosen.items():
            setattr(obj, property_name(name), value)
        obj.Shape = prepared.shape
        for name, value in prepared.properties.items():
            setattr(obj, name, value)
        obj.Fingerprint = convert.fingerprint(source, values(obj))
        obj.Stale = False
        document.recompute()
        document.commitTransaction()
    except Exception:
        document.abortTransaction()
        raise
    return obj


def deviations(obj):
    """The signed deviation of each vertex of the scan, in mm."""
    return np.array(obj.Deviations, float)
