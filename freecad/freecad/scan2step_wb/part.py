"""What the report of a part says about its exact faces, in words and rows. It needs no window."""

import collections

#: The columns of the table of cylinders.
COLUMNS = ("kind", "radius", "axis", "at")

#: What "round" is called. A round edge does not go all around.
NAMES = {"round": "round edge"}


#: The colours of the kinds of faces, as the picture and the page of a report have them. Other faces are grey.
COLOURS = {"plane": 0xD8C9A8, "cylinder": 0xB7CBD6, "cone": 0xC6D3B2, "sphere": 0xDCB9A9, "torus": 0xC9BFD9}
GREY = 0xCCCCCC


def body(report):
    """The report of the first component, or of the only one."""
    return report.get("components", [report])[0]


def is_exact(report):
    """Whether the faces are planes, cylinders, cones, spheres and tori."""
    return bool(body(report).get("exact"))


def kinds(report):
    """The number of faces of each kind: "7 planes, 5 cylinders, 1 torus". Exact kinds come first."""
    counts = body(report)["shape"]["surfaces"]
    order = [*COLOURS, *sorted(set(counts) - set(COLOURS))]
    return ", ".join(counted(counts[kind], kind) for kind in order if counts.get(kind))


def counted(count, word):
    if count == 1:
        return f"1 {word}"
    return f"{count} tori" if word == "torus" else f"{count} {word}s"


def colours(report):
    """The colour of each face by its kind: red, green and blue from 0 to 1."""
    codes = [COLOURS.get(face["surface"], GREY) for face in body(report)["faces"]]
    return [tuple((code >> shift & 255) / 255.0 for shift in (16, 8, 0)) for code in codes]


def cylinders(report):
    """A row for each cylinder, as :data:`COLUMNS` has it, with the numbers of its faces."""
    found = []
    for row in body(report)["exact"]["cylinders"]:
        kind = NAMES.get(row["kind"], row["kind"])
        texts = (kind, f"{row['radius_mm']:.4g}", along(row["axis"]), place(row["at"]))
        found.append((texts, row["faces"]))
    return found


def along(axis):
    """The name of an axis of the world, or the numbers of a direction."""
    for name, others in (("x", axis[1:]), ("y", axis[::2]), ("z", axis[:2])):
        if not any(others):
            return name
    return place(axis)


def place(at):
    return "(" + ", ".join(f"{x:.4g}" for x in at) + ")"


def notes(report):
    """Lines about relations, snaps and facets. Cylinders have the numbers of their rows, from 1."""
    exact = body(report)["exact"]
    lines = []
    for relation in exact["relations"]:
        numbers = ", ".join(str(k + 1) for k in relation["cylinders"])
        to = ", ".join(str(k + 1) for k in relation["to"])
        lines.append(f"{relation['kind']}: {numbers}" + (f" to {to}" if to else ""))
    snaps = collections.Counter(snap["to"] for snap in exact["snaps"])
    if snaps:
        moved = ", ".join(f"{count} to {to}" for to, count in snaps.items())
        lines.append(f"moved within the rounding of the file: {moved}")
    for row in exact["round_sizes"]:
        measured = f"{row['size']} {row['value']:.6g} {row['unit']} ± {row['standard_deviation']:.2g}"
        lines.append(f"{measured} is {row['round']:.6g}" + (", made so" if row["taken"] else ""))
    for row in exact["facets"]:
        lines.append(f"{counted(row['triangles'], 'facet')} of a {row['surface']} near {place(row['at'])}, as {row['why']}")
    for row in exact["risers"]:
        lines.append(f"{counted(row['triangles'], 'triangle')} between two faces near {place(row['at'])}, where {row['why']}")
    if exact["explained_pct"] < 100.0:
        lines.append(f"{exact['explained_pct']:.1f} % of the area is exact; the rest is facets")
    return lines
