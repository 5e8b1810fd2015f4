#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The licences of everything inside a Debian package or an archive: Doppel's own, and the texts of what is compiled in.

    notices.py WHAT FILE     write the copyright file of libdoppel1, libdoppel-dev, doppel-tools, doppel-viewer, linux (the archive, where
                             libraries that lie beside the programs have files of their own), windows (the zip) or web (the npm package)
"""
import gzip
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
DOC = pathlib.Path("/usr/share/doc")
WEB_DOC = ROOT / "build/toolchains/web/usr/share/doc"  # of the packages that tools/deps web unpacks and does not install

# Debian package -> SPDX licence, of what the compiler copies into our binaries: headers, and the static library of Ceres. Sources: the
# copyright files of these packages. docs/licences.md says the same in prose.
LIBRARY = {"libtinygltf-dev": "MIT", "nlohmann-json3-dev": "MIT", "libglm-dev": "MIT", "libxxhash-dev": "BSD-2-Clause",
           "libvulkan-dev": "Apache-2.0"}
GCC = "GPL-3.0-or-later WITH GCC-exception-3.1"
# tools/deps web builds its libraries from the sources of these packages.
WEB = {**{name: licence for name, licence in LIBRARY.items() if name != "libvulkan-dev"}, "libdraco-dev": "Apache-2.0",
       "libhwy-dev": "Apache-2.0", "libzstd-dev": "BSD-3-Clause", "zlib1g-dev": "Zlib", "wasi-libc": "CC0-1.0 AND BSD-2-Clause AND MIT",
       "libc++-19-dev-wasm32": "Apache-2.0 WITH LLVM-exception", "libc++abi-19-dev-wasm32": "Apache-2.0 WITH LLVM-exception",
       "libclang-rt-19-dev-wasm32": "Apache-2.0 WITH LLVM-exception"}
# doppel-tools and the archive hold the web module where it was built before them, as tools/release does (apps/doppel/CMakeLists.txt).
WEB_IN_TOOLS = WEB if (ROOT / "build/web/platform/web/doppel.wasm").exists() else {}
COMPILED_IN = {
    "libdoppel1": LIBRARY,
    "libdoppel-dev": LIBRARY,
    "web": WEB,
    "doppel-tools": {**LIBRARY, **WEB_IN_TOOLS, "libceres-dev": "BSD-3-Clause", "libeigen3-dev": "MPL-2.0", "libcli11-dev": "BSD-3-Clause",
                     "libnanoflann-dev": "BSD-2-Clause", "libtomlplusplus-dev": "MIT"},
    "doppel-viewer": {"libimgui-dev": "MIT", "libstb-dev": "MIT", "libcli11-dev": "BSD-3-Clause", "nlohmann-json3-dev": "MIT",
                      "libglm-dev": "MIT", "libvulkan-dev": "Apache-2.0", "libopenxr-dev": "Apache-2.0"},
    # The DLL holds its libraries and the compiler's run time. tools/deps builds them from the sources of these packages.
    "windows": {**LIBRARY, "libdraco-dev": "Apache-2.0", "libhwy-dev": "Apache-2.0", "libzstd-dev": "BSD-3-Clause", "zlib1g-dev": "Zlib",
                "mingw-w64-common": "ZPL-2.1 AND LicenseRef-public-domain AND MIT AND BSD-3-Clause", "gcc-mingw-w64-base": GCC},
}
COMPILED_IN["linux"] = {name: licence for package in COMPILED_IN if package not in ("windows", "web")
                        for name, licence in COMPILED_IN[package].items()}


def version_of(package):
    """The version that is installed here, which is the one that was compiled in."""
    found = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", package], capture_output=True, text=True, check=False)
    changes = WEB_DOC / package / "changelog.Debian.gz"
    if found.returncode and changes.exists():
        return re.search(r"\(([^)]*)\)", gzip.decompress(changes.read_bytes()).decode(errors="replace")).group(1)
    if found.returncode:
        sys.exit(f"{package} is not installed; run tools/bootstrap, and for the web module tools/deps web")
    return found.stdout


def copyright_of(package):
    """The text of Debian's copyright file."""
    path = next((doc / package / "copyright" for doc in (DOC, WEB_DOC) if (doc / package / "copyright").exists()), None)
    if path is None:
        sys.exit(f"{DOC / package / 'copyright'} is not there; install {package}, or run tools/bootstrap, and for the web module "
                 "tools/deps web")
    return path.read_text(encoding="utf-8", errors="replace")


def notices(package):
    """The copyright file of one of our packages."""
    parts = [f"Doppel\nCopyright 2026 The Doppel authors\nLicensed under the Apache License, Version 2.0; on Debian the text is in\n"
             f"/usr/share/common-licenses/Apache-2.0.\n\n{(ROOT / 'NOTICE').read_text(encoding='utf-8')}"]
    for name, licence in sorted(COMPILED_IN[package].items()):
        parts.append(f"Compiled in: {name.removesuffix('-dev')} ({licence}). What Debian says of it:\n\n{copyright_of(name)}")
    return f"\n{'-' * 78}\n\n".join(part.rstrip() + "\n" for part in parts)


def main():
    if {"-h", "--help"} & set(sys.argv[1:]) or len(sys.argv) != 3 or sys.argv[1] not in COMPILED_IN:
        print(__doc__, file=sys.stderr)
        return 2
    out = pathlib.Path(sys.argv[2])
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(notices(sys.argv[1]), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
