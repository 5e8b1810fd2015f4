#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Packs platform/web as `npm pack` would: doppel-web-VERSION.tgz, for `npm install FILE`. Needs no npm. The same files give the same bytes.

    npm.py BUILT OUT VERSION EPOCH     BUILT: build/web/platform/web; OUT: a folder; EPOCH: the time of the files, seconds
"""
import gzip
import io
import pathlib
import subprocess
import sys
import tarfile

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import notices  # noqa: E402

ROOT = notices.ROOT
NPM = ROOT / "platform/web/npm"
BUILT_FILES = ("doppel.wasm", "doppel-splats.wasm", "doppel.js", "doppel-avatar.js", "webgl-renderer.js", "splat-pacer.js", "webxr.js",
               "three-group.js", "three-pass.js", "three-splats.js", "playcanvas-splats.js", "babylon-splats.js",
               "demo/index.html", "demo/demo.js", "demo/demo.css", "demo/three.html", "demo/three-demo.js")
TYPES = ("doppel-avatar.d.ts", "webgl-renderer.d.ts", "webxr.d.ts", "three-group.d.ts", "three-splats.d.ts", "playcanvas-splats.d.ts",
         "babylon-splats.d.ts")


def types():
    made = subprocess.run([sys.executable, NPM / "make_types.py", "/dev/stdout"], capture_output=True, check=False)
    if made.returncode:
        sys.exit(made.stderr.decode())
    return made.stdout


def contents(built, version):
    missing = [name for name in BUILT_FILES if not (built / name).exists()]
    if missing:
        sys.exit(f"npm.py: {built} lacks {', '.join(missing)}; build it with tools/prove-web --build")
    files = {name: (built / name).read_bytes() for name in BUILT_FILES}
    files["package.json"] = (NPM / "package.json.in").read_text(encoding="utf-8").replace("@VERSION@", version).encode()
    files["README.md"] = (NPM / "README.md").read_bytes()
    files["doppel.d.ts"] = types()
    files.update({name: (NPM / name).read_bytes() for name in TYPES})
    files["licences.txt"] = notices.notices("web").encode()
    for name in ("LICENSE", "NOTICE"):
        files[name] = (ROOT / name).read_bytes()
    return files


def main():
    if len(sys.argv) != 5 or {"-h", "--help"} & set(sys.argv[1:]):
        print(__doc__, file=sys.stderr)
        return 2
    built, out, version, epoch = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3], int(sys.argv[4])
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for name, data in sorted(contents(built, version).items()):
            member = tarfile.TarInfo(f"package/{name}")
            member.size, member.mtime, member.mode = len(data), epoch, 0o644
            tar.addfile(member, io.BytesIO(data))
    out.mkdir(parents=True, exist_ok=True)
    file = out / f"doppel-web-{version}.tgz"
    file.write_bytes(gzip.compress(packed.getvalue(), 9, mtime=0))
    print(f"{file}: {file.stat().st_size} bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
