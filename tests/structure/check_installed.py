#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds the target doppel_installed: it builds every target that an install() copies, so that `cmake --install` works after it alone.
usage: check_installed.py ROOT"""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
built = re.search(r"add_custom_target\(doppel_installed\).*?foreach\(target ([^)]*)\)", (root / "CMakeLists.txt").read_text(), re.DOTALL)
names = built.group(1).split() if built else []
missing, copied = [], 0
for room in ("sdk", "platform", "apps", "reconstruction"):
    for path in sorted((root / room).rglob("CMakeLists.txt")):
        for targets in re.findall(r"install\(TARGETS ([a-z_ ]+)", path.read_text()):
            copied += len(targets.split())
            missing += [f"{path.relative_to(root)}: doppel_installed does not build {t}" for t in targets.split() if t not in names]
print("\n".join(missing + [f"{copied} installed targets, {len(missing)} missing"]))
sys.exit(1 if missing or not copied else 0)
