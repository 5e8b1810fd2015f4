#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds what a Mac would read of platform/apple and the Apple apps, as far as that needs no Mac: property lists, privacy manifest, the
module of C headers, the Swift package and the project files. Exit 1 names each fault."""
import pathlib
import plistlib
import re
import sys

# Apple's ImageIO writes PNG, and Metal blends the splats.
NOT_FOR_APPLE = {"doppel_vulkan.h", "doppel_png.h", "doppel_splats.h"}
APPS = ("apps/ios", "apps/visionos")
USAGE = {"ARBodyTrackingConfiguration": "NSCameraUsageDescription", "CompositorRenderer": "NSWorldSensingUsageDescription"}
REASONS = re.compile(r"[0-9A-F]{4}\.[0-9]")


def plists(root):
    for folder in ("platform/apple", *APPS):
        yield from sorted(f for f in (root / folder).rglob("*") if f.suffix in (".plist", ".xcprivacy"))


def plist_problems(root):
    found = list(plists(root))
    if not any(f.suffix == ".xcprivacy" for f in found):
        yield "platform/apple: no privacy manifest (PrivacyInfo.xcprivacy)"
    for file in found:
        name = file.relative_to(root).as_posix()
        try:
            content = plistlib.loads(file.read_bytes())
        except Exception as error:  # the parsers of plistlib raise many kinds
            yield f"{name}: not a property list: {error}"
            continue
        if file.suffix == ".xcprivacy":
            wanted = {"NSPrivacyTracking", "NSPrivacyTrackingDomains", "NSPrivacyCollectedDataTypes", "NSPrivacyAccessedAPITypes"}
            if set(content) != wanted:
                yield f"{name}: its keys should be {', '.join(sorted(wanted))}"
            for api in content.get("NSPrivacyAccessedAPITypes", []):
                reasons = api.get("NSPrivacyAccessedAPITypeReasons", [])
                if not reasons or not all(REASONS.fullmatch(r) for r in reasons):
                    yield f"{name}: {api.get('NSPrivacyAccessedAPIType')} needs reasons such as C617.1"


def header_problems(root):
    public = {f.name for f in (root / "sdk/include/doppel").glob("*.h")} - NOT_FOR_APPLE
    shim = (root / "platform/apple/Sources/CDoppel/CDoppel.h").read_text()
    listed = set(re.findall(r"^#include <doppel/(\w+\.h)>", shim, re.MULTILINE))
    for header in sorted(public - listed):
        yield f"platform/apple/Sources/CDoppel/CDoppel.h: does not include doppel/{header} (or name it in tests/apple/check_apple.py)"
    for header in sorted(listed - public):
        yield f"platform/apple/Sources/CDoppel/CDoppel.h: includes doppel/{header}, which is no header for Apple's platforms"


def package_problems(root):
    package = root / "platform/apple"
    text = (package / "Package.swift").read_text()
    targets = re.findall(r'\.target\(\s*name: "(\w+)"', text)
    for name in targets:
        if not list((package / "Sources" / name).glob("*.swift")):
            yield f"platform/apple/Package.swift: target {name} has no sources in Sources/{name}"
    for name in re.findall(r'\.testTarget\(name: "(\w+)"', text):
        if not list((package / "Tests" / name).glob("*.swift")):
            yield f"platform/apple/Package.swift: test target {name} has no sources in Tests/{name}"
    for target, resource in re.findall(r'\.target\(\s*name: "(\w+)"[^\n]*?\.copy\("([^"]+)"\)', text):
        if not (package / "Sources" / target / resource).exists():
            yield f"platform/apple/Package.swift: {target} copies {resource}, which does not exist"
    for path in re.findall(r'systemLibrary\(name: "\w+", path: "([^"]+)"', text):
        if not (package / path / "module.modulemap").exists():
            yield f"platform/apple/Package.swift: {path} has no module.modulemap"
    if not targets:
        yield "platform/apple/Package.swift: names no target"


def app_problems(root):
    for app in APPS:
        folder = root / app
        if not folder.exists():
            continue
        project = (folder / "project.yml").read_text()
        for path in re.findall(r"^\s*(?:- )?path: (\S+)$", project, re.MULTILINE):
            if not (folder / path).exists():
                yield f"{app}/project.yml: {path} does not exist"
        code = "\n".join(f.read_text() for f in sorted(folder.rglob("*.swift")))
        info = plistlib.loads((folder / "Info.plist").read_bytes())
        for word, key in USAGE.items():
            if word in code and not info.get(key):
                yield f"{app}/Info.plist: the app uses {word}, so {key} must tell people why"


def problems(root):
    yield from plist_problems(root)
    yield from header_problems(root)
    yield from package_problems(root)
    yield from app_problems(root)


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    found = list(problems(root))
    print("\n".join(found) if found else f"{len(list(plists(root)))} property lists, the package and the module are whole")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
