#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds docs/benchmarks.md and docs/benchmarks/*.md to the raw figures in docs/benchmarks/*.json: writes the pages again and compares.

    tests/structure/check_benchmarks.py [ROOT]      exit 1 names each page that differs
"""
import pathlib
import subprocess
import sys
import tempfile


def pages(folder):
    """Path below the folder -> bytes, of everything that publish writes."""
    found = [folder / "benchmarks.md", *sorted((folder / "benchmarks").glob("*.md")), *sorted((folder / "benchmarks").glob("*.svg"))]
    return {str(path.relative_to(folder)): path.read_bytes() for path in found if path.exists()}


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, root / "tools/bench/publish", "--render-only", "--out", folder], check=True, stdout=subprocess.DEVNULL)
        fresh, kept = pages(pathlib.Path(folder)), pages(root / "docs")
    wrong = sorted(name for name in fresh.keys() | kept.keys() if fresh.get(name) != kept.get(name))
    for name in wrong:
        why = "is not written by publish" if name not in fresh else "is missing" if name not in kept else "differs from its raw figures"
        print(f"docs/{name} {why}; run tools/bench/publish --render-only")
    if not wrong:
        print(f"{len(kept)} pages agree with their raw figures")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
