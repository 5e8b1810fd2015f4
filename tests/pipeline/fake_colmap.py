#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Plays COLMAP for tests: the mapper answers with the true cameras of a scan, in a world of another origin and scale.

Environment: FAKE_COLMAP_SCAN, the folder of a scan.json with cameras; FAKE_COLMAP_PLACES, how many pictures it places at most;
FAKE_COLMAP_FAR, a picture that it puts a thousand times too far away. Other commands than `mapper` do nothing.
"""
import json
import math
import os
import pathlib
import sys

SCALE, SHIFT = 0.4, (1.0, -2.0, 3.0)  # of the world that is answered


def quaternion(r):
    """(w, x, y, z) of a rotation matrix, row by row."""
    w = math.sqrt(max(0.0, 1 + r[0] + r[4] + r[8])) / 2
    if w > 1e-3:
        return w, (r[7] - r[5]) / (4 * w), (r[2] - r[6]) / (4 * w), (r[3] - r[1]) / (4 * w)
    x, y, z = (math.sqrt(max(0.0, 1 + 2 * r[i] - r[0] - r[4] - r[8])) / 2 for i in (0, 4, 8))
    return w, x, math.copysign(y, r[1] + r[3]), math.copysign(z, r[2] + r[6])


def write_model(scan, images, out):
    manifest = json.loads((scan / "scan.json").read_text(encoding="utf-8"))
    asked = set(sorted(path.name for path in images.iterdir())[:int(os.environ.get("FAKE_COLMAP_PLACES", "1000"))])
    lines = []
    for frame in manifest["frames"]:
        camera, name = frame["camera"], frame["name"] + pathlib.Path(frame["image"]).suffix
        if name not in asked:
            continue
        r, t = camera["R"], camera["t"]
        moved = [SCALE * t[i] - sum(r[3 * i + k] * SHIFT[k] for k in range(3)) for i in range(3)]
        if frame["name"] == os.environ.get("FAKE_COLMAP_FAR"):
            moved = [1000 * value for value in moved]
        pose = " ".join(f"{value:.17g}" for value in (*quaternion(r), *moved))
        lines.append(f"{len(lines) + 1} {pose} 1 {name}\n\n")
    width, height = manifest["image_size"]
    camera = manifest["frames"][0]["camera"]
    out.mkdir(parents=True)
    (out / "cameras.txt").write_text(f"1 SIMPLE_RADIAL {width} {height} {camera['fx']} {camera['cx']} {camera['cy']} 0\n")
    (out / "images.txt").write_text("".join(lines))
    (out / "points3D.txt").write_text("")


def main():
    options = dict(zip(sys.argv[2::2], sys.argv[3::2]))
    if sys.argv[1] == "mapper":
        write_model(pathlib.Path(os.environ["FAKE_COLMAP_SCAN"]), pathlib.Path(options["--image_path"]),
                    pathlib.Path(options["--output_path"]) / "0")


if __name__ == "__main__":
    main()
