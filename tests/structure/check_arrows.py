#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds the include arrows of the house: which room may include which (docs/overview.md). Exit 1 names each line that breaks one."""
import pathlib
import re
import sys

SDK = {
    "sdk/core": [],
    "sdk/math": ["sdk/core"],
    "sdk/format": ["sdk/core", "sdk/math"],
    "sdk/avatar": ["sdk/core", "sdk/math", "sdk/format"],
    "sdk/motion": ["sdk/core", "sdk/math", "sdk/format", "sdk/avatar"],
    "sdk/visibility": ["sdk/core", "sdk/math", "sdk/format", "sdk/avatar"],
    "sdk/surface": ["sdk/core", "sdk/math", "sdk/format", "sdk/avatar"],
    "sdk/draw": ["sdk/core", "sdk/math", "sdk/format", "sdk/avatar", "sdk/visibility"],
    "sdk/splat": ["sdk/core", "sdk/math", "sdk/format", "sdk/avatar", "sdk/visibility", "sdk/draw"],
    "sdk/backend": ["sdk/core", "shaders/shared"],
    "sdk/render": ["sdk/core", "sdk/math", "sdk/format", "sdk/avatar", "sdk/visibility", "sdk/draw", "sdk/backend", "shaders/shared"],
    "sdk/api": ["sdk"],
    "sdk/include": [],
}
RULES = dict(SDK)
RULES["platform"] = []
# The wings of reconstruction and their rooms, from below: a room includes rooms of the wings before its own, and the rooms before it there.
WINGS = {
    "base": [],
    "input": ["cameras", "capture", "observe", "import"],
    "subject": ["shape", "body", "hands", "surface", "registration", "garments", "face", "sample"],
    "training": ["correctives", "trainer", "gpu"],
    "output": ["package", "dress", "page"],
    "judging": ["coach", "report", "evidence", "ladder"],
    "run": [],
}
BELOW = ["sdk/core", "sdk/math", "sdk/format", "sdk/avatar", "sdk/motion", "sdk/splat"]
for wing, rooms in WINGS.items():
    for place, name in enumerate(rooms):
        RULES[f"reconstruction/{wing}/{name}"] = BELOW + [f"reconstruction/{wing}/{earlier}" for earlier in rooms[:place]]
    RULES[f"reconstruction/{wing}"] = list(BELOW)
    BELOW = BELOW + [f"reconstruction/{wing}"]
RULES["reconstruction/training/gpu"] += ["sdk/backend", "sdk/render", "shaders/training/shared"]
RULES["apps"] = ["apps", "platform", "reconstruction", "sdk/core", "sdk/math"]
# The referee judges the fast code, so of that it may include only data types, file readers and what loading does to a file.
RULES["apps/reference"] = ["sdk/core", "sdk/format", "sdk/avatar/cloth_bounds.h", "sdk/avatar/rig.h", "sdk/math/camera.h"]
RULES["apps/xr"] = ["apps/xr", "apps/shared", "platform", "reconstruction/base", "sdk/core", "sdk/math"]
RULES["apps/shared"] = ["reconstruction/base", "sdk/core", "sdk/math"]
RULES["apps/viewer"] = ["apps/shared", "platform", "reconstruction/base", "sdk/core", "sdk/math"]
RULES["apps/bench"] = ["apps/shared", "apps/reference", "reconstruction/base", "reconstruction/output/package", "reconstruction/run", "reconstruction/judging/report", "sdk/core", "sdk/math"]
RULES["tools"] = ["sdk", "shaders", "tools", "reconstruction", "apps/bench", "apps/shared", "apps/reference"]
# Public headers are included as <doppel/...>; a room not named here must not know them.
PUBLIC_USERS = ("sdk/api", "sdk/include", "sdk/backend/metal", "platform", "apps", "reconstruction/judging/report", "reconstruction/base/sdk_camera.h", "tests", "tools")
THIRD_PARTY = {  # heavy libraries stay in their rooms
    "opencv2": ("reconstruction", "apps", "tests", "tools"),
    "ceres": ("reconstruction", "tests"),
    "Eigen": ("reconstruction", "tests"),
    "embree3": ("reconstruction", "tests"),
    "vulkan": ("sdk/backend/vulkan", "sdk/include", "platform", "apps/xr", "tests"),
    "Metal": ("sdk/backend/metal", "sdk/include", "platform", "apps", "tests"),
    "openxr": ("platform/openxr", "tests"),
    "tiny_gltf.h": ("sdk/format",),
    "draco": ("sdk/format", "tests"),
    "GLFW": ("platform/desktop",),
    "jni.h": ("platform/android", "platform/openxr", "apps/xr/android", "tests/android"),
    "android": ("platform/android", "platform/openxr", "apps/xr/android"),
    "imgui.h": ("platform/desktop", "apps/viewer"),
}
# Modules that Swift code may import, ours and Apple's; None: any of Apple's.
SWIFT = {
    "platform/apple/Sources/Doppel": ({"CDoppel"}, {"Foundation"}),
    "platform/apple/Sources/DoppelUI": ({"CDoppel", "Doppel"}, None),
    "platform/apple/Sources/DoppelRealityKit": ({"Doppel", "DoppelUI"}, None),
    "apps/ios": ({"Doppel", "DoppelUI"}, None),
    "apps/visionos": ({"Doppel", "DoppelUI"}, None),
}
SWIFT_IMPORT = re.compile(r"^\s*(?:@\w+ )?import (\w+)")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^">]+)[">]')


def room_of(path):
    """The longest rule that is a prefix of the path, or None for free rooms (tests, docs)."""
    best = None
    for room in RULES:
        if path.startswith(room + "/") and (best is None or len(room) > len(best)):
            best = room
    return best


def problems(root):
    for file in sorted(root.rglob("*")):
        if file.suffix not in {".h", ".hpp", ".cpp", ".c", ".mm"}:
            continue
        path = file.relative_to(root).as_posix()
        if path.split("/")[0] in {"build", "out", "demo", "third_party"} or path.startswith("."):
            continue
        room = room_of(path)
        for number, line in enumerate(file.read_text(errors="replace").splitlines(), 1):
            match = INCLUDE.match(line)
            if not match:
                continue
            target = match.group(2)
            where = f"{path}:{number}: includes {target}"
            for library, users in THIRD_PARTY.items():
                if (target == library or target.startswith(library + "/")) and not path.startswith(users):
                    yield f"{where}; {library} is only for {', '.join(users)}"
            if target.startswith("doppel/") and not path.startswith(PUBLIC_USERS):
                yield f"{where}; the public header is for the product's users, not for {path.rsplit('/', 1)[0]}"
            if target.startswith("tests/") and not path.startswith("tests/"):
                yield f"{where}; nobody includes tests"
            if room is None or target.startswith(room + "/"):
                continue
            if re.match(r"(sdk|platform|shaders|apps|reconstruction|tools)/", target):
                if not any(target == allowed or target.startswith(allowed + "/") for allowed in RULES[room]):
                    yield f"{where}; {room} may include {', '.join(RULES[room]) or 'nobody'}"


def swift_problems(root):
    for room, (ours, apples) in SWIFT.items():
        for file in sorted((root / room).rglob("*.swift")):
            for number, line in enumerate(file.read_text().splitlines(), 1):
                match = SWIFT_IMPORT.match(line)
                if not match:
                    continue
                module = match.group(1)
                allowed = module in ours if "Doppel" in module else apples is None or module in apples
                if not allowed:
                    yield f"{file.relative_to(root).as_posix()}:{number}: imports {module}; {room} may import {', '.join(sorted(ours | (apples or set())))}"


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    found = [*problems(root), *swift_problems(root)]
    print("\n".join(found) if found else "every include follows the arrows")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
