"""Which files of a crate import each other in a circle: read from the sources alone, nothing is built.

    python tests/circles.py [CRATE ...]        (folders with a `src`; default: every crate of the workspace)

A file depends on the file that defines what it names, in a `use` or by a path such as `super::name` or `child::name`. Names are followed
through re-exports to where they are defined, so a parent that only re-exports what its children define takes part in no circle. A child
that imports what its parent defines does, if the parent imports from the child. Tests are left out.
"""

import re
import sys
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

#: Folders of the workspace that hold crates.
PRODUCTS = ("fmi", "kit", "master", "machine", "studies", "tools")

#: Comments, texts and characters, which hold no names.
NO_CODE = re.compile(
    r'//[^\n]*|/\*.*?\*/|b?r(#*)".*?"\1|b?"(?:\\.|[^"\\])*"|b?\'(?:\\[^\n]{1,8}?|[^\\\'\n])\'',
    re.DOTALL,
)
MODULE = re.compile(r'((?:#\[[^\]]*\]\s*)*)(?:pub(?:\([^)]*\))?\s+)?mod\s+(\w+)\s*([;{])')
DEFINED = re.compile(r"\b(?:fn|struct|enum|union|trait|type|const|static|macro_rules!)\s+(?:mut\s+)?(\w+)")
USE = re.compile(r"(pub(?:\([^)]*\))?\s+)?\buse\s+([^;]+);")
PATH = re.compile(r"(?<![\w:])(?:\w+::)+(?:\w+|(?=[{*<]))")


def stripped(text):
    """A source without comments, texts and what is compiled for tests only."""
    text = NO_CODE.sub(lambda found: '""' if found[0][0] not in "/" else " ", text)
    while found := re.search(r"#\[cfg\(test\)\]\s*(?:#\[[^\]]*\]\s*)*[^;{]*[;{]", text):
        end = found.end() if text[found.end() - 1] == ";" else closing(text, found.end())
        text = text[: found.start()] + text[end:]
    return text


def closing(text, start):
    """Where the block ends whose brace was opened just before `start`."""
    depth = 1
    for found in re.finditer(r"[{}]", text[start:]):
        depth += 1 if found[0] == "{" else -1
        if depth == 0:
            return start + found.end()
    return len(text)


def outermost(text):
    """A text without its blocks."""
    kept, at = "", 0
    while (start := text.find("{", at)) >= 0:
        kept, at = kept + text[at:start] + " ", closing(text, start + 1)
    return kept + text[at:]


def branches(tree, path=()):
    """(path, name in this module) for each branch of a use tree, `a::{b, c as d}`; a glob has the name `*`."""
    tree = tree.strip()
    head, brace, rest = tree.partition("{")
    if brace:
        path = (*path, *filter(None, (part.strip() for part in head.split("::"))))
        depth, item = 0, ""
        for letter in rest.rpartition("}")[0] + ",":
            depth += {"{": 1, "}": -1}.get(letter, 0)
            if letter == "," and depth == 0:
                if item.strip():
                    yield from branches(item, path)
                item = ""
            else:
                item += letter
        return
    whole, _, alias = tree.partition(" as ")
    parts = (*path, *(part.strip() for part in whole.split("::") if part.strip()))
    if parts and parts[-1] == "self":
        parts = parts[:-1]
    if parts:
        yield parts, alias.strip() or parts[-1]


class Module:
    """A module: its file, what it defines, imports, and its children."""

    def __init__(self, file, folder, text, parent=None):
        self.file, self.parent, self.children = file, parent, {}
        self.root = parent.root if parent else self
        text = self._take_children(text, folder)
        self.defined = set(DEFINED.findall(outermost(text)))
        self.imports, self.globs, self.exported = {}, [], set()
        for visibility, tree in USE.findall(text):
            for path, name in branches(tree):
                if name == "*":
                    self.globs.append((path[:-1], bool(visibility)))
                    continue
                self.imports[name] = path
                if visibility:
                    self.exported.add(name)
        self.body = USE.sub(" ", text)

    def _take_children(self, text, folder):
        """The text without its modules, which become children."""
        kept, at = "", 0
        while found := MODULE.search(text, at):
            attributes, name, end = found.groups()
            kept += text[at : found.start()]
            at = found.end()
            if end == "{":
                at = closing(text, found.end())
                self.children[name] = Module(self.file, folder / name, text[found.end() : at - 1], self)
                continue
            places = (folder / f"{name}.rs", folder / name / "mod.rs")
            if where := re.search(r"#\[path\s*=\s*", attributes):
                raise ValueError(f"{self.file}: `{attributes[where.start():]}`: modules with a path are not followed")
            if file := next((place for place in places if place.is_file()), None):
                self.children[name] = Module(file, folder / name, stripped(file.read_text()), self)
        return kept + text[at:]

    def all(self):
        yield self
        for child in self.children.values():
            yield from child.all()

    def find(self, path, seen=()):
        """(module, name defined there) of what a path names as seen from here; the name is None where the path names the module itself.
        None if it is not of this crate."""
        if not path:
            return self, None
        head, rest = path[0], path[1:]
        if (self, head) in seen:
            return None
        if head == "crate":
            return self.root.find(rest, seen)
        if head == "self":
            return self.find(rest, seen)
        if head == "super":
            return self.parent and self.parent.find(rest, seen)
        if head in self.children:
            return self.children[head].find(rest, seen)
        if head in self.defined:
            return self, head
        seen = (*seen, (self, head))
        if head in self.imports:
            return self.find((*self.imports[head], *rest), seen)
        for glob, _ in self.globs:
            source = self.find(glob, seen)
            if source and source[0] is not self and (found := source[0].find(path, seen)):
                return found
        return None

    def uses(self):
        """{file: names that this module takes from it}."""
        found, named = defaultdict(set), set(re.findall(r"\w+", self.body))
        taken = [path for name, path in self.imports.items() if name not in self.exported or name in named]
        for glob, exported in self.globs:
            source = None if exported else self.find(glob)
            taken += [(*glob, name) for name in named & source[0].defined] if source else []
        taken += self.paths()
        for module, name in filter(None, map(self.find, taken)):
            if name:  # a module by itself is no use of its file
                found[module.file].add(name)
        return found

    def paths(self):
        """Paths outside of `use` that begin at a module."""
        found = [tuple(text.strip(":").split("::")) for text in PATH.findall(self.body)]
        return [p for p in found if p[0] in ("crate", "self", "super") or p[0] in self.children or p[0] in self.imports]


def arrows(source):
    """{file: {file that it takes names from: names}} of the crate whose root file this is."""
    found = defaultdict(lambda: defaultdict(set))
    for module in Module(source, source.parent, stripped(source.read_text())).all():
        for file, names in module.uses().items():
            if file != module.file:
                found[module.file][file] |= names
    return found


def circles(arrows):
    """Sets of nodes that reach each other (Tarjan), the largest first; `arrows`: {node: nodes}."""
    order, low, stack, found = {}, {}, [], []

    def visit(node):
        order[node] = low[node] = len(order)
        stack.append(node)
        for other in arrows.get(node, ()):
            if other not in order:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], order[other])
        if low[node] == order[node]:
            at = stack.index(node)
            group, stack[at:] = stack[at:], []
            if len(group) > 1:
                found.append(set(group))

    for node in list(arrows):
        if node not in order:
            visit(node)
    return sorted(found, key=len, reverse=True)


def roots(crate):
    """The root files of a crate: its library and its programs."""
    source = crate / "src"
    places = (source / "lib.rs", source / "main.rs", *sorted((source / "bin").glob("*.rs")))
    return [place for place in places if place.is_file()]


def report(crate):
    """A text for each circle of a crate, and the files in circles."""
    texts, files = [], set()
    for root in roots(crate):
        found = arrows(root)
        for circle in circles(found):
            files |= circle
            short = lambda file: str(file.relative_to(crate / "src"))
            lines = [f"{crate.name}: {len(circle)} files in a circle"]
            for file in sorted(circle):
                for other in sorted(circle & found[file].keys()):
                    lines.append(f"  {short(file)} takes from {short(other)}: {', '.join(sorted(found[file][other]))}")
            texts.append("\n".join(lines))
    return texts, files


def crates():
    """Folders of the workspace's crates."""
    inside = [folder for product in PRODUCTS for folder in (ROOT / product).iterdir()]
    folders = [*inside, *ROOT.glob("fmu-*"), ROOT / "actuator-table", ROOT / "python"]
    return sorted(folder for folder in folders if (folder / "Cargo.toml").is_file())


if __name__ == "__main__":
    names = [Path(name).resolve() for name in sys.argv[1:]]
    reports = [report(crate) for crate in names or crates()]
    print("\n".join(text for texts, _ in reports for text in texts))
    print(f"{sum(len(files) for _, files in reports)} files in circles")
