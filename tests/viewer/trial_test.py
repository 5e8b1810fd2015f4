#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A new user's first minutes: doppel-viewer without a file, in a home where nothing is yet; the sample, a splat file of one's own beside it,
and both as a video, by clicks alone. Prints how long each step took. Exit 77, with the reason: something is missing."""
import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import time

import viewer_test
import x11_send
from panels_test import KINDS, EXPORT_TOP, HEIGHT, WIDTH, Panels
from viewer_test import PATIENCE_S, expect

SAMPLE, OPEN, EXPORT = (36, 107), (36, 106), (176, 135)  # places in the window; EXPORT below two rows
OWN_FILE = (600, 214)  # the first file of the list that "Open ..." shows, behind its letters
PLAY = (158, HEIGHT - 34)  # the begin of the bar


class Trial(Panels):
    def trial(self, doppel):
        home = self.work / "home"
        home.mkdir()
        subprocess.run([doppel, "export", self.avatar, "-o", home / "mine.ply"], check=True, capture_output=True)
        self.environment.update(HOME=str(home), XDG_CACHE_HOME=str(home / ".cache"))
        began = time.monotonic()

        def done(what):
            print(f"{time.monotonic() - began:6.1f} s  {what}", flush=True)
        log = open(self.work / "session.log", "w")
        process = subprocess.Popen([self.viewer, "--size", f"{WIDTH}x{HEIGHT}"], cwd=home, env=self.environment, stderr=log)
        window = int(self.xdotool("search", "--sync", "--onlyvisible", "--name", "^Doppel$").split()[0])
        try:
            shot = lambda: self.capture(window, "trial.png")
            blue = lambda x, y: self.figures("colour", shot(), x, y)[2] > 90
            self.wait("the window offers the sample", lambda: blue(*SAMPLE))
            done("the window offers the sample")
            self.press(window, *SAMPLE)
            self.wait("the sample stands there, and its bar", lambda: blue(*PLAY))
            done("the sample walks")
            self.press(window, *OPEN)
            self.wait("its folder is listed", lambda: self.xdotool("mousemove", "--window", window, *OWN_FILE) is not None and blue(*OWN_FILE))
            self.press(window, *OWN_FILE)
            self.wait("the bar stays while the splats are selected", lambda: blue(*PLAY) and blue(*EXPORT))
            done("one's own splats stand beside it")
            self.press(window, *EXPORT)
            self.wait("a click opens the window that exports", lambda: blue(300, EXPORT_TOP + 332))
            self.press(window, 254, EXPORT_TOP + 44 + 29 * KINDS.index("clip"))
            self.press(window, 300, EXPORT_TOP + 332)
            self.wait("a video begins", self.is_recording)
            done("the video begins")
            videos = lambda: [home / name for name in ("mine-1.mp4", "mine-1") if (home / name).exists()]
            self.wait("the video, or a folder of pictures without ffmpeg, is there", videos)
            done("the video is there")
            x11_send.Sender(self.display.name).close(window)
            expect(process.wait(timeout=PATIENCE_S) == 0, "the window closes")
            expect((self.work / "session.log").read_text() == "", "nobody complained " + (self.work / "session.log").read_text())
        finally:
            if process.poll() is None:
                process.kill()

    def is_recording(self):
        return any(".part" in path.name or path.name.startswith("mine-1") for path in (self.work / "home").iterdir())


def main():
    parser = argparse.ArgumentParser()
    for name in ("viewer", "check", "doppel"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--work", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    viewer_test.prepare(arguments)
    shutil.rmtree(arguments.work / "cache")
    display = viewer_test.Display()
    try:
        Trial(arguments, display).trial(arguments.doppel)
    finally:
        display.close()
    return 1 if viewer_test.failures else 0


if __name__ == "__main__":
    sys.exit(main())
