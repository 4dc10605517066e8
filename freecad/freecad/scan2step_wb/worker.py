"""A conversion in a thread of its own. The document is not touched there."""

import scan2step
from PySide import QtCore

from . import convert


class Stopped(Exception):
    """The user pressed Cancel."""


class FileWorker(QtCore.QThread):
    """Converts a file with several parts. ``result`` or ``error`` is set when it has finished."""

    def __init__(self, path, parent=None):
        super().__init__(parent)
        self.path = path
        self.result = self.error = None

    def run(self):
        try:
            self.result = scan2step.convert(self.path, parts="keep", up="z")
        except Exception as error:  # whatever it is, the window has to say it
            self.error = error


class Worker(QtCore.QThread):
    """Converts arrays. ``result`` or ``error`` is set when it has finished."""

    progressed = QtCore.Signal(str, float)

    def __init__(self, vertices, faces, arguments, name, parent=None):
        super().__init__(parent)
        self.task = (vertices, faces, arguments, name)
        self.result = self.prepared = None
        self.error = None
        self.is_cancelled = False

    def cancel(self):
        self.is_cancelled = True

    def run(self):
        vertices, faces, arguments, name = self.task
        try:
            self.result = scan2step.convert(vertices, faces, name=name, progress=self.tell, **arguments)
            self.prepared = convert.Prepared(self.result, scan2step.__version__)
        except Exception as error:  # whatever it is, the window has to say it
            self.error = error

    def tell(self, stage, share):
        if self.is_cancelled:
            raise Stopped("stopped")
        self.progressed.emit(stage, share)
