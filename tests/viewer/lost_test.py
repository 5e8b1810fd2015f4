#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Loses the graphics device of doppel-viewer, by a Vulkan layer (lost_layer.cpp): the window, what is open in it, a watched run and a
recording go on, and so does a start; where no device can be opened again, the viewer ends with a sentence. Exit 77, with the reason: something is missing."""
import argparse
import json
import os
import pathlib
import subprocess
import sys

import viewer_test
import x11_send
from panels_test import HEIGHT, WIDTH, Panels
from viewer_test import PATIENCE_S, expect

LEAST_DB = 40  # measured 99 (the same bytes): what is uploaded again are the same bits
REOPENED = "is open again"


class Lost(Panels):
    def __init__(self, arguments, display):
        super().__init__(arguments, display)
        self.trigger = self.work / "lose"
        self.environment["DOPPEL_LOSE_DEVICES"] = str(self.trigger)
        self.log = self.work / "session.log"

    def lose(self, devices=1):
        (self.work / "lose.part").write_text(str(devices))
        (self.work / "lose.part").rename(self.trigger)

    def told(self):
        return self.log.read_text().count(REOPENED)

    def resting(self, window, name):
        """A picture of the window, once nothing moves in it."""
        self.wait("the window rests", lambda: self.stands_still(window))
        return self.capture(window, name)

    def the_same_after_a_loss(self, window, name):
        before, times = self.resting(window, f"{name}_before.png"), self.told()
        self.lose()
        self.wait("the viewer says that the device was lost and is open again", lambda: self.told() == times + 1)
        psnr = lambda: self.figures("psnr", before, self.capture(window, f"{name}_after.png"))[0]
        self.wait("its sentence is in the window, which is drawn again", lambda: psnr() < LEAST_DB)
        self.wait(f"{name}: when the sentence has gone, the same picture stands, at least {LEAST_DB} dB", lambda: psnr() >= LEAST_DB)
        print(f"{name}: {psnr()} dB")

    def window(self, run):
        """The avatar of a run that is watched, beside another one, seen from another side."""
        process, window = self.start(run, self.avatar, "--size", f"{WIDTH}x{HEIGHT}", "--room", "dark")
        try:
            red = lambda x: self.figures("colour", self.capture(window, "lost.png"), x, 400)[0] > 150
            self.wait("both avatars are in the window", lambda: red(400) and red(560))
            self.xdotool("mousemove", "--window", window, 560, 350, "key", "--window", window, "space")
            self.xdotool("mousedown", 1, "mousemove", "--window", window, 590, 355, "mouseup", 1)
            self.the_same_after_a_loss(window, "avatars")
            self.tell(run, "failed", 10)
            before = self.capture(window, "before_failed.png")
            self.wait("the run is watched still", lambda: self.figures("differ", before, self.capture(window, "failed.png"))[0] > 0.1)
            self.closes(process, window)
        finally:
            if process.poll() is None:
                process.kill()

    def comparison(self, run):
        """The pictures that lie over the avatars."""
        process, window = self.start(run, "--compare", "a", "--size", f"{WIDTH}x{HEIGHT}")
        try:
            self.wait("photograph and avatar are in the window",
                      lambda: self.figures("colour", self.capture(window, "lost.png"), 420, 100)[1] > 90)
            self.the_same_after_a_loss(window, "comparison")
            self.closes(process, window)
        finally:
            if process.poll() is None:
                process.kill()

    def recording(self):
        """A turntable in whose midst two devices are lost, one after the other."""
        words = ["--size", "64x64", "--frames", "12", "--turntable"]
        calm = self.run(self.avatar, *words, self.work / "calm")
        expect(calm.returncode == 0 and not calm.stderr, f"a turntable is recorded {calm.stderr}")
        with open(self.log, "w") as log:
            process = subprocess.Popen([self.viewer, "--validation", self.avatar, *words, self.work / "lost"], cwd=self.work,
                                       env=self.environment, stderr=log)
        try:
            self.wait("the recording has begun", lambda: list(self.work.glob(".lost.part*/00002.png")) or process.poll() is not None)
            self.lose(2)
            expect(process.wait(timeout=PATIENCE_S) == 0 and self.told() > 0, "it ends as ever, " + self.log.read_text())
            pictures = sorted(path.name for path in (self.work / "lost").iterdir())
            same = [(self.work / "lost" / name).read_bytes() == (self.work / "calm" / name).read_bytes() for name in pictures]
            expect(len(pictures) == 12 and all(same), f"it misses no picture, and each is the same: {same}")
        finally:
            if process.poll() is None:
                process.kill()

    def for_good(self):
        """No device lives for longer than one submission."""
        process, window = self.start(self.avatar, "--room", "none", "--size", "420x300", "--hide-panels")
        try:
            self.wait("the avatar is in the window", lambda: self.figures("colour", self.capture(window, "lost.png"), 210, 170)[0] > 150)
            self.lose(1000)
            expect(process.wait(timeout=PATIENCE_S) == 1, "the viewer ends")
            last = self.log.read_text().splitlines()[-1]
            expect("the graphics device was lost 3 times within a minute" in last and "Settings are kept" in last, last)
            kept = json.loads((self.work / ".config/doppel/viewer.json").read_text())
            expect(kept["recent"][:1] == [str(self.avatar)], f"its settings are kept: {kept}")
        finally:
            if process.poll() is None:
                process.kill()
            self.trigger.unlink(missing_ok=True)

    def start_lost(self):
        """A device that is lost while the window opens, and devices that all are."""
        self.lose()
        process, window = self.start(self.avatar, "--room", "none", "--size", "420x300", "--hide-panels")
        try:
            self.wait("the viewer says that the device was lost at the start and is open again",
                      lambda: "lost at the start and is open again" in self.log.read_text())
            self.wait("the avatar is in the window", lambda: self.figures("colour", self.capture(window, "lost.png"), 210, 170)[0] > 150)
            self.closes(process, window)
        finally:
            if process.poll() is None:
                process.kill()
        self.lose(1000)
        result = self.run(self.avatar)
        self.trigger.unlink(missing_ok=True)
        expect(result.returncode == 1 and "the graphics device was lost 3 times within a minute" in result.stderr.splitlines()[-1],
               f"where every device is lost at the start, the viewer ends with a sentence: {result.stderr}")

    def closes(self, process, window):
        x11_send.Sender(self.display.name).close(window)
        expect(process.wait(timeout=PATIENCE_S) == 0, "the window closes, with nothing from the validation layer")


def main():
    parser = argparse.ArgumentParser()
    for name in ("viewer", "check"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--work", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    if "VK_LAYER_DOPPEL_lost" not in os.environ.get("VK_INSTANCE_LAYERS", ""):
        viewer_test.skip("run it by ctest, which names the layer that loses devices")
    viewer_test.prepare(arguments)
    display = viewer_test.Display()
    try:
        test = Lost(arguments, display)
        test.shot("room_bright.png", "--room", "bright")
        test.start_lost()
        run = test.finished_run()
        test.comparison(run)
        test.window(run)
        test.recording()
        test.for_good()
    finally:
        display.close()
    return 1 if viewer_test.failures else 0


if __name__ == "__main__":
    sys.exit(main())
