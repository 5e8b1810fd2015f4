#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`doppel export --clip … --fps …`: a numbered folder of splat files, the same splats in each; other folders are refused, and a run that was
killed goes on.
usage: clips_test.py DOPPEL MAKE_TINY_AVATAR WORKDIR"""
import json
import os
import shutil
import struct
import subprocess
import sys

doppel, make_tiny_avatar, work = sys.argv[1:]
shutil.rmtree(work, ignore_errors=True)
os.makedirs(work)
os.chdir(work)
failures = 0


def check(good, what):
    global failures
    failures += not good
    print(("ok: " if good else "FAILED: ") + what, file=sys.stdout if good else sys.stderr)


def says(words, *patterns, code=0):
    """Runs `doppel WORDS`, which must end with `code` and print the patterns. Returns what was printed."""
    done = subprocess.run([doppel, *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          check=False)
    missing = [p for p in patterns if p not in done.stdout]
    good = done.returncode == code and not missing
    check(good, " ".join(words) + ("" if good else f" (exit {done.returncode}, without {missing}): {done.stdout}"))
    return done.stdout


def places(name):
    """Centres of the splats of a PLY."""
    head, body = open(name, "rb").read().split(b"end_header\n")
    count = int(head.split(b"element vertex ")[1].split()[0])
    stride = 4 * head.count(b"property float")
    check(len(body) == count * stride, f"{name} holds {count} splats")
    return [struct.unpack_from("<3f", body, i * stride) for i in range(count)]


subprocess.run([make_tiny_avatar, "avatar.glb"], check=True)
inspected = subprocess.run([doppel, "inspect", "avatar.glb"], stdout=subprocess.PIPE, text=True, check=True).stdout
clip = inspected.split("clips: ")[1].split(" (")[0]
seconds = float(inspected.split("clips: ")[1].split("(")[1].split(" s")[0])
rate = 8 / seconds

text = says(["export", "avatar.glb", "-o", "walk", "--clip", clip, "--fps", f"{rate}", "--format", "ply"], "9 frames of at most ", "in all, in walk",
            "9 of 9 frames written")
check(text.index("in all") < text.index("written"), "the size is said first")
names = sorted(os.listdir("walk"))
check(names == [f"{i:05}.ply" for i in range(9)] + ["clip.json"], f"files are numbered: {names}")
first, middle = places("walk/00000.ply"), places("walk/00004.ply")
check(len(first) == len(middle), "each frame has the same splats")
moved = sorted(max(abs(a - b) for a, b in zip(p, q)) for p, q in zip(first, middle))
check(0.01 < moved[-1] < 2, f"the clip moves them, by up to {moved[-1]:.3f} m")
says(["export", "avatar.glb", "-o", "one.ply", "--clip", clip, "--time", f"{4 / rate}"])

# A run that was stopped goes on, and makes the same bytes.
whole = {name: open(f"walk/{name}", "rb").read() for name in names}
for gone in (2, 5, 8):
    os.remove(f"walk/{gone:05}.ply")
os.utime("walk/00001.ply", (1, 1))
open("walk/00005.ply.part4711", "wb").write(whole["00005.ply"][:1000])  # what a kill leaves
says(["export", "avatar.glb", "-o", "walk", "--clip", clip, "--fps", f"{rate}", "--format", "ply"], "6 of them are there already",
     "3 of 9 frames written")
check({name: open(f"walk/{name}", "rb").read() for name in sorted(os.listdir("walk"))} == whole, "with the same bytes")
says(["export", "avatar.glb", "-o", "walk", "--clip", clip, "--fps", f"{rate}", "--format", "ply"], "all 9 frames are there already")
check(os.stat("walk/00001.ply").st_mtime == 1, "what was there stays")

# Other folders are not touched.
says(["export", "avatar.glb", "-o", "walk", "--clip", clip, "--fps", f"{2 * rate}", "--format", "ply"], "the folder holds another export, of the",
     code=2)
says(["export", "avatar.glb", "-o", "walk", "--clip", clip, "--fps", f"{rate}"], "the folder holds another export", code=2)
os.mkdir("half")
open("half/clip.json.part4711", "w", encoding="utf-8").write("{")
says(["export", "avatar.glb", "-o", "half", "--clip", clip, "--fps", f"{rate / 8}"], "2 of 2 frames written")
check(sorted(os.listdir("half")) == ["00000.spz", "00001.spz", "clip.json"], "a run that was killed at once begins again")
os.mkdir("photos")
open("photos/me.jpg", "wb").write(b"me")
says(["export", "avatar.glb", "-o", "photos", "--clip", clip, "--fps", "5"], "the folder is not empty", code=2)
check(os.listdir("photos") == ["me.jpg"], "a folder of something else is left alone")
check({name: open(f"walk/{name}", "rb").read() for name in sorted(os.listdir("walk"))} == whole, "and so is that of another clip")

says(["export", "avatar.glb", "-o", "small", "--clip", clip, "--fps", f"{rate}"], "9 of 9 frames written", "upright (y up, SPZ's default)")
check(json.load(open("small/clip.json", encoding="utf-8"))["frames"] == 9, "clip.json tells what the folder holds")
says(["inspect", "small/00008.spz"], f"{len(first)} splats")

says(["export", "avatar.glb", "-o", "x.ply", "--clip", clip, "--fps", "5"], "names a folder", code=2)
says(["export", "avatar.glb", "-o", "x", "--clip", clip], "must end in .glb, .spz or .ply", code=2)
says(["export", "avatar.glb", "-o", "x", "--fps", "5"], "--clip", code=2)
says(["export", "avatar.glb", "-o", "x", "--clip", clip, "--fps", "5", "--time", "1"], "--time", code=2)
says(["export", "avatar.glb", "-o", "x", "--clip", clip, "--fps", "5", "--axes", "y-down"], "y up by its definition", code=2)
says(["export", "avatar.glb", "-o", "x", "--clip", "no-such", "--fps", "5"], "neither a clip of the avatar nor", code=1)
says(["export", "avatar.glb", "-o", "x", "--clip", clip, "--fps", "0"], "--fps", code=2)
says(["export", "one.ply", "-o", "x", "--clip", clip, "--fps", "5"], "one.ply", code=1)
check(not os.path.exists("x"), "a refused export makes no folder")
if failures:
    sys.exit(f"{failures} failed")
