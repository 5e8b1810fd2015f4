#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds the version: DPL_VERSION_TEXT of doppel.h is its one source, and what repeats it says the same.

    check_version.py ROOT [PROGRAM ...]     each PROGRAM answers --version with its name and the version
"""
import pathlib
import re
import subprocess
import sys

COPIES = {  # files that cannot read the header -> pattern of the version in them
    "apps/android/build.gradle.kts": r'versionName = "([^"]*)"',
    "apps/xr/android/build.gradle.kts": r'versionName = "([^"]*)"',
    "tools/packaging/vcpkg/vcpkg.json": r'"version-semver": "([^"]*)"',
}


def header_version(text):
    """The text, and what the numbers beside it say."""
    numbers = [re.search(rf"^#define DPL_VERSION_{part} (\d+)\b", text, re.MULTILINE).group(1) for part in ("MAJOR", "MINOR", "PATCH")]
    return re.search(r'^#define DPL_VERSION_TEXT "([^"]*)"', text, re.MULTILINE).group(1), ".".join(numbers)


def problems(root, programs):
    version, numbers = header_version((root / "sdk/include/doppel/doppel.h").read_text())
    if version.split("-")[0] != numbers:
        yield f"doppel.h: DPL_VERSION_TEXT is {version}, and the numbers beside it are {numbers}"
    printed = subprocess.run(["cmake", "-P", root / "tools/cmake/DoppelVersion.cmake"], capture_output=True, text=True, check=True).stdout
    wanted = f"{version} {numbers} {version.replace('-', '~', 1)}"
    if printed.strip() != wanted:
        yield f"tools/cmake/DoppelVersion.cmake says '{printed.strip()}' instead of '{wanted}'"
    elif subprocess.run(["dpkg", "--compare-versions", wanted.split()[2], "le", numbers], check=False).returncode != 0:
        yield f"{wanted.split()[2]} is newer than its release {numbers} for dpkg"
    for name, pattern in COPIES.items():
        found = re.findall(pattern, (root / name).read_text())
        if found != [version]:
            yield f"{name}: its version is {', '.join(found) or 'missing'}, and that of doppel.h is {version}"
    for program in programs:
        said = subprocess.run([program, "--version"], capture_output=True, text=True, check=False).stdout.strip()
        if said != f"{pathlib.Path(program).name} {version}":
            yield f"{program} --version says '{said}' instead of '{pathlib.Path(program).name} {version}'"


def main():
    found = list(problems(pathlib.Path(sys.argv[1]).resolve(), sys.argv[2:]))
    print("\n".join(found) or "the version is the same everywhere")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
