"""The task panel: options, progress, and the result."""

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

from . import convert, feature, legend
from .part_view import PartView
from .worker import Stopped, Worker

TITLES = {
    "tolerance": "Tolerance (mm)",
    "shape": "Shape",
    "holes": "Holes",
    "component": "Component",
    "smooth": "Smoothing",
    "sizes": "Sizes of a part",
    "weld": "Join rims up to (mm)",
    "points": "Points of a mesh",
    "face_count": "Number of faces",
    "handles": "Cut handles up to (mm)",
    "outline": "Outer boundary",
    "rim_tolerance": "Rim tolerance (mm)",
    "fill_only_holes_below": "Fill only holes below (mm)",
    "outliers": "Outliers (%)",
}


class Panel:
    """Converts a scan. With an object, its options come from it and its shape is replaced."""

    def __init__(self, source, obj=None):
        self.source, self.object = source, obj
        self.worker = None
        self.fields = {}
        self.form = QtGui.QWidget()
        self.form.setWindowTitle("Scan to CAD")
        layout = QtGui.QVBoxLayout(self.form)
        layout.addWidget(wrapped(f"{source.Label}: {convert.geometry(source).CountPoints} points"))
        for name in convert.FIRST:
            self.add_field(layout, name)
        more = QtGui.QGroupBox("More")
        more.setCheckable(True)
        more.setChecked(False)
        inner = QtGui.QWidget()
        inner.setVisible(False)
        more.toggled.connect(inner.setVisible)
        QtGui.QVBoxLayout(more).addWidget(inner)
        folded = QtGui.QVBoxLayout(inner)
        for name in convert.OPTIONS:
            if name not in convert.FIRST:
                self.add_field(folded, name)
        layout.addWidget(more)
        self.bar = QtGui.QProgressBar()
        self.bar.setVisible(False)
        self.said = wrapped("")
        self.button = QtGui.QPushButton("Convert")
        self.button.clicked.connect(self.press)
        back = QtGui.QPushButton("Defaults")
        back.clicked.connect(lambda: self.set_values(convert.defaults()))
        self.defaults = back
        row = QtGui.QHBoxLayout()
        row.addWidget(self.button)
        row.addWidget(back)
        layout.addLayout(row)
        layout.addWidget(self.bar)
        layout.addWidget(self.said)
        self.part = PartView()
        layout.addWidget(self.part)
        layout.addStretch(1)
        if obj is not None:
            self.part.show_result(obj)
            self.set_values(feature.values(obj))
            self.fields["tolerance"].setPlaceholderText(f"from the noise: {obj.ToleranceFound.Value:.4g}")

    def add_field(self, layout, name):
        kind, default, told = convert.OPTIONS[name]
        if kind == "App::PropertyEnumeration":
            field = QtGui.QComboBox()
            field.addItems(default)
        elif kind == "App::PropertyLength":
            field = QtGui.QLineEdit()
            field.setPlaceholderText("from the noise" if name == "tolerance" else "automatic")
        else:
            field = QtGui.QSpinBox()
            field.setMaximum(99 if name == "outliers" else default[2])
        field.setToolTip(told)
        label = wrapped(TITLES[name])
        label.setToolTip(told)
        layout.addWidget(label)
        layout.addWidget(field)
        self.fields[name] = field

    def values(self):
        """The values of all fields. A length that is no number is an error with its name."""
        found = {}
        for name, field in self.fields.items():
            if isinstance(field, QtGui.QComboBox):
                found[name] = field.currentText()
            elif isinstance(field, QtGui.QSpinBox):
                found[name] = field.value()
            else:
                found[name] = length(TITLES[name], field.text())
        return found

    def set_values(self, values):
        for name, field in self.fields.items():
            if isinstance(field, QtGui.QComboBox):
                field.setCurrentIndex(field.findText(values[name]))
            elif isinstance(field, QtGui.QSpinBox):
                field.setValue(int(values[name]))
            else:
                field.setText(f"{values[name]:g}" if values[name] else "")

    def press(self):
        if self.worker is not None:
            self.worker.cancel()
            self.said.setText("stopping …")
            return
        try:
            self.chosen = self.values()
        except ValueError as error:
            self.said.setText(str(error))
            return
        view = view_of(self.source.Document)
        if view is not None:
            legend.remove(view, legend.PLACE)
        vertices, faces = convert.arrays(self.source)
        given = convert.arguments(self.chosen)
        self.worker = Worker(vertices, faces, given, self.source.Label, self.form)
        self.worker.progressed.connect(self.progressed)
        self.worker.finished.connect(self.finished)
        self.button.setText("Cancel")
        self.defaults.setEnabled(False)
        self.bar.setVisible(True)
        self.said.setText("")
        self.worker.start()

    def progressed(self, stage, share):
        self.bar.setFormat(f"{stage} %p%")
        self.bar.setValue(int(100 * share))

    def finished(self):
        worker, self.worker = self.worker, None
        self.button.setText("Convert")
        self.defaults.setEnabled(True)
        self.bar.setVisible(False)
        if isinstance(worker.error, Stopped):
            self.said.setText("Stopped. The document has not changed.")
        elif worker.error is not None:
            self.tell_error(worker.error)
        else:
            self.take(worker.result, worker.prepared)

    def take(self, made, prepared):
        document = self.source.Document
        self.object = feature.apply(document, self.source, prepared, self.chosen, self.object)
        if self.source.ViewObject is not None:
            self.source.ViewObject.Visibility = False
        met = "" if made.tolerance_met else ", which some points miss"
        count = len(made.faces)
        faces = "1 face" if count == 1 else f"{count} faces"
        lines = [
            f"A {made.kind} of {faces}.",
            f"Tolerance {made.tolerance:.4g} mm{met}.",
            f"Deviation {made.rms:.4g} mm rms, {made.max:.4g} mm at most.",
        ]
        self.said.setText("\n".join(lines + list(made.hints)))
        self.part.show_result(self.object)

    def tell_error(self, error):
        text, help = str(error), getattr(error, "help", "")
        self.said.setText(f"{text}\n\n{help}" if help else text)
        FreeCAD.Console.PrintError(f"scan2step: {text}\n")
        point, view = getattr(error, "point", None), view_of(self.source.Document)
        if point is not None and view is not None:
            legend.show_place(view, point, 0.01 * convert.geometry(self.source).BoundBox.DiagonalLength)

    # FreeCAD calls these.
    def getStandardButtons(self):
        close = QtGui.QDialogButtonBox.Close
        try:
            return int(close)
        except TypeError:
            return close.value

    def reject(self):
        if self.worker is not None:
            self.worker.cancel()
            self.worker.wait()
        view = view_of(self.source.Document)
        if view is not None:
            legend.remove(view, legend.PLACE)
        FreeCADGui.Control.closeDialog()
        return True


def wrapped(text):
    label = QtGui.QLabel(text)
    label.setWordWrap(True)
    label.setTextInteractionFlags(QtCore.Qt.TextSelectableByMouse)
    return label


def length(title, text):
    """A length in mm. An empty field is 0."""
    text = text.strip()
    if not text:
        return 0.0
    try:
        found = float(FreeCAD.Units.parseQuantity(text if text[-1].isalpha() else f"{text} mm"))
    except (ValueError, OSError):
        raise ValueError(f"{title}: {text!r} is no length") from None
    if not found > 0:
        raise ValueError(f"{title}: {text!r} is not above 0")
    return found


def view_of(document):
    """The 3D view of a document, if it has one."""
    gui = FreeCADGui.getDocument(document.Name)
    view = gui.activeView() if gui is not None else None
    return view if hasattr(view, "getSceneGraph") else None


def open_panel(source, obj=None):
    """Opens the panel for a scan, or for a result."""
    if FreeCADGui.Control.activeDialog():
        FreeCADGui.Control.closeDialog()
    panel = Panel(source, obj)
    FreeCADGui.Control.showDialog(panel)
    return panel
