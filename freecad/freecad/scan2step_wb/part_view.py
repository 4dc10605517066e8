"""The part of the panel that shows exact faces: their kinds, the cylinders, snaps and facets."""

import json

import FreeCADGui
from PySide import QtCore, QtGui

from . import part


class PartView(QtGui.QWidget):
    """It is hidden as long as the result has no exact faces. A row that is chosen selects its faces."""

    def __init__(self):
        super().__init__()
        self.object = None
        self.faces = []
        self.colours = []
        self.paint = QtGui.QCheckBox("Colours by kind")
        self.paint.toggled.connect(self.show_colours)
        layout = QtGui.QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        self.kinds, self.notes = label(), label()
        self.table = QtGui.QTableWidget(0, len(part.COLUMNS))
        self.table.setHorizontalHeaderLabels(part.COLUMNS)
        self.table.setToolTip("Lengths in mm. A row selects its faces.")
        self.table.setSelectionBehavior(QtGui.QAbstractItemView.SelectRows)
        self.table.setEditTriggers(QtGui.QAbstractItemView.NoEditTriggers)
        self.table.setMinimumHeight(150)
        self.table.itemSelectionChanged.connect(self.choose)
        for widget in (self.kinds, self.paint, self.table, self.notes):
            layout.addWidget(widget)
        self.setVisible(False)

    def show_result(self, obj):
        """Shows the exact faces of a result, if it has any."""
        report = json.loads(obj.Report) if obj is not None and obj.Report else {}
        is_exact = part.is_exact(report)
        self.object = obj if is_exact else None
        self.table.setRowCount(0)
        self.setVisible(is_exact)
        if not is_exact:
            return
        rows = part.cylinders(report)
        self.faces = [faces for _, faces in rows]
        self.colours = part.colours(report)
        self.show_colours(self.paint.isChecked())
        self.kinds.setText(part.kinds(report))
        self.notes.setText("\n".join(part.notes(report)))
        self.table.setVisible(bool(rows))
        self.table.setRowCount(len(rows))
        for row, (texts, _) in enumerate(rows):
            for column, text in enumerate(texts):
                item = QtGui.QTableWidgetItem(text)
                self.table.setItem(row, column, item)
        self.table.resizeColumnsToContents()

    def show_colours(self, by_kind):
        """Gives each face the colour of its kind, or all faces that of the shape."""
        view = self.object.ViewObject if self.object is not None else None
        if view is None:
            return
        if by_kind:
            view.DiffuseColor = self.colours
        elif len(view.DiffuseColor) > 1:
            view.DiffuseColor = [view.ShapeColor]

    def choose(self):
        """Selects the faces of the chosen rows in the 3D view."""
        if self.object is None:
            return
        chosen = sorted({index.row() for index in self.table.selectedIndexes()})
        names = [f"Face{face + 1}" for row in chosen for face in self.faces[row]]
        document = self.object.Document.Name
        FreeCADGui.Selection.clearSelection()
        for name in names:
            FreeCADGui.Selection.addSelection(document, self.object.Name, name)


def label():
    made = QtGui.QLabel()
    made.setWordWrap(True)
    made.setTextInteractionFlags(QtCore.Qt.TextSelectableByMouse)
    return made
