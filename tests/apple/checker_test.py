#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Breaks a copy of what check_apple.py reads, in one way at a time, and expects it to notice."""
import pathlib
import shutil
import sys
import tempfile

import check_apple

ROOT = pathlib.Path(sys.argv[1]).resolve()
CDOPPEL = "platform/apple/Sources/CDoppel/CDoppel.h"
FAULTS = [  # file, what is replaced, by what, what the checker must say
    ("platform/apple/Sources/Doppel/PrivacyInfo.xcprivacy", "</dict>\n</plist>", "</plist>", "not a property list"),
    ("platform/apple/Sources/Doppel/PrivacyInfo.xcprivacy", "C617.1", "because", "needs reasons"),
    ("platform/apple/Sources/Doppel/PrivacyInfo.xcprivacy", "NSPrivacyTrackingDomains", "NSPrivacyDomains", "keys should be"),
    (CDOPPEL, "#include <doppel/doppel_convert.h>\n", "", "does not include doppel/doppel_convert.h"),
    (CDOPPEL, "doppel_convert.h>", "doppel_vulkan.h>", "no header for Apple's platforms"),
    ("platform/apple/Package.swift", '.target(name: "DoppelUI"', '.target(name: "DoppelUX"', "target DoppelUX has no sources"),
    ("platform/apple/Package.swift", "PrivacyInfo.xcprivacy", "Privacy.xcprivacy", "does not exist"),
    ("apps/ios/project.yml", "path: ../../platform/apple", "path: ../../platform/pear", "../../platform/pear does not exist"),
    ("apps/ios/Info.plist", "NSCameraUsageDescription", "NSCamera", "NSCameraUsageDescription must tell"),
    ("apps/visionos/Info.plist", "NSWorldSensingUsageDescription", "NSWorld", "NSWorldSensingUsageDescription must tell"),
]


def copy_of(root, folder):
    for part in ("platform/apple", "sdk/include", "apps/ios", "apps/visionos"):
        if (root / part).exists():
            shutil.copytree(root / part, folder / part, ignore=shutil.ignore_patterns("build", ".build"))


def main():
    missed = 0
    for file, old, new, wanted in FAULTS:
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            copy_of(ROOT, folder)
            text = (folder / file).read_text()
            if old not in text:
                print(f"{file} has no '{old}' to break")
                missed += 1
                continue
            (folder / file).write_text(text.replace(old, new))
            found = list(check_apple.problems(folder))
            if not any(wanted in line for line in found):
                print(f"{file}: '{old}' became '{new}', and the checker said {found or 'nothing'}")
                missed += 1
    print(f"{len(FAULTS)} planted faults, {missed} not found")
    return 1 if missed or not FAULTS else 0


if __name__ == "__main__":
    sys.exit(main())
