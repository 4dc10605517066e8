"""Finds the named constants of the library, and rewrites a copy of it in which each of them can be
multiplied by a factor while the program runs.

A constant `const NAME: f64 = VALUE;` becomes a function `fn NAME() -> f64`, and `NAME` becomes
`NAME()` wherever it is used. Some constants cannot become functions, for example the lengths of
arrays. The compiler refuses these, and then they stay as they are.
"""

import re
from dataclasses import dataclass
from pathlib import Path

# These folders and files steer no result: the program, the drawing, the reports, the limits on
# options, and the texts.
EXCLUDED = {"cli", "main", "picture", "progress", "report", "rules", "words", "threads"}

KIND = r"f64|f32|usize|u32|u64|i32|\[(?:f64|usize); \w+\]"
DEFINITION = re.compile(
    rf"^(?P<doc>(?:[ \t]*///[^\n]*\n)*)(?P<indent>[ \t]*)(?P<public>pub(?:\([^)]*\))? )?"
    rf"const (?P<name>[A-Z][A-Z0-9_]*): (?P<kind>{KIND}) =\s*(?P<value>[^;]*);",
    re.MULTILINE,
)
# Comments, texts and imports hold no uses of a constant.
NO_USE = re.compile(
    r"//[^\n]*|b?\"(?:\\.|[^\"\\])*\"|b?'(?:\\.|[^'\\])'"
    r"|^[ \t]*(?:pub(?:\([^)]*\))? )?use [^;]*;",
    re.MULTILINE,
)
# These values mark a missing index, and have no size.
MARKER = re.compile(r"::(MAX|MIN|INFINITY)")


@dataclass
class Constant:
    file: str
    line: int
    name: str
    kind: str
    value: str
    reason: str

    @property
    def key(self):
        return f"{self.file}:{self.name}"

    @property
    def room(self):
        return self.file.removeprefix("src/").removeprefix("stages/").split("/")[0].removesuffix(".rs")

    @property
    def module(self):
        path = Path(self.file)
        return path.parent.name if path.stem in ("mod", "lib") else path.stem


def sources(root):
    """The Rust files of the library and the program without those of tests."""
    files = sorted((root / "src").rglob("*.rs"))
    return [file.relative_to(root) for file in files if "tests" not in file.stem]


def without_tests(text):
    """The text before the unit tests of a file."""
    return re.split(r"(?=#\[cfg\(test\)\]\nmod \w+ \{)", text, maxsplit=1)[0]


def found(root):
    """All constants that may steer a result, in the order of their files."""
    constants = []
    for file in sources(root):
        if Path(file).parts[1].removesuffix(".rs") in EXCLUDED:
            continue
        text = without_tests((root / file).read_text())
        before = None
        for match in DEFINITION.finditer(text):
            if not MARKER.search(match["value"]):
                constants.append(constant(file, text, match))
                share_reason(before, constants[-1])
                before = constants[-1]
    return constants


def share_reason(before, constant):
    """Gives a constant without a reason that of the constant in the line before."""
    if before and not constant.reason and before.line == constant.line - 1:
        constant.reason = before.reason


def constant(file, text, match):
    line = text[: match.start("name")].count("\n") + 1
    doc = " ".join(part.strip().removeprefix("///").strip() for part in match["doc"].splitlines())
    value = " ".join(match["value"].split())
    return Constant(str(file), line, match["name"], match["kind"], value, doc)


def rewritten(root, copy, constants):
    """Writes the sources of `root` to `copy`, where the constants are functions."""
    numbers = {constant.key: number for number, constant in enumerate(constants)}
    for file in sources(root):
        text = (root / file).read_text()
        tests = text[len(without_tests(text)) :]
        text = with_calls(without_tests(text), str(file), constants)
        own = {c.name: numbers[c.key] for c in constants if c.file == str(file)}
        text = DEFINITION.sub(lambda match: as_function(match, own), text)
        more = "\n#[doc(hidden)]\npub mod varied;\n" if str(file) == "src/lib.rs" else ""
        write(copy / file, text + tests + more)


def write(path, text):
    """Leaves a file that already has this text alone, so that cargo builds no more than needed."""
    if not path.exists() or path.read_text() != text:
        path.write_text(text)


def as_function(match, own):
    if match["name"] not in own or MARKER.search(match["value"]):
        return match[0]
    doc, indent, public = match["doc"], match["indent"], match["public"] or ""
    body = f"crate::varied::of({own[match['name']]}, {match['value']})"
    return f"{doc}{indent}{public}fn {match['name']}() -> {match['kind']} {{ {body} }}"


def with_calls(text, file, constants):
    """The text with `NAME()` in place of every use of a constant that this file can see."""
    visible = {}
    for constant in constants:
        visible.setdefault(constant.name, []).append(constant)
    own = {match["name"] for match in DEFINITION.finditer(text)}
    imports = re.findall(r"\buse ([^;]*);", text)

    def call(match):
        path, name = match["path"], match["name"]
        candidates = visible.get(name, [])
        if path:
            module = path.split("::")[-2]
            is_here = any(c.module == module for c in candidates) or module == "super"
        elif name in own:
            is_here = any(c.file == file for c in candidates)
        else:
            is_here = any(is_import(c, file, path) for c in candidates for path in imports)
        return f"{match[0]}()" if candidates and is_here else match[0]

    use = re.compile(r"(?<!const )(?<![\w:])(?P<path>(?:\w+::)*)(?P<name>[A-Z][A-Z0-9_]*)\b(?!::|\()")
    parts, end = [], 0
    for hidden in NO_USE.finditer(text):
        parts += [use.sub(call, text[end : hidden.start()]), hidden[0]]
        end = hidden.end()
    return "".join(parts) + use.sub(call, text[end:])


def is_import(constant, file, path):
    """Whether the path of a `use` in this file names the constant, or a re-export of it."""
    if not re.search(rf"\b{constant.name}\b", path):
        return False
    modules = [part for part in re.split(r"::\{|::", path.split(constant.name)[0]) if part]
    modules = [module for module in modules if re.fullmatch(r"\w+", module)]
    last = modules[-1] if modules else ""
    if last in ("super", "self", "crate"):
        return constant.room == Path(file).parts[1].removesuffix(".rs") or last == "crate"
    return constant.module == last or last in Path(constant.file).parts
