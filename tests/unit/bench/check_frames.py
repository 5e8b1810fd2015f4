#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs bench_frames on a tiny avatar and checks its JSON lines: every contestant is there, and each baseline says how many splats it draws.

    check_frames.py BENCH_FRAMES MAKE_AVATAR        exit 77 says why nothing was checked
"""
import json
import pathlib
import subprocess
import sys
import tempfile


def main():
    bench, make_avatar = sys.argv[1:3]
    with tempfile.TemporaryDirectory() as folder:
        avatar, out = pathlib.Path(folder) / "tiny.glb", pathlib.Path(folder) / "frames.jsonl"
        subprocess.run([make_avatar, avatar], check=True)
        run = subprocess.run([bench, avatar, "--repeats", "1", "--shrink", "8", "--no-reference", "--json", out], capture_output=True, text=True)
        if "no Vulkan" in run.stderr:
            print("skipped: " + run.stderr.strip().splitlines()[0])
            return 77
        if run.returncode != 0:
            print(run.stderr)
            return 1
        lines = [json.loads(line) for line in out.read_text(encoding="utf-8").splitlines()]
    wrong = []
    frames = {(r["case"], r["renderer"]): r for r in lines if "renderer" in r}
    phone = "phone 945x2048"
    for renderer in ("software", "vulkan-quads", "vulkan-tiles", "vulkan-plain-float", "vulkan-plain-tiles"):
        if (phone, renderer) not in frames:
            wrong.append(f"{renderer} did not race")
    if not wrong:
        drawn = {name: frames[phone, name]["splats_drawn"] for name in ("vulkan-quads", "vulkan-plain-float")}
        if abs(drawn["vulkan-plain-float"] - drawn["vulkan-quads"]) > 0.02 * drawn["vulkan-quads"]:
            wrong.append(f"the plain frame draws what shows, as today's does: {drawn}")
    for off in ("vulkan-plain-float", "vulkan-plain-tiles"):
        rows = [r for r in lines if r.get("off") == off and r["case"] == phone]
        if not rows or any(r["drawn_off"] == 0 or r["drawn_on"] == 0 or r["frame_worth"] <= 0 for r in rows):
            wrong.append(f"no worth of {off}, or one without the splats that both sides draw")
    print("\n".join(wrong) if wrong else f"{len(frames)} frames as expected")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
