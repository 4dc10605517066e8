"""What FreeCAD keeps of a Python object in a document."""


class Stateless:
    """An object of which a document keeps nothing but its class."""

    # FreeCAD 0.20 asks for these, later versions for dumps and loads.
    def __getstate__(self):
        return None

    def __setstate__(self, state):
        return None

    dumps = __getstate__

    def loads(self, state):
        return None
