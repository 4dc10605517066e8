"""Writes the page of all constants, and that of the few that matter most, from the measured figures."""

import math
import re

# The order of the tables. Rooms that serve several stages come last.
STAGES = ["crop", "cloud", "mesh", "smooth", "fill", "thin", "parameterize", "adapt", "knots", "fit"]
STAGES += ["layout", "net", "patches", "trim", "brep", "deviation", "check", "convert", "spline"]

INTRODUCTION = """# Named constants

`benches/sensitivity/run.py FOLDER` writes this page to target/constants.md. It halves and doubles every named constant that
can steer a result, converts small scans, and compares each result with the usual one. So the page
shows which constants matter, and what breaks on either side of their values.

{scans}

- *read by* is the number of scans of which the conversion reads the constant. The others cannot
  depend on it.
- *halved* and *doubled* say for how many scans the written file has other bytes, of those that were
  tried. With `--enough N` no more scans are tried once N have changed, and with `--most N` never more
  than N. A dash means that no byte changes in any scan tried. A whole number of 1 cannot be halved.
- After this follow the smallest and the largest change of the root mean square distance of the
  measured points from the face, the change of the sum of control points over all scans, and what
  happens to scans that fail, hang, fold, lose loops, or miss a named tolerance. "slower" and "faster"
  compare the sums of CPU times, if they differ by more than a fifth.
- Constants that the last run left out (`--only PART`) keep their figures of an earlier one.
- Small changes of the bytes are usual: the last digits of a file depend on every step.

The constants of the program, the reports, the pictures and the limits on options are not here,
because they steer no result.
"""

KEPT = """# The named constants that matter most

`benches/sensitivity/run.py` halves and doubles every named constant that can steer a result, converts {scans} small
scans, and writes what changes to `target/constants.md`, with the scans and their options. That takes an
hour, so this page keeps the {number} constants with the largest changes, the largest first. With `--keep` the script
writes this page, too.

A change counts in this order: a scan that fails or hangs; one that misses its named tolerance; a face with other
folds or loops; and the changes of the root mean square distance of the measured points from the face and of
the number of control points, as logarithms of ratios.

*halved* and *doubled* say for how many of the scans tried the file has other bytes. After this follow the
smallest and the largest change of the root mean square distance, the change of the sum of control points, and what
happens to scans. "slower" and "faster" compare sums of CPU times. A dash means that nothing changes.

| constant | value | reason | halved | doubled |
| --- | --- | --- | --- | --- |
"""

# What the outcome of a scan counts, as the logarithm of a ratio of distances would.
OUTCOMES = {
    "hang": 3.0,
    "fail": 3.0,
    "miss the tolerance": 2.0,
    "more folds": 1.0,
    "meet it now": 1.0,
    "fewer folds": 0.5,
    "other loops": 0.3,
}

UNVARIED = """
## Not varied

The compiler needs these values, for example as the lengths of arrays, so they cannot be changed
while the program runs.

| constant | value | reason |
| --- | --- | --- |
"""


def written(varied, fixed, inputs, usual, results, before):
    """The text of the page. Constants that were not measured keep the figures of the page before, if they
    have the same value."""
    kept = figures_by_constant(before)
    text = INTRODUCTION.format(scans=described(inputs))
    order = {room: place for place, room in enumerate(STAGES)}
    rooms = sorted({c.room for c in varied}, key=lambda room: (order.get(room, len(order)), room))
    for room in rooms:
        text += f"\n## {room}\n\n| constant | value | reason | read by | halved | doubled |\n"
        text += "| --- | --- | --- | --- | --- | --- |\n"
        numbered = [(n, c) for n, c in enumerate(varied) if c.room == room]
        text += "".join(row(n, c, inputs, usual, results, kept) for n, c in numbered)
    text += UNVARIED if fixed else ""
    text += "".join(f"| {place(c)} | {value(c)} | {cell(c.reason)} |\n" for c in fixed)
    return text


def most_important(page, steers_nothing, number=30):
    """The page of the constants that matter most, from the page of all. `steers_nothing` has the rooms and
    names of constants that are given by mathematics or by formats: half of them means nothing."""
    rows = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("| `")]
    rows = [cells for cells in rows if len(cells) == 6 and not steers_nothing(*names(cells[0]))]
    rows.sort(key=lambda cells: -max(weight(cells[4]), weight(cells[5])))
    scans = re.search(r"The (\d+) scans", page)[1]
    text = KEPT.format(scans=scans, number=number)
    return text + "".join(f"| {' | '.join(cells[:3] + cells[4:])} |\n" for cells in rows[:number])


def names(cell):
    """The room, the file and the name of a constant."""
    name, file = cell.split()
    return file.split("/")[0].removesuffix(".rs"), file, name.strip("`")


def weight(cell):
    """How much a change matters that is described in these words."""
    ratios = [re.search(r"rms (\S+) to", cell), re.search(r"to (\S+) %", cell)]
    ratios += [re.search(r"control points (\S+) %", cell)]
    logs = [abs(math.log(1 + float(found[1]) / 100)) if found else 0.0 for found in ratios]
    counts = [(re.search(rf"(\d+) {what}", cell), worth) for what, worth in OUTCOMES.items()]
    return max(logs[:2]) + logs[2] + sum(int(found[1]) * worth for found, worth in counts if found)


def described(inputs):
    listed = [f"`{scan.name}` {' '.join(scan.options)}".strip() for scan in inputs]
    virtual = "" if len(inputs) > 5 else " These are virtual scans only: no real ones were present."
    return f"The {len(inputs)} scans and their options are {', '.join(listed)}.{virtual}"


def figures_by_constant(page):
    """The last three cells of each row of tables, by the constant and its value."""
    rows = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("| `")]
    return {(cells[0], cells[1]): cells[3:] for cells in rows if len(cells) == 6}


def row(number, constant, inputs, usual, results, kept):
    key = place(constant), value(constant)
    is_measured = any(measured == constant.key for measured, _, _ in results.rows)
    if not is_measured and key in kept:
        return f"| {' | '.join([*key, cell(constant.reason), *kept[key]])} |\n"
    names = [s.name for s, before in zip(inputs, usual) if number in before["read"]]
    normal = {s.name: before for s, before in zip(inputs, usual)}
    changes = []
    for factor in (0.5, 2.0):
        tried = [name for name in names if (constant.key, factor, name) in results.rows]
        pairs = [(normal[name], results.rows[constant.key, factor, name]) for name in tried]
        changes.append(change(pairs))
    cells = [*key, cell(constant.reason), str(len(names)), *changes]
    return f"| {' | '.join(cells)} |\n"


def place(constant):
    return f"`{constant.name}` {constant.file.removeprefix('src/').removeprefix('stages/')}"


def value(constant):
    return f"`{cell(constant.value)}`"


def cell(text):
    return text.replace("|", "\\|")


def change(pairs):
    """What differs between the usual figures and others, in words."""
    different = [(a, b) for a, b in pairs if differs(a, b)]
    if not different:
        return f"– of {len(pairs)}" if pairs else "not tried"
    said = [f"{len(different)} of {len(pairs)}"]
    whole = [(a, b) for a, b in different if "rms" in a and "rms" in b]
    shifts = [100 * (b["rms"] / a["rms"] - 1) for a, b in whole if a["rms"] > 0]
    if shifts and max(map(abs, shifts)) >= 0.05:
        said.append(f"rms {min(shifts):+.1f} to {max(shifts):+.1f} %")
    said += sums(whole)
    said += outcomes(different)
    before, after = (sum(pair[k]["seconds"] for pair in pairs) for k in (0, 1))
    if after > 1.2 * before:
        said.append(f"{after / before:.1f} × slower")
    if before > 1.2 * after:
        said.append(f"{before / after:.1f} × faster")
    return ", ".join(said)


def differs(before, after):
    is_other = any(before.get(key) != after.get(key) for key in ["exit", "bytes", "hints"])
    return is_other or "check" in after and after["check"] != before["check"]


def sums(pairs):
    before, after = (sum(pair[k]["points"] for pair in pairs) for k in (0, 1))
    share = 100 * (after / before - 1) if before else 0
    return [f"control points {share:+.0f} %"] if abs(share) >= 0.5 else []


def outcomes(pairs):
    """Counts of scans with a worse or better outcome."""
    both = lambda key: [(a.get(key), b.get(key)) for a, b in pairs]
    finished = {0, 3}
    counts = {
        "hang": sum(b == "hangs" for _, b in both("exit")),
        "fail": sum(a in finished and b not in finished | {"hangs"} for a, b in both("exit")),
        "miss the tolerance": sum(a is True and b is False for a, b in both("met")),
        "meet it now": sum(a is False and b is True for a, b in both("met")),
        "more folds": sum(None not in pair and pair[1] > pair[0] for pair in both("folds")),
        "fewer folds": sum(None not in pair and pair[1] < pair[0] for pair in both("folds")),
        "other loops": sum(None not in pair and pair[1] != pair[0] for pair in both("loops")),
    }
    return [f"{count} {what}" for what, count in counts.items() if count]
