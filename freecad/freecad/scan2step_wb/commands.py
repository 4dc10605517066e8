"""The commands of the menu."""

import os

import FreeCAD
import FreeCADGui
import scan2step
from PySide import QtGui

from . import assembly, convert, deviation, feature, legend, panel, part
from .view import ICONS
from .worker import FileWorker


def selected(kind):
    """The selected object of a kind: "scan" or "result". ``None`` unless there is exactly one."""
    chosen = FreeCADGui.Selection.getSelection()
    if kind == "scan":
        fitting = [obj for obj in chosen if convert.is_scan(obj)]
    else:
        fitting = [obj for obj in chosen if is_result(obj)]
    return fitting[0] if len(fitting) == 1 else None


def is_result(obj):
    return hasattr(obj, "Fingerprint") and hasattr(obj, "Deviations")


class Command:
    """A command. ``kind`` says what has to be selected."""

    kind = "scan"
    icon = "scan2step.svg"

    def GetResources(self):
        return {"MenuText": self.title, "ToolTip": self.told, "Pixmap": os.path.join(ICONS, self.icon)}

    def IsActive(self):
        return selected(self.kind) is not None

    def Activated(self, index=0):
        self.run(selected(self.kind))


class Convert(Command):
    name, title = "Scan2Step_Convert", "Scan to face or solid …"
    told = "Convert the selected mesh or cloud of points to a B-spline face, a shell or a solid"

    def run(self, source):
        panel.open_panel(source)


class Inspect(Command):
    name, title = "Scan2Step_Inspect", "Inspect scan"
    told = "Say what the selected mesh or cloud is, and what a conversion makes of it"

    def run(self, source):
        vertices, faces = convert.arrays(source)
        try:
            found = scan2step.inspect(vertices, faces)
        except scan2step.Scan2StepError as error:
            show(f"{error}\n{error.help}")
            return
        show(inspection(source.Label, found))


class Colours(Command):
    name, title = "Scan2Step_Deviation", "Deviation colours"
    told = "Show the deviation of the scan from the selected result in colours"
    kind = "result"

    def run(self, result):
        if not result.Source.isDerivedFrom("Mesh::Feature"):
            show("Deviation colours need a mesh. The scan of this result is a cloud of points.")
            return
        _, end = deviation.show(result.Document, result)
        view = panel.view_of(result.Document)
        if view is not None:
            legend.show_legend(view, end)


class HideLegend(Command):
    name, title = "Scan2Step_HideLegend", "Hide the legend"
    told = "Remove the legend of the deviation colours"

    def IsActive(self):
        return FreeCAD.ActiveDocument is not None

    def Activated(self, index=0):
        view = panel.view_of(FreeCAD.ActiveDocument)
        if view is not None:
            legend.remove(view, legend.LEGEND)


class Check(Command):
    name, title = "Scan2Step_Check", "Check against the scan"
    told = "Measure the selected result against its scan in both directions"
    kind = "result"

    def run(self, result):
        vertices, faces = convert.arrays(result.Source)
        found = scan2step.check(result.Step.encode(), vertices, faces)
        lines = [result.Label]
        for title, key in (("scan to result", "scan_to_face"), ("result to scan", "face_to_scan")):
            d = found[key]
            lines.append(f"{title}: rms {d['rms_mm']:.4g} mm, largest {d['max_mm']:.4g} mm")
        show("\n".join(lines))


class Export(Command):
    name, title = "Scan2Step_Export", "Export STEP …"
    told = "Write the STEP file of the selected result, as scan2step made it"
    kind = "result"

    def run(self, result):
        path, _ = QtGui.QFileDialog.getSaveFileName(None, self.title, f"{result.Label}.step", "STEP (*.step *.stp)")
        if path:
            export(result, path)


class Assembly(Command):
    name, title = "Scan2Step_Assembly", "Import an assembly …"
    told = "Convert the parts of a glTF, 3MF, OBJ or STL file, each once, and place them as in the file"
    worker = None

    def IsActive(self):
        return Assembly.worker is None

    def Activated(self, index=0):
        kinds = "Files with parts (*.glb *.gltf *.3mf *.obj *.stl)"
        path, _ = QtGui.QFileDialog.getOpenFileName(None, self.title, "", kinds)
        if path:
            begin_assembly(path)


def begin_assembly(path):
    """Converts a file in a thread of its own. The parts come into the document when it has finished."""
    worker = Assembly.worker = FileWorker(path, FreeCADGui.getMainWindow())
    worker.finished.connect(end_assembly)
    FreeCADGui.getMainWindow().statusBar().showMessage(f"scan2step converts the parts of {path} …")
    worker.start()
    return worker


def end_assembly():
    worker, Assembly.worker = Assembly.worker, None
    FreeCADGui.getMainWindow().statusBar().clearMessage()
    if worker.error is not None:
        show(f"{worker.error}\n{getattr(worker.error, 'help', '')}")
    elif worker.result.kind != "assembly":
        show("The file has no parts: import its mesh, and convert that.")
    else:
        label = os.path.splitext(os.path.basename(worker.path))[0]
        document = FreeCAD.ActiveDocument or FreeCAD.newDocument(label)
        assembly.add(document, worker.result, label)


def export(result, path):
    """Writes the bytes that scan2step made."""
    with open(path, "wb") as file:
        file.write(result.Step.encode())


def inspection(label, found):
    """What ``inspect`` found, as text."""
    low, high = found["bounds_mm"]
    size = " × ".join(f"{b - a:.4g}" for a, b in zip(low, high))
    faces = found["faces_about"]
    becomes = found["shape"] or "nothing"
    lines = [
        label,
        f"{found['vertices']} points, {found['triangles']} triangles, {size} mm",
        f"{found['components']} components; this one has genus {found['genus']} and {found['boundary_loops']} boundary loops",
        f"noise {found['noise_mm']:.4g} mm",
        f"becomes a {becomes}" + (f" of about {faces} faces" if faces else ""),
    ]
    if found["exact"]:
        lines[-1] += " of exact faces: " + part.kinds({"shape": found["exact"]})
    for handle in found["handles"][:12]:
        x, y, z = handle["at"]
        lines.append(f"handle, about {handle['length_mm']:.4g} mm around, near ({x:.3f}, {y:.3f}, {z:.3f})")
    return "\n".join(lines)


def show(text):
    """Shows a text in the report view and in a window that does not block."""
    FreeCAD.Console.PrintMessage(text + "\n")
    box = QtGui.QMessageBox(FreeCADGui.getMainWindow())
    box.setWindowTitle("scan2step")
    box.setText(text)
    box.setModal(False)
    box.show()
    return box


COMMANDS = [Convert, Assembly, Inspect, Colours, HideLegend, Check, Export]


def register():
    for command in COMMANDS:
        FreeCADGui.addCommand(command.name, command())
