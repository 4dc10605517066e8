"""Tests of the addon with a window: clicks lead from a mesh to a face, and from a body to a solid.

    FREECAD_SCREENS=FOLDER freecad -M freecad freecad/TestScan2StepGui.py

The pictures of each step go to the folder. The exit code is 0 if all is well.
"""

import os
import sys
import tempfile
import time
import traceback

import FreeCAD
import FreeCADGui
import Mesh
from PySide import QtCore, QtGui

HERE = os.path.dirname(os.path.abspath(__file__))
SCREENS = os.environ.get("FREECAD_SCREENS")

#: A conversion of a fixture takes two seconds; a busy machine may need more.
DEADLINE = 180.0


def wait(until, what):
    """Runs the window until something is true. Returns the longest time that it stood still."""
    begin = last = time.monotonic()
    longest = 0.0
    while not until():
        QtGui.QApplication.processEvents(QtCore.QEventLoop.AllEvents, 10)
        now = time.monotonic()
        longest, last = max(longest, now - last), now
        assert now - begin < DEADLINE, f"{what}: not in time"
        time.sleep(0.005)
    return longest


def picture(name):
    """Keeps a picture of the window, with the 3D view in it."""
    for _ in range(20):
        QtGui.QApplication.processEvents()
        time.sleep(0.01)
    if not SCREENS:
        return
    window = FreeCADGui.getMainWindow()
    screen = QtGui.QApplication.primaryScreen()
    shot = screen.grabWindow(0, window.x(), window.y(), window.width(), window.height())
    shot.save(os.path.join(SCREENS, f"{name}.png"))


def document(name):
    made = FreeCAD.newDocument("gui")
    source = made.addObject("Mesh::Feature", "scan")
    source.Mesh = Mesh.Mesh(os.path.join(HERE, "..", "fixtures", name))
    made.recompute()
    FreeCADGui.activeDocument().activeView().viewIsometric()
    FreeCADGui.SendMsgToActiveView("ViewFit")
    FreeCADGui.Selection.clearSelection()
    FreeCADGui.Selection.addSelection(source)
    return made, source


def menu():
    bar = FreeCADGui.getMainWindow().menuBar()
    return next(action.menu() for action in bar.actions() if action.text() == "scan2step")


def click(title):
    """Clicks an entry of the menu."""
    entries = menu()
    entries.aboutToShow.emit()
    action = next(action for action in entries.actions() if action.text().startswith(title))
    assert action.isEnabled(), f"{title} is disabled"
    action.trigger()


def button(panel, title):
    found = [b for b in panel.form.findChildren(QtGui.QPushButton) if b.text() == title]
    assert found, f"no button {title}"
    return found[0]


def scroll_to(widget):
    """Moves the panel so that a widget is in sight."""
    for _ in range(5):
        QtGui.QApplication.processEvents()
    area = widget.parent()
    while area is not None and not isinstance(area, QtGui.QScrollArea):
        area = area.parent()
    if area is not None:
        area.ensureWidgetVisible(widget)


def opened():
    from freecad.scan2step_wb import panel

    opened = []
    original = panel.open_panel
    panel.open_panel = lambda *given: opened.append(original(*given))
    try:
        click("Scan to face or solid")
    finally:
        panel.open_panel = original
    return opened[0]


def test_a_face():
    made, source = document("relief.ply")
    picture("1-mesh")
    panel = opened()
    panel.fields["tolerance"].setText("0.5")
    picture("2-panel")
    button(panel, "Convert").click()
    pause = wait(lambda: panel.worker is None, "a face")
    print(f"longest pause of the window while a face was made: {pause:.3f} s")
    assert panel.object is not None, panel.said.text()
    assert panel.object.Shape.ShapeType == "Face" and panel.object.ToleranceMet
    picture("3-face")
    assert panel.form.minimumSizeHint().width() <= 250, "the panel fits into a narrow column"
    panel.reject()
    FreeCADGui.Selection.clearSelection()
    FreeCADGui.Selection.addSelection(panel.object)
    click("Deviation colours")
    picture("4-deviation")
    from freecad.scan2step_wb import legend, panel as panels

    assert legend.remove(panels.view_of(made), legend.LEGEND)
    FreeCAD.closeDocument(made.Name)


def test_a_solid():
    made, source = document("ring.obj")
    panel = opened()
    before = len(made.Objects)
    button(panel, "Convert").click()
    wait(lambda: panel.bar.text().startswith("layout"), "the layout begins")
    begin = time.monotonic()
    button(panel, "Cancel").click()
    wait(lambda: panel.worker is None, "cancelled")
    seconds = time.monotonic() - begin
    print(f"cancelled in {seconds:.3f} s")
    assert seconds < 1.5 and len(made.Objects) == before and "Stopped" in panel.said.text()
    button(panel, "Convert").click()
    pause = wait(lambda: panel.worker is None, "a solid")
    print(f"longest pause of the window while a solid was made: {pause:.3f} s")
    assert panel.object.Shape.ShapeType == "Solid", panel.said.text()
    picture("5-solid")
    panel.fields["face_count"].setValue(30)
    button(panel, "Convert").click()
    wait(lambda: panel.worker is None, "a solid of fewer faces")
    assert len(made.Objects) == before + 1, "the result is replaced"
    made.undo()
    panel.reject()
    FreeCAD.closeDocument(made.Name)


def test_a_part():
    made, source = document("bracket.stl")
    panel = opened()
    assert panel.part.isHidden()
    button(panel, "Convert").click()
    wait(lambda: panel.worker is None, "a part")
    assert not panel.part.isHidden(), panel.said.text()
    assert "5 cylinders" in panel.part.kinds.text()
    table = panel.part.table
    rows = [[table.item(row, column).text() for column in range(3)] for row in range(table.rowCount())]
    assert rows[1] == ["bore", "9", "x"] and len(rows) == 5, rows
    table.selectRow(1)
    (chosen,) = FreeCADGui.Selection.getSelectionEx()
    (face,) = chosen.SubObjects
    assert chosen.Object is panel.object and abs(face.Surface.Radius - 9.0) < 1e-6
    assert panel.form.minimumSizeHint().width() <= 250, "the panel fits into a narrow column"
    panel.part.paint.setChecked(True)
    colours = panel.object.ViewObject.DiffuseColor
    assert len(colours) == 15 and len(set(colours)) == 4, "a colour for each of four kinds"
    scroll_to(panel.part.notes)
    picture("7-part")
    panel.part.paint.setChecked(False)
    assert len(set(panel.object.ViewObject.DiffuseColor)) == 1
    result = panel.object
    panel.reject()
    from freecad.scan2step_wb import commands, convert, panel as panels

    said = commands.inspection("part", __import__("scan2step").inspect(*convert.arrays(source)))
    assert "of exact faces: 7 planes, 5 cylinders, 2 cones, 1 torus" in said, said
    again = panels.open_panel(source, result)
    assert not again.part.isHidden() and again.part.table.rowCount() == 5
    again.reject()
    FreeCAD.closeDocument(made.Name)


def test_an_error_shows_its_place():
    made, source = document("relief.ply")
    panel = opened()
    panel.fields["tolerance"].setText("none")
    button(panel, "Convert").click()
    assert "is no length" in panel.said.text()
    panel.fields["tolerance"].setText("")
    panel.fields["component"].setValue(9)
    button(panel, "Convert").click()
    wait(lambda: panel.worker is None, "an error")
    assert "no component 9" in panel.said.text() and "only one" in panel.said.text()
    button(panel, "Defaults").click()
    assert panel.values() == __import__("freecad.scan2step_wb.convert", fromlist=["x"]).defaults()
    import scan2step
    from freecad.scan2step_wb import legend, panel as panels

    panel.tell_error(scan2step.ScanError("the map folds", "repair it", point=(0.0, 0.0, 5.0)))
    picture("6-error")
    assert legend.remove(panels.view_of(made), legend.PLACE), "the place is marked"
    panel.reject()
    FreeCAD.closeDocument(made.Name)


def leaves(item, outer):
    """The shapes below an object in their places, each with its colour."""
    placement = outer.multiply(item.Placement)
    if item.TypeId == "App::Part":
        return [leaf for child in item.Group for leaf in leaves(child, placement)]
    shape = item.Shape.copy()
    shape.Placement = placement
    return [(shape, item.ViewObject.ShapeColor[:3])]


def test_the_file_of_an_assembly_opens():
    """FreeCAD 0.20 reads no file of an assembly without a window: it crashes on OpenCASCADE's own ones, too."""
    import ImportGui
    import scan2step
    from freecad.scan2step_wb import convert

    made = scan2step.convert(os.path.join(HERE, "..", "fixtures", "joint.glb"))
    document = FreeCAD.newDocument("joint")
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "joint.step")
        made.write(path)
        ImportGui.insert(name=path, docName=document.Name, merge=False, useLinkGroup=False, mode=0)
    (whole,) = document.RootObjects
    assert whole.TypeId == "App::Part", whole.TypeId
    found = leaves(whole, FreeCAD.Placement())
    places = [(part, place) for part in made.parts for place in part.places]
    assert len(found) == len(places) == 10, len(found)
    assert all(shape.isValid() and len(shape.Solids) == 1 for shape, _ in found)
    found = [(shape.Volume, shape.Solids[0].CenterOfMass, colour) for shape, colour in found]
    for part, place in places:
        shape = convert.shape(part.made)
        shape.Placement = FreeCAD.Placement(FreeCAD.Matrix(*place.matrix.ravel()))
        centre = shape.Solids[0].CenterOfMass
        volume, own, colour = min(found, key=lambda one: one[1].distanceToPoint(centre))
        assert own.distanceToPoint(centre) < 1e-4, part.name
        assert abs(volume / shape.Volume - 1.0) < 1e-6, part.name
        assert max(abs(a - b / 255) for a, b in zip(colour, part.colour)) < 0.005, part.name
    FreeCAD.closeDocument(document.Name)


def test_the_mesh_workbench_has_a_button():
    FreeCADGui.activateWorkbench("MeshWorkbench")
    bars = FreeCADGui.getMainWindow().findChildren(QtGui.QToolBar)
    actions = [action for bar in bars for action in bar.actions()]
    found = [bar.objectName() for bar in bars]
    assert any(action.text().startswith("Scan to face or solid") for action in actions), found


def main():
    status = 1
    try:
        FreeCADGui.getMainWindow().resize(1280, 800)
        FreeCADGui.activateWorkbench("PartWorkbench")
        tests = [test_a_face, test_a_solid, test_a_part, test_an_error_shows_its_place, test_the_file_of_an_assembly_opens]
        for test in [*tests, test_the_mesh_workbench_has_a_button]:
            test()
            print(f"{test.__name__}: ok", flush=True)
        status = 0
    except BaseException:
        traceback.print_exc()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


QtCore.QTimer.singleShot(2000, main)
