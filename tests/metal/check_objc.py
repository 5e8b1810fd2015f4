#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the types of our Objective-C++, and of that of the guide, with clang, against declarations of Apple's frameworks that we wrote (apple_stubs). Then breaks
copies of it, to show that the check sees what Apple's compiler would refuse. Exit 1 names what is wrong, 77 says why nothing was checked.

    tests/metal/check_objc.py ROOT CLANG++
"""
import pathlib
import re
import subprocess
import sys
import tempfile

FLAGS = ["-fsyntax-only", "-x", "objective-c++", "-std=c++20", "-Wall", "-Wextra", "-Wno-missing-field-initializers", "-Werror", "-fobjc-arc", "-fblocks",
         "-fobjc-runtime=gnustep-2.0", "-fconstant-string-class=NSConstantString"]
FILES = ["sdk/backend/metal/mtl_apple.mm", "sdk/backend/metal/mtl_apple_values.mm"]
# What is broken, in which file, the text, what replaces it, and what clang says then.
FAULTS = [
    ("a wrong selector", FILES[0], "[objectOf(commands) waitUntilCompleted]", "[objectOf(commands) waitUntilComplete]", "waitUntilComplete'"),
    ("a wrong property", FILES[0], "how.rasterSampleCount", "how.rasterSamples", "rasterSamples"),
    ("a wrong type", FILES[0], "offset:offset atIndex:index", "offset:buffer atIndex:index", "BufferRef"),
    ("an object of another kind", FILES[0], "waitForFence:objectOf(fence)]", "waitForFence:objectOf(encoder)]", "MTLFence"),
    ("a transfer without a bridge", FILES[0], "(__bridge_retained void*)object", "(void*)object", "bridged cast"),
    ("another value of an enum", FILES[1], "DPL_SAME(PixelFormat::RG32Float, MTLPixelFormatRG32Float)",
     "DPL_SAME(PixelFormat::RG32Float, MTLPixelFormatRGBA16Float)", "static_assert"),
]
# Blocks of the guide begin with the names that they use.
GUIDE = "docs/guides/metal.md"
GIVEN = re.compile(r"// given: (.+)\n")
HEAD = "#include <doppel/doppel_metal.h>\nvoid complain(const char* text);\n"

def main():
    root, clang = pathlib.Path(sys.argv[1]), sys.argv[2]
    if clang.endswith("NOTFOUND"):
        print("skipped: no clang++ on this machine")
        return 77
    command = [clang, *FLAGS, "-I", str(root / "tests/metal/apple_stubs"), "-I", str(root), "-I", str(root / "sdk/include")]

    def check(path, mac):
        return subprocess.run([*command, f"-DDPL_CHECK_MAC={mac}", str(path)], capture_output=True, text=True)

    wrong = []
    blocks = re.findall(r"```objc\n(.*?)```", (root / GUIDE).read_text(), re.DOTALL)
    with tempfile.TemporaryDirectory() as folder:
        guide = pathlib.Path(folder) / "guide.mm"
        functions = [f"void block{i}({GIVEN.match(b).group(1)});\nvoid block{i}({GIVEN.match(b).group(1)}) {{\n{b}}}\n"
                     for i, b in enumerate(blocks)]
        guide.write_text(HEAD + "\n".join(functions))
        for path, systems in [(root / f, (1, 0)) for f in FILES] + [(guide, (1,))]:
            for mac in systems:
                got = check(path, mac)
                if got.returncode or got.stderr:
                    wrong.append(f"{path}, {'macOS' if mac else 'iOS'}:\n{got.stderr}")
        guide.write_text(guide.read_text().replace("dplMetalPrepare(context, commands,", "dplMetalPrepare(context, encoder,"))
        if "MTLCommandBuffer" not in check(guide, 1).stderr:
            wrong.append("an encoder in place of the command buffer of dplMetalPrepare is not noticed")
        for what, file, before, after, said in FAULTS:
            source = (root / file).read_text()
            if before not in source:
                wrong.append(f"{what}: {file} no longer contains {before}")
                continue
            broken = pathlib.Path(folder) / "broken.mm"
            broken.write_text(source.replace(before, after))
            if said not in check(broken, 1).stderr:
                wrong.append(f"{what} is not noticed: {after}")
    print("\n".join(wrong) if wrong else f"{len(FILES)} files and {len(blocks)} blocks of the guide fit the declarations; {len(FAULTS) + 1} faults were noticed")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
