#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds the licence line: every source file names its licence within its first two lines. Exit 1 names each file that does not."""
import pathlib
import sys

LINE = "SPDX-License-Identifier: Apache-2.0"
FOLDERS = ("sdk", "platform", "shaders", "apps", "reconstruction", "tools", "tests", ".ci")
SOURCES = {".h", ".hpp", ".c", ".cpp", ".mm", ".glsl", ".comp", ".vert", ".frag", ".py", ".sh", ".mjs", ".js", ".cmake", ".swift", ".kt", ".java"}


def is_source(path):
    if path.suffix in SOURCES or path.name == "CMakeLists.txt" or path.name.endswith(".cmake.in"):
        return True
    return path.suffix == "" and path.read_bytes()[:2] == b"#!"


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    files = [f for folder in FOLDERS for f in sorted((root / folder).rglob("*")) if f.is_file() and is_source(f)]
    bare = [f for f in files if LINE not in "\n".join(f.read_text(errors="replace").split("\n", 2)[:2])]
    for f in bare:
        print(f"{f.relative_to(root).as_posix()}: its first or second line must say {LINE}")
    print(f"{len(files)} files checked, {len(bare)} without the line")
    return 1 if bare or not files else 0


if __name__ == "__main__":
    sys.exit(main())
