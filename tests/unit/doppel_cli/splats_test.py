#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Files of general splats through `doppel inspect`, `render` and `export`: what they state is heard, what is lost is said, and pictures
show what is small. Writes its own files; the reported inputs of ../shared/data/faults are tried where they are.
usage: splats_test.py DOPPEL MAKE_TINY_AVATAR WORKDIR FAULTS"""
import math
import os
import shutil
import struct
import subprocess
import sys
import zlib

doppel, make_tiny_avatar, work, faults = sys.argv[1:]
shutil.rmtree(work, ignore_errors=True)
os.makedirs(work)
os.chdir(work)
failures = 0
COLUMNS = ["x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"]


def check(good, what):
    global failures
    failures += not good
    print(("ok: " if good else "FAILED: ") + what, file=sys.stdout if good else sys.stderr)


def run(*words):
    """Exit code and all that was printed."""
    done = subprocess.run([doppel, *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          check=False)
    return done.returncode, done.stdout


def says(words, *patterns, code=0):
    """Runs `doppel WORDS`, which must end with `code` and print the patterns. Returns what was printed."""
    status, text = run(*words)
    missing = [p for p in patterns if p not in text]
    good = status == code and not missing
    check(good, " ".join(words) + ("" if good else f" (exit {status}, without {missing}): {text}"))
    return text


def write_ply(name, splats, comments=()):
    header = ["ply", "format binary_little_endian 1.0"] + ["comment " + c for c in comments] + [f"element vertex {len(splats)}"]
    header += ["property float " + c for c in COLUMNS] + ["end_header"]
    with open(name, "wb") as file:
        file.write("\n".join(header).encode() + b"\n")
        for splat in splats:
            file.write(struct.pack("<14f", *splat))


def splat(place, size, colour=(1, 1, 1), opacity=3.0):
    return [*place, *[(c - 0.5) / 0.28209479 for c in colour], opacity, *[math.log(size)] * 3, 1, 0, 0, 0]


def picture(name):
    """Rows of RGBA of an 8-bit PNG."""
    data, at, packed = open(name, "rb").read(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height = struct.unpack(">II", body[:8])
        if kind == b"IDAT":
            packed += body
        at += 12 + length
    raw, stride, rows = zlib.decompress(packed), 4 * width, [bytearray(4 * width)]
    for y in range(height):
        method, line, above = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)]), rows[-1]
        for x in range(stride):
            a, b, c = line[x - 4] if x >= 4 else 0, above[x], above[x - 4] if x >= 4 else 0
            p = a + b - c
            paeth = min((a, b, c), key=lambda v: abs(p - v))
            line[x] = (line[x] + (0, a, b, (a + b) // 2, paeth)[method]) & 255
        rows.append(line)
    return rows[1:]


def covered(rows):
    return sum(row[x] > 0 for row in rows for x in range(3, len(row), 4)) / (len(rows) * len(rows[0]) / 4)


def furthest(one, other):
    """The largest difference of two pictures' premultiplied channels."""
    most = 0
    for a, b in zip(one, other):
        for x in range(0, len(a), 4):
            for c in range(3):
                most = max(most, abs(a[x + c] * a[x + 3] - b[x + c] * b[x + 3]) / 255)
    return most


def draw(name, *options):
    text = says(["render", name, "-o", "drawn.png", "--size", "64x96", "--renderer", "software", *options])
    return picture("drawn.png"), text


# A figure: a red foot, a green body, a blue head to the left. It tells up from down and left from right.
FIGURE = [splat((0, 0.1, 0), 0.05, (1, 0, 0)), splat((0, 0.5, 0), 0.1, (0, 1, 0)), splat((-0.1, 0.9, 0.05), 0.05, (0, 0, 1))]
UNSTATED = "no up axis stated; try --axes y-down"


def turned(to):
    """The figure where `to` (three rows) takes it."""
    return [[*(sum(row[k] * s[k] for k in range(3)) for row in to), *s[3:]] for s in FIGURE]


HALF_TURN_X = ((1, 0, 0), (0, -1, 0), (0, 0, -1))
Z_UP = ((1, 0, 0), (0, 0, -1), (0, 1, 0))
write_ply("figure.ply", FIGURE, ["Vertical axis: y"])
upright, said = draw("figure.ply")
check(UNSTATED not in said and "no up axis" not in run("inspect", "figure.ply")[1], "a file that states its axes is not asked about them")
for name, to, comment, axes in [("down", HALF_TURN_X, "Vertical axis: 0 -1 0", "y-down"), ("z", Z_UP, "Vertical Axis: z", "z-up")]:
    write_ply(f"{name}.ply", turned(to), [comment])
    write_ply(f"{name}-silent.ply", turned(to))
    check(furthest(draw(f"{name}.ply")[0], upright) <= 2, f"'{comment}' is heard")
    check(furthest(draw(f"{name}.ply", "--axes", axes)[0], upright) <= 2, f"--axes {axes} says the same as '{comment}'")
    silent, said = draw(f"{name}-silent.ply")
    check(UNSTATED in said and furthest(silent, upright) > 50, "a file that states nothing is not turned, and that is said")
    check(furthest(draw(f"{name}-silent.ply", "--axes", axes)[0], upright) <= 2, f"--axes {axes}")
    says(["inspect", f"{name}-silent.ply"], UNSTATED)
    says(["export", f"{name}-silent.ply", "-o", "told.glb", "--input-axes", axes], "a splat) in told.glb")
    check(furthest(draw("told.glb")[0], upright) <= 2, f"--input-axes {axes}")
    check("add --input-axes" in run("export", f"{name}-silent.ply", "-o", "taken.glb")[1], "export says what it takes")
check(furthest(draw("figure.ply", "--axes", "y-down")[0], upright) > 50, "the user's word counts more than the file's")

# Exports come back as they went, and name the viewers that show them upright.
for out, options, last in [("out.glb", [], "upright (y up"), ("out.spz", [], "upright (y up"),
                           ("three.spz", ["--spz-version", "3"], "upright (y up"),
                           ("out.ply", [], "upright in SuperSplat, splat-transform and Babylon.js"),
                           ("up.ply", ["--axes", "y-up"], "upright in three.js, Spark")]:
    text = says(["export", "down.ply", "-o", out, *options], "bytes (", "a splat) in " + out)
    check(last in text.strip().splitlines()[-1], f"the last line of {out} names viewers: {text.strip().splitlines()[-1]}")
    check(furthest(draw(out)[0], upright) <= (8 if out.endswith("spz") else 2), f"{out} comes back as it went")
check(b"comment Vertical axis: 0 -1 0\ncomment Doppel axes: x left, y down, z back\n" in open("out.ply", "rb").read(400),
      "the PLY states its axes")
place = struct.unpack("<3f", open("out.ply", "rb").read().split(b"end_header\n")[1][:12])
check(max(abs(a - b) for a, b in zip(place, (0, -0.1, 0))) < 1e-6, "the PLY is half a turn about z from y up")
check(open("out.spz", "rb").read(8) == b"NGSP\4\0\0\0" and open("three.spz", "rb").read(2) == b"\x1f\x8b",
      "SPZ 4 by default, 3 on request")
write_ply("mip.ply", FIGURE, ["SplatRenderMode: mip"])
says(["export", "mip.ply", "-o", "mip.glb"], "not in mip.glb: the antialiased mark", "it states no axes")
for out in ("mip-2.ply", "mip-2.spz"):
    says(["export", "mip.ply", "-o", out])
    says(["inspect", out], "trained antialiased")
subprocess.run([make_tiny_avatar, "avatar.glb"], check=True)
says(["export", "avatar.glb", "-o", "avatar.spz"], "not in avatar.spz: motion (")
for name in ("x.compressed.ply", "X.Compressed.PLY"):
    status, text = run("export", "figure.ply", "-o", name)
    check(status == 2 and not os.path.exists(name), f"{name} is refused: {text.strip()}")
says(["export", "figure.ply", "-o", "x.compressed.ply"], "compressed PLY is not written", code=2)
says(["export", "figure.ply", "-o", "x.glb", "--axes", "y-down"], "y up by its definition", code=2)
says(["export", "figure.ply", "-o", "x.ply", "--spz-version", "3"], "--spz-version is for .spz", code=2)
for out in ("full.ply", "full.spz", "full.glb", "full.png"):
    os.symlink("/dev/full", out)
    says(["render" if out.endswith("png") else "export", "figure.ply", "-o", out], "full", "No space left", code=1)

# Small things fill the picture; a picture with nothing in it says so.
for scale in (1, 0.02, 0.002, 2e-5):
    small = [[*(scale * v for v in s[:3]), *s[3:7], *(v + math.log(scale) for v in s[7:10]), *s[10:]] for s in FIGURE]
    write_ply("small.ply", small)
    rows, said = draw("small.ply")
    check(0.5 * covered(upright) < covered(rows) < 2 * covered(upright), f"a scene of {scale} m fills {covered(rows):.3f} of the picture")
    check("nothing is drawn" not in said, "which is not empty")
for size in (0.2, 0.001, 30):
    write_ply("one.ply", [splat((0.3, 1, -2), size)])
    rows, said = draw("one.ply")
    check(covered(rows) > 0.1 and "nothing is drawn" not in said, f"one splat of {size} m covers {covered(rows):.3f} of the picture")
write_ply("clear.ply", [splat((0, 0, 0), 0.1, opacity=-30)] * 3)
says(["render", "clear.ply", "-o", "clear.png", "--size", "64x96"], "nothing is drawn in 1 of 1 picture")
check('"empty_frames":1' in run("render", "clear.ply", "-o", "clear.png", "--size", "64x96", "--json")[1].replace(" ", ""), "also in JSON")

broken = [splat((0, 0.1 * k, 0), 0.05) for k in range(5)]
broken[2][1] = math.nan
write_ply("nan.ply", broken)
says(["inspect", "nan.ply"], "4 splats", "1 of 5 splats left out")
says(["export", "nan.ply", "-o", "nan.glb"], "1 of 5 splats left out", "4 splats")
says(["render", "nan.ply", "-o", "nan.png", "--size", "64x96"], "nan.ply: 1 of 5 splats left out")
write_ply("all-nan.ply", [[math.nan] * 14] * 3)
says(["render", "all-nan.ply", "-o", "none.png"], "all-nan.ply", "none of its 3 splats is finite", code=1)
write_ply("map.ply", [splat((448250 + 0.1 * k, 5411951, 300), 0.02) for k in range(5)])
for command in (["inspect", "map.ply"], ["render", "map.ply", "-o", "none.png"], ["export", "map.ply", "-o", "none.glb"]):
    says(command, "map.ply", "subtract a local origin", code=1)
with open("text.gltf", "w", encoding="utf-8") as file:
    file.write('{"asset": {"version": "2.0"}}')
says(["render", "text.gltf", "-o", "none.png"], "text.gltf", "convert it to a .glb", code=1)
check(not os.path.exists("none.png") and not os.path.exists("none.glb"), "a refused file leaves nothing")

REPORTED = {  # what inspect says, and its exit code
    "ext-rdf.spz": (0, "axes: x right, y down, z front"), "plain.spz": (0, "axes: x right, y up, z back"),
    "mip-comment.ply": (0, "trained antialiased"), "filter3d.ply": (0, "filter_3D"), "2dgs.ply": (0, "flat splats"),
    "one-nan.ply": (0, "1 of 8 splats left out"), "double.ply": (1, "'x' of element 'vertex' is a double"),
    "sh4.ply": (0, "SH degree 4 (drawn up to 3)"), "utm.ply": (1, "subtract a local origin"), "text.gltf": (1, "convert it to a .glb"),
    "small.ply": (0, UNSTATED), "one-splat.ply": (0, UNSTATED)}
if os.path.isdir(faults):
    for name, (code, text) in REPORTED.items():
        says(["inspect", f"{faults}/{name}"], text, code=code)
        if code == 0:
            rows, said = draw(f"{faults}/{name}")  # of filter3d.ply the filter leaves an opacity of 10^-5, which is said
            check(covered(rows) > 0.005 or (name == "filter3d.ply" and "nothing is drawn" in said), f"{name} shows")
    plain, upset = draw(f"{faults}/plain.spz")[0], draw(f"{faults}/ext-rdf.spz")[0]
    # Measured 8.8 of 255: both files are quantised, one before the turn and one after. On its head or its back it is 255.
    check(furthest(plain, upset) <= 16, f"ext-rdf.spz stands as plain.spz: {furthest(plain, upset)}")
    check(furthest(plain, draw(f"{faults}/ext-rdf.spz", "--axes", "y-up")[0]) > 100, "which tells it from one on its head")
    says(["export", f"{faults}/plain.spz", "-o", "plain.ply"])
    check(furthest(plain, draw("plain.ply")[0]) <= 2, "plain.spz as PLY stands as it did")
else:
    print(f"skipped: the reported inputs are not in {faults}")
if failures:
    sys.exit(f"{failures} failed")
