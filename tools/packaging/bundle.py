#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes an installation relocatable: copies what its programs load beside them, except what every Linux has or must choose itself.

    bundle.py PREFIX     PREFIX: an installation with bin and lib

Libraries of libdoppel and the viewer go to lib/doppel, the others of `doppel` to lib/doppel/tool. Programs find them by a run path relative
to themselves, which libraries that they load inherit (DT_RPATH). Each library's copyright file goes to licences/PACKAGE, and licences/contents.txt lists
them, which the bill of materials reads. Needs patchelf.
"""
import importlib.machinery
import importlib.util
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
# The C library must be the system's. libstdc++, zlib and zstd are loaded by graphics drivers too, which may need newer ones than ours.
OF_THE_SYSTEM = re.compile(r"^(ld-linux.*|lib(c|m|dl|rt|pthread|gcc_s|stdc\+\+|z|zstd|vulkan))\.so")
# The window must use the system's X11 and GL, because the driver does. OpenCV links them without using them, so `doppel` gets its own.
OF_THE_DESKTOP = re.compile(r"^lib(X11|X11-xcb|xcb|Xau|Xdmcp|bsd|md|GLX|GLdispatch|OpenGL|GL|EGL)\.so")
SPDX = {"LGPL-2.1+": "LGPL-2.1-or-later", "libpng": "Libpng", "public domain": "LicenseRef-public-domain",
        "IJG, BSD-3-Clause and Zlib": "IJG AND BSD-3-Clause AND Zlib",
        "GPL-3.0 with the GCC runtime library exception: programs that link it keep their own licence":
            "GPL-3.0-or-later WITH GCC-exception-3.1"}


def licences_tool():
    """tools/licences, which knows the licence of every library that our programs load."""
    loader = importlib.machinery.SourceFileLoader("licences", str(ROOT / "tools" / "licences"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("licences", loader))
    sys.dont_write_bytecode = True
    loader.exec_module(module)
    return module


def loaded(path):
    """Name -> file of everything that the dynamic linker loads for a program."""
    out = subprocess.run(["ldd", path], capture_output=True, text=True, check=True).stdout
    if "not found" in out:
        sys.exit(f"{path}: {out}")
    return dict(re.findall(r"^\s*(\S+) => (/\S+)", out, re.MULTILINE))


def take(found, folder, unwanted, taken):
    for name, file in sorted(found.items()):
        if name in taken or name.startswith("libdoppel.so") or any(pattern.match(name) for pattern in unwanted):
            continue
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(os.path.realpath(file), folder / name)
        (folder / name).chmod(0o644)
        taken[name] = os.path.realpath(file)


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    prefix = pathlib.Path(sys.argv[1])
    library = next(f for f in sorted((prefix / "lib").glob("libdoppel.so.*")) if not f.is_symlink())
    programs = sorted((prefix / "bin").iterdir())
    taken = {}
    for file in [library] + [p for p in programs if p.name != "doppel"]:
        take(loaded(file), prefix / "lib/doppel", (OF_THE_SYSTEM, OF_THE_DESKTOP), taken)
    take(loaded(prefix / "bin/doppel"), prefix / "lib/doppel/tool", (OF_THE_SYSTEM,), taken)
    for program in programs:
        places = ["lib", "lib/doppel"] + (["lib/doppel/tool"] if program.name == "doppel" else [])
        path = ":".join(f"$ORIGIN/../{place}" for place in places)
        subprocess.run(["patchelf", "--force-rpath", "--set-rpath", path, program], check=True)
    subprocess.run(["patchelf", "--force-rpath", "--set-rpath", "$ORIGIN/doppel", library], check=True)

    licences, lines = licences_tool(), []
    for name, file in sorted(taken.items()):
        package = licences.package_of(file)
        known = licences.LICENCES.get(licences.family(package)) if package else None
        if known is None:
            sys.exit(f"{file}: its licence is not known; read /usr/share/doc/{package}/copyright and add {package} to tools/licences")
        if known[1]:
            sys.exit(f"{file}: {package} has GPL parts, and an archive with it may be passed on only under the GPL")
        version = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", package], capture_output=True, text=True, check=True).stdout
        lines.append(f"CONTAINS {package} {version} {SPDX.get(known[0], known[0])}")
        folder = prefix / "licences" / package
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(f"/usr/share/doc/{package}/copyright", folder / "copyright")
    (prefix / "licences/contents.txt").write_text("\n".join(sorted(set(lines))) + "\n")
    print(f"{len(taken)} libraries beside the programs of {prefix.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
