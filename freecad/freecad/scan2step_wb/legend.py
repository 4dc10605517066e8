"""Things in the 3D view that are no part of a document: a legend, and the place of an error."""

from pivy import coin

from . import deviation

LEGEND = "scan2step_legend"
PLACE = "scan2step_place"


def show_legend(view, end):
    """Draws the scale at the right of the 3D view."""
    remove(view, LEGEND)
    root = coin.SoAnnotation()
    root.setName(LEGEND)
    camera = coin.SoOrthographicCamera()
    camera.height = 2.0
    camera.position = (0.0, 0.0, 1.0)
    camera.viewportMapping = coin.SoCamera.LEAVE_ALONE
    root.addChild(camera)
    light = coin.SoLightModel()
    light.model = coin.SoLightModel.BASE_COLOR
    root.addChild(light)
    steps = 40
    for k in range(steps):
        share = (k + 0.5) / steps
        low, high = (-0.8 + 1.2 * x / steps for x in (k, k + 1))
        paint = deviation.colours(deviation.np.array([(2.0 * share - 1.0) * end]), end)[0]
        root.addChild(rectangle(0.70, 0.76, low, high, paint))
    for share in (-1.0, -0.5, 0.0, 0.5, 1.0):
        root.addChild(text(0.78, 0.6 * share - 0.212, f"{share * end:+.3g} mm"))
    view.getSceneGraph().addChild(root)


def rectangle(left, right, low, high, paint):
    part = coin.SoSeparator()
    colour = coin.SoBaseColor()
    colour.rgb = tuple(map(float, paint))
    corners = coin.SoCoordinate3()
    corners.point.setValues(0, 4, [(left, low, 0), (right, low, 0), (right, high, 0), (left, high, 0)])
    face = coin.SoFaceSet()
    face.numVertices = 4
    for node in (colour, corners, face):
        part.addChild(node)
    return part


def text(x, y, words):
    part = coin.SoSeparator()
    place = coin.SoTranslation()
    place.translation = (x, y, 0.0)
    colour = coin.SoBaseColor()
    colour.rgb = (1.0, 1.0, 1.0)
    font = coin.SoFont()
    font.size = 14.0
    letters = coin.SoText2()
    letters.string = words
    for node in (place, colour, font, letters):
        part.addChild(node)
    return part


def show_place(view, point, radius):
    """Marks a place with a red ball that is seen through everything."""
    remove(view, PLACE)
    root = coin.SoAnnotation()
    root.setName(PLACE)
    place = coin.SoTranslation()
    place.translation = tuple(map(float, point))
    colour = coin.SoBaseColor()
    colour.rgb = (0.85, 0.1, 0.1)
    ball = coin.SoSphere()
    ball.radius = radius
    for node in (place, colour, ball):
        root.addChild(node)
    view.getSceneGraph().addChild(root)


def remove(view, name):
    """Removes what was drawn under a name. Returns whether there was any."""
    graph = view.getSceneGraph()
    found = [graph.getChild(k) for k in range(graph.getNumChildren())]
    found = [node for node in found if str(node.getName()) == name]
    for node in found:
        graph.removeChild(node)
    return bool(found)
