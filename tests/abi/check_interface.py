#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares headers, exports, the C test and the C++ wrapper: check_interface.py SOURCE_DIR.
- Every function of the headers is in exports.txt, those of doppel_metal.h are in exports_metal.txt, and no other is.
- call_everything.c calls each exported function; tests/metal/metal_from_c.c those of Metal.
- doppel.hpp and its parts call each function of the headers, or unwrapped.txt says why not.
- Every struct of the headers has its size pinned in header_as_c.c, those of Metal in metal_from_c.c."""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
headers = root / "sdk/include/doppel"
abi = root / "tests/abi"


def code(path):
    text = re.sub(r"/\*.*?\*/", " ", path.read_text(), flags=re.S)
    return re.sub(r"//[^\n]*", " ", text)


declared = {}  # function -> header
structs = {}
for header in sorted(headers.glob("*.h")):
    text = code(header)
    for name in re.findall(r"\bDPL_(?:API|EXPERIMENTAL)\s+[\w\s*]+?\b(dpl\w+)\s*\(", text):
        declared[name] = header.name
    for name in re.findall(r"typedef struct (Dpl\w+)\s*\{", text):
        structs[name] = header.name


def listed(name):
    return {line for line in (abi / name).read_text().splitlines() if line.startswith("dpl")}


exports = {False: listed("exports.txt"), True: listed("exports_metal.txt")}  # by whether they are Metal's
from_c = {False: abi / "call_everything.c", True: root / "tests/metal/metal_from_c.c"}
called = {metal: set(re.findall(r"\b(dpl\w+)\s*\(", code(path))) for metal, path in from_c.items()}
wrapped = {name for part in headers.glob("*.hpp") for name in re.findall(r"\b(dpl\w+)\b", code(part))}
reasons = {}
for line in (abi / "unwrapped.txt").read_text().splitlines():
    if line and not line.startswith("#"):
        key, _, reason = line.partition(" ")
        reasons[key] = reason.strip()
pinned = {
    metal: set(re.findall(r"sizeof\((Dpl\w+)\)\s*==", code(path)))
    for metal, path in {False: abi / "header_as_c.c", True: from_c[True]}.items()
}

errors = []
if len(declared) < 50:
    errors.append(f"only {len(declared)} functions were found in the headers: does this check still read them?")
for name, header in sorted(declared.items()):
    metal = header == "doppel_metal.h"
    if name not in exports[metal]:
        errors.append(f"{name} of {header} is not in tests/abi/exports{'_metal' if metal else ''}.txt")
    elif name not in called[metal]:
        errors.append(f"{from_c[metal].relative_to(root)} does not call {name}")
    reason = reasons.get(name) or reasons.get(header)
    if name not in wrapped and not reason:
        errors.append(f"doppel.hpp does not wrap {name}; wrap it, or say in tests/abi/unwrapped.txt why not")
    if name in wrapped and reasons.get(name):
        errors.append(f"doppel.hpp wraps {name}, but tests/abi/unwrapped.txt says that it does not")
for name in sorted((exports[False] | exports[True]) - set(declared)):
    errors.append(f"{name} is exported, but no header declares it")
for name in sorted(set(reasons) - set(declared) - set(declared.values())):
    errors.append(f"tests/abi/unwrapped.txt names {name}, which does not exist")
for name, header in sorted(structs.items()):
    metal = header == "doppel_metal.h"
    if name not in pinned[metal]:
        errors.append(f"the size of {name} ({header}) is not pinned in tests/{'metal/metal_from_c.c' if metal else 'abi/header_as_c.c'}")
for error in errors:
    print(error)
if not errors:
    print(f"{len(declared)} functions and {len(structs)} structs in {len(set(declared.values()))} headers: exported, called from C, wrapped or excused, pinned")
sys.exit(bool(errors))
