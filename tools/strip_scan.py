#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes a scan of another one's pictures that lacks what a reconstruction should find by itself.

    tools/strip_scan.py SCAN FOLDER FIELD...

FIELD: what frames lose: camera, mask, labels, keypoints. Held-out frames keep their masks, so that every run is scored on the same pixels.
The truth and its surfaces are left out always. FOLDER must not exist; it links the files of SCAN.
"""
import json
import os
import pathlib
import sys

OF_ALL_CAMERAS = ("camera_model", "distortion")


def strip_scan(scan, folder, fields, keep=lambda frame: True, more=None):
    """Makes `folder` a scan of the frames of `scan` for which keep(frame) holds, without `fields`. `more`: fields for its manifest."""
    manifest = json.loads((scan / "scan.json").read_text(encoding="utf-8"))
    for key in ("geometry", "truth", *(OF_ALL_CAMERAS if "camera" in fields else ())):
        manifest.pop(key, None)
    stays = lambda frame, key: key not in fields or (key == "mask" and frame.get("split") == "test")
    manifest["frames"] = [{key: value for key, value in frame.items() if stays(frame, key)} for frame in manifest["frames"] if keep(frame)]
    manifest.update(more or {})
    folder.mkdir(parents=True)
    for name in ("images", "masks", "labels", "keypoints"):
        if (scan / name).is_dir():
            os.symlink((scan / name).resolve(), folder / name)
    (folder / "scan.json").write_text(json.dumps(manifest), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) < 3 or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__)
    strip_scan(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3:])
