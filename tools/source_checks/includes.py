# SPDX-License-Identifier: Apache-2.0
"""Includes between folders: no circle, no arrow upwards.

Reads the lines `#include "..."` of all C and C++ files and what layers.toml allows. A folder is a directory that holds
sources; its sub-folders are folders of their own. Angle brackets are for libraries and are not read.
"""

import argparse
import re
import sys
import tomllib
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

from c_text import pieces_of

ROOT = Path(__file__).resolve().parents[2]
LAYERS = Path(__file__).parent / "layers.toml"
SUFFIXES = {".c", ".h", ".cpp", ".hpp"}
LINES_SHOWN = 4


@dataclass(frozen=True)
class Include:
    file: str
    line: int
    name: str
    target: str  # the included file, from the root of the repository

    @property
    def arrow(self):
        return folder_of(self.file), folder_of(self.target)

    def __str__(self):
        return f"{self.file}:{self.line} includes {self.target}"


def folder_of(file):
    return file.rpartition("/")[0]


def is_within(folder, outer):
    return folder == outer or folder.startswith(outer + "/")


def sources(root, layers):
    for top in layers["top_folders"]:
        for path in sorted((root / top).rglob("*")):
            if path.suffix in SUFFIXES and path.is_file():
                yield path.relative_to(root).as_posix()


def candidates(file, name, layers, known):
    """The files that `name` can mean in `file`: beside it, or below an include root of its folder.

    In a folder of own_root_below, each folder is an include root of its own files: a new board needs no entry.
    """
    bases = [folder_of(file)]
    bases += ["/".join(folder_of(file).split("/")[: parent.count("/") + 2])
              for parent in layers.get("own_root_below", []) if is_within(folder_of(file), parent) and folder_of(file) != parent]
    bases += [root for root, users in layers["include_roots"].items() if any(is_within(folder_of(file), user) for user in users)]
    found = []
    for base in bases:
        parts = []
        for part in f"{base}/{name}".split("/"):
            if part == ".." and parts:
                parts.pop()
            elif part != ".":
                parts.append(part)
        path = "/".join(parts)
        if path in known and path not in found:
            found.append(path)
    return found


def read_includes(root, layers):
    """All includes between files of the repository, and a sentence for each include of no file or of several."""
    known = set(sources(root, layers))
    from_outside = set(layers["from_outside"])
    includes, errors = [], []
    for file in sorted(known):
        for piece in pieces_of((root / file).read_text()):
            match = re.search(r'include\s*"([^"]+)"', piece.text) if piece.kind == "include" else None
            if match is None:
                continue
            name = match[1]
            found = candidates(file, name, layers, known)
            if len(found) == 1:
                includes.append(Include(file, piece.line, name, found[0]))
            elif found:
                errors.append(f'{file}:{piece.line}: "{name}" is ambiguous: it can be {" or ".join(found)}. '
                              "Include it by a path that only one of them has.")
            elif name not in from_outside:
                errors.append(f'{file}:{piece.line}: "{name}" is not found beside the file or in an include root. '
                              "Correct the path, or add the file to from_outside or its root to include_roots in layers.toml.")
    return includes, errors


def strongly_connected(arrows):
    """Tarjan's components of more than one folder, without recursion."""
    successors = defaultdict(set)
    for source, target in arrows:
        successors[source].add(target)
    index, low, on_stack, stack, components = {}, {}, set(), [], []
    for start in sorted(successors):
        if start in index:
            continue
        work = [(start, iter(sorted(successors[start])))]
        index[start] = low[start] = len(index)
        stack.append(start)
        on_stack.add(start)
        while work:
            folder, rest = work[-1]
            for target in rest:
                if target not in index:
                    index[target] = low[target] = len(index)
                    stack.append(target)
                    on_stack.add(target)
                    work.append((target, iter(sorted(successors[target]))))
                    break
                if target in on_stack:
                    low[folder] = min(low[folder], index[target])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[folder])
                if low[folder] == index[folder]:
                    component = set()
                    while folder not in component:
                        component.add(stack.pop())
                    on_stack -= component
                    if len(component) > 1:
                        components.append(component)
    return components


def shortest_circle(component, arrows):
    best = None
    for start in sorted(component):
        paths, seen = [[start]], {start}
        while paths:
            path = paths.pop(0)
            if best is not None and len(path) >= len(best):
                break
            following = sorted(target for source, target in arrows if source == path[-1] and target in component)
            if start in following:
                best = path
                break
            for target in following:
                if target not in seen:
                    seen.add(target)
                    paths.append([*path, target])
    return best


def circles(includes):
    """A sentence for each set of folders that include each other: the shortest circle in it and the lines that make it."""
    lines = defaultdict(list)
    for include in includes:
        if include.arrow[0] != include.arrow[1]:
            lines[include.arrow].append(include)
    for component in strongly_connected(lines):
        circle = shortest_circle(component, lines)
        sentence = [f"Include circle between folders: {' -> '.join([*circle, circle[0]])}"]
        for source, target in zip(circle, [*circle[1:], circle[0]]):
            found = lines[source, target]
            sentence += [f"    {include}" for include in found[:LINES_SHOWN]]
            if len(found) > LINES_SHOWN:
                sentence.append(f"    and {len(found) - LINES_SHOWN} more from {source} to {target}")
        others = sorted(component - set(circle))
        if others:
            sentence.append(f"    other folders that include each other here: {', '.join(others)}")
        yield "\n".join(sentence)


def tests_of_a_block(folder):
    """firmware/control/tests for firmware/control/tests and its sub-folders; None for a folder that is no block's
    tests."""
    match = re.match(r".+?/tests(?=/|$)", folder)
    return match.group() if match else None


def layer_of(folder, layers):
    """The most specific entry of may_include for the folder."""
    return max((layer for layer in layers["may_include"] if is_within(folder, layer)), key=len, default=None)


def is_allowed(source, target, layers):
    if tests_of_a_block(target):
        return tests_of_a_block(source) == tests_of_a_block(target)
    if tests_of_a_block(source):
        return True
    layer = layer_of(source, layers)
    if layer is None or layer == layer_of(target, layers):
        return True  # a folder without a layer has an error of its own
    return any(is_within(target, other) for other in layers["may_include"][layer])


def forbidden_arrows(includes, layers):
    for include in includes:
        source, target = include.arrow
        if is_allowed(source, target, layers):
            continue
        if tests_of_a_block(target):
            yield f"{include}, but the tests of a block are for themselves. Put what several tests share into tests/."
        else:
            layer = layer_of(source, layers)
            allowed = ", ".join([layer, *layers["may_include"][layer]])
            yield (f"{include}, but {layer} may include only: {allowed}. "
                   "Move what it needs downwards, or pass it in from above (layers.toml has the layers).")


def errors_of_layers(files, layers):
    folders = {folder_of(file) for file in files}
    for folder in sorted(folders):
        if layer_of(folder, layers) is None and not tests_of_a_block(folder):
            yield f"{folder} has no line in layers.toml: say under may_include what it may include."
    for layer, allowed in layers["may_include"].items():
        for name in [layer, *allowed]:
            if not any(is_within(folder, name) for folder in folders):
                yield f"layers.toml names {name}, but no source lies there."
    for root, users in layers["include_roots"].items():
        for name in [root, *users]:
            if not any(is_within(folder, name) for folder in folders):
                yield f"layers.toml names {name} under include_roots, but no source lies there."


def check(root, layers):
    """The includes, and a sentence for each error."""
    includes, errors = read_includes(root, layers)
    errors += errors_of_layers(sources(root, layers), layers)
    errors += circles(includes)
    errors += forbidden_arrows(includes, layers)
    return includes, errors


def main():
    parser = argparse.ArgumentParser(description="Find include circles between folders, and includes that layers.toml does not allow.")
    parser.add_argument("--arrows", action="store_true", help="print which folder includes which, and how often")
    arguments = parser.parse_args()
    includes, errors = check(ROOT, tomllib.loads(LAYERS.read_text()))
    arrows = defaultdict(int)
    for include in includes:
        arrows[include.arrow] += include.arrow[0] != include.arrow[1]
    if arguments.arrows:
        for (source, target), count in sorted(arrows.items()):
            if count:
                print(f"{source} -> {target} {count}")
    for error in errors:
        print(error)
    print(f"{len(includes)} includes, {sum(count > 0 for count in arrows.values())} arrows between folders, {len(errors)} errors.")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
