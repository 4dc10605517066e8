"""Adds the commands to a menu of their own, and the first one to a toolbar of the Mesh workbench.

FreeCAD builds its menus anew when a workbench is chosen, so this is done each time.
"""

import FreeCAD
import FreeCADGui

MENU = "scan2step"


def add(workbench):
    from PySide import QtGui

    from . import commands

    window = FreeCADGui.getMainWindow()
    bar = window.menuBar()
    known = [action for action in bar.actions() if action.text() == MENU]
    others = [action for action in bar.actions() if action not in known and action.isVisible()]
    for action in known:
        # FreeCAD hides menus that are not its own. Help stays the last one.
        bar.insertAction(others[-1] if others else None, action)
        action.setVisible(True)
    if not known:
        menu = QtGui.QMenu(MENU, bar)
        for command in commands.COMMANDS:
            add_action(menu, command)
        # As soon as the menu opens, it shows what the selection allows.
        menu.aboutToShow.connect(lambda: enable(menu))
        bar.insertMenu(others[-1] if others else None, menu)
    if workbench == "MeshWorkbench":
        for toolbar in window.findChildren(QtGui.QToolBar):
            if toolbar.objectName() == "Mesh tools" and not toolbar.findChild(QtGui.QAction, MENU):
                action = add_action(toolbar, commands.Convert)
                action.setObjectName(MENU)


def add_action(place, command):
    from PySide import QtGui

    resources = command().GetResources()
    action = QtGui.QAction(QtGui.QIcon(resources["Pixmap"]), resources["MenuText"], place)
    action.setToolTip(resources["ToolTip"])
    action.setData(command.name)
    action.triggered.connect(lambda: run(command))
    place.addAction(action)
    return action


def run(command):
    """Runs a command if the selection is right, and says so if not."""
    from . import commands

    if command().IsActive():
        FreeCADGui.runCommand(command.name)
    else:
        wanted = "a mesh or a cloud of points" if command.kind == "scan" else "a result of scan2step"
        commands.show(f"{command.title}: select {wanted} first.")


def enable(menu):
    from . import commands

    by_name = {command.name: command for command in commands.COMMANDS}
    for action in menu.actions():
        action.setEnabled(by_name[action.data()]().IsActive())


def begin():
    try:
        import scan2step  # noqa: F401
    except ImportError as error:
        FreeCAD.Console.PrintWarning(f"scan2step: its Python package is missing ({error}). See the README of the addon.\n")
        return
    from . import commands

    commands.register()
    FreeCADGui.getMainWindow().workbenchActivated.connect(add)


begin()
