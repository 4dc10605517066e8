"""How the result of a conversion looks in the tree."""

import os

from .stateless import Stateless

ICONS = os.path.join(os.path.dirname(__file__), "resources", "icons")


class ScanResultView(Stateless):
    """The view of a :class:`feature.ScanResult`. A double click opens the panel."""

    def __init__(self, view):
        view.Proxy = self

    def attach(self, view):
        self.object = view.Object

    def getIcon(self):
        stale = getattr(getattr(self, "object", None), "Stale", False)
        return os.path.join(ICONS, "stale.svg" if stale else "scan2step.svg")

    def updateData(self, obj, name):
        if name == "Stale" and obj.ViewObject is not None:
            obj.ViewObject.signalChangeIcon()

    def doubleClicked(self, view):
        from . import panel

        panel.open_panel(view.Object.Source, view.Object)
        return True
