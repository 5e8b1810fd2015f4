#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds the one-definition rule across files: no two files define types of the same name in the same namespace.

The linker merges the functions of two such types without a word, so a vector of one is then handled with the size of the other. Tests may
repeat names of other tests, whose programs are apart, but none of the rest. Exit 1 names each pair.
"""
import collections
import pathlib
import re
import sys

FOLDERS = ("sdk", "platform", "apps", "reconstruction", "tools", "tests")
SOURCES = {".h", ".hpp", ".cpp", ".mm"}
OPENED = re.compile(r"(?:inline )?namespace(?: ([\w:]+))?\s*\{")
CLOSED = re.compile(r"\}\s*//\s*(?:anonymous )?namespace")
DEFINED = re.compile(r"(?:struct|class|union|enum(?: class)?)\s+(?:alignas\(\w+\)\s+)?(\w+)(?:\s+final)?\s*(?::(?!:)[^;]*)?\{")


def types_of(text):
    """Types that a file defines at the left margin outside anonymous namespaces, with their namespaces."""
    inside = []
    for line in text.splitlines():
        if opened := OPENED.match(line):
            inside.append(opened[1])
        elif CLOSED.match(line):
            inside = inside[:-1]
        elif None not in inside and (defined := DEFINED.match(line)):
            yield "::".join([*inside, defined[1]])


def repeated(files):
    """{type: files} of types that two files define, of which at most one is a test. files: {path: text}."""
    where = collections.defaultdict(list)
    for path, text in files.items():
        for name in set(types_of(text)):
            where[name].append(path)
    return {name: paths for name, paths in where.items() if len(paths) > 1 and not all(p.startswith("tests/") for p in paths)}


def check_itself():
    a, b = "namespace dpl {\nstruct A final : B {\n};\n}  // namespace dpl\n", "namespace dpl {\nclass alignas(16) A {\n};\n"
    hidden = "namespace dpl {\nnamespace {\nstruct A {\n};\n}  // namespace\nstruct A::Parts {\n};\nstruct A;\n"
    assert repeated({"sdk/a.h": a, "apps/b.h": b, "apps/c.cpp": hidden}) == {"dpl::A": ["sdk/a.h", "apps/b.h"]}
    assert repeated({"sdk/a.h": a, "tests/b.h": b}) and not repeated({"tests/a.h": a, "tests/b.h": b})


def main():
    check_itself()
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    paths = [f for folder in FOLDERS for f in sorted((root / folder).rglob("*")) if f.suffix in SOURCES]
    files = {f.relative_to(root).as_posix(): f.read_text(errors="replace") for f in paths}
    found = repeated(files)
    for name, where in sorted(found.items()):
        print(f"{name} is defined by {' and by '.join(where)}: rename one, or put it into an anonymous namespace")
    print(f"{len(files)} files checked, {len(found)} names repeated")
    return 1 if found or not files else 0


if __name__ == "__main__":
    sys.exit(main())
