#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds the layout of C and C++ files: clang-format 14 changes nothing. Lines of Kotlin, Java, Swift, Gradle and XML have at most 140 columns.
Exit 1 names each file, 77 says why nothing was checked.

    tests/structure/check_format.py [ROOT]          check
    tests/structure/check_format.py [ROOT] --fix    rewrite the files that differ
"""
import os
import pathlib
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

VERSION = "14"  # other versions lay out a few constructs differently
SKIPPED = 77
COLUMNS = 140


def formatter():
    """The path of clang-format 14, or None."""
    for name in (f"clang-format-{VERSION}", "clang-format"):
        path = shutil.which(name)
        if path and f"version {VERSION}." in subprocess.run([path, "--version"], capture_output=True, text=True).stdout:
            return path
    return None


def sources(root):
    for folder in ("sdk", "platform", "shaders", "apps", "reconstruction", "tools", "tests"):
        for suffix in ("*.h", "*.hpp", "*.c", "*.cpp", "*.mm"):
            yield from sorted((root / folder).rglob(suffix))


def long_lines(root):
    for folder in ("platform", "apps", "tests"):
        for suffix in ("*.kt", "*.java", "*.swift", "*.kts", "*.xml"):
            for path in sorted((root / folder).rglob(suffix)):
                for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                    if len(line) > COLUMNS:
                        yield f"{path.relative_to(root).as_posix()}:{number}: {len(line)} columns, at most {COLUMNS} are"


def main():
    arguments = [a for a in sys.argv[1:] if a != "--fix"]
    root = pathlib.Path(arguments[0] if arguments else ".").resolve()
    program = formatter()
    if program is None:
        print(f"skipped: clang-format {VERSION} is not installed; other versions lay out a few constructs differently")
        return SKIPPED
    files = list(sources(root))
    if "--fix" in sys.argv:
        subprocess.run([program, "-i", *files], check=True)
        return 0
    batches = [files[i :: os.cpu_count()] for i in range(os.cpu_count())]
    with ThreadPoolExecutor() as pool:
        runs = list(pool.map(lambda batch: subprocess.run([program, "--dry-run", "-Werror", *batch], capture_output=True, text=True), batches))
    reports = "".join(run.stderr for run in runs)
    wrong = [f.relative_to(root).as_posix() for f in files if f"{f}:" in reports]
    if not wrong and any(run.returncode for run in runs):
        print(reports)
        return 1
    for name in wrong:
        print(f"{name}: not laid out by clang-format {VERSION}; run tests/structure/check_format.py --fix")
    too_long = list(long_lines(root))
    for line in too_long:
        print(line)
    print(f"{len(files)} files checked, {len(wrong)} differ; {len(too_long)} lines are too long")
    return 1 if wrong or too_long or not files else 0


if __name__ == "__main__":
    sys.exit(main())
