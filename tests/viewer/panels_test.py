#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Drives the panels of doppel-viewer in a virtual display: a script of clicks, exports that end well, are cancelled or fail, a run that is
begun in the window, and eight states whose pictures are compared with those in tests/viewer/states.

--approve writes these pictures anew; look at them before you commit them. Exit 77, with the reason: something is missing."""
import argparse
import json
import os
import pathlib
import resource
import shutil
import signal
import sys
import time

import viewer_test
import x11_send
from viewer_test import PATIENCE_S, Test, expect

LEAST_GOLDEN_DB = 40  # measured 61 to 99 (the same bytes) on the driver that drew them; another font or driver may round other pixels
WIDTH, HEIGHT = 900, 700
ASK_AGAIN_S = 20  # far longer than a frame takes on a busy machine
EXPORT_TOP = 160  # of the window that exports, in a window of that size
KINDS = ["picture", "cut out", "turntable", "clip", "glb", "spz", "ply", "mesh"]


class Panels(Test):
    def press(self, window, x, y):
        """Presses what is at a place without letters, as slowly as the window draws: it changes its colour under the mouse, again when it
        is held, and again when it is let go. What did not listen, because it was not there yet, is asked again. Dear ImGui 1.86 takes a
        release and a movement in one frame for a release elsewhere, so the last change is waited for."""
        colour = lambda: self.figures("colour", self.capture(window, "press.png"), x, y)
        end = time.monotonic() + PATIENCE_S

        def changes(*words):
            before, again = colour(), time.monotonic() + ASK_AGAIN_S
            self.xdotool(*words)
            while sum(abs(a - b) for a, b in zip(before, colour())) < 20:
                if time.monotonic() > again:
                    return False
            return True
        while True:
            if changes("mousemove", "--window", window, x, y) and changes("mousedown", 1):
                changes("mouseup", 1)
                return
            if time.monotonic() > end:
                raise RuntimeError(f"nothing to press at {x}, {y}: see {self.work}/press.png")
            self.xdotool("mousemove", "--window", window, WIDTH - 2, HEIGHT - 2, "mouseup", 1)  # let go elsewhere: that is no click
            time.sleep(0.5)

    def choose(self, window, kind):
        """In the window that exports: what, and go."""
        self.press(window, 254, EXPORT_TOP + 44 + 29 * KINDS.index(kind))
        self.press(window, 300, EXPORT_TOP + 332)

    def left_overs(self):
        return [path.name for path in self.work.iterdir() if ".part" in path.name]

    def finished_run(self):
        """The folder of a run with a scan of one bright picture."""
        folder = self.run_folder("finished")
        shutil.copy(self.avatar, folder / "avatar.glb")
        self.tell(folder, "done", 9)
        scan = folder / "scan"
        scan.mkdir()
        (scan / "scan.json").write_text("{}")
        shutil.copy(self.work / "room_bright.png", scan / "a.png")
        frame = {"name": "a", "image": "a.png", "mask": "", "size": [420, 300],
                 "camera": [300, 300, 210, 150, 1, 0, 0, 0, -1, 0, 0, 0, -1, 0, 1, 2.5]}
        pose = {"name": "a", "split": "train", "pose": {"rotations_xyzw": [[0, 0, 0, 1]] * 2, "root_translation": [0, 0, 0]}}
        (folder / "frames.json").write_text(json.dumps({"format": "doppel-frames", "version": 1, "scan": "scan", "frames": [frame]}))
        (folder / "poses.json").write_text(json.dumps({"format": "doppel-poses", "version": 1, "joints": ["pelvis", "left_shoulder"],
                                                       "frames": [pose]}))
        return folder

    def settings(self, **fields):
        file = self.work / ".config/doppel/viewer.json"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(fields))

    def clicks(self):
        """Open, focus, play, compare, export, as a hand does it."""
        began = time.monotonic()
        self.settings(recent=[str(self.work / "finished/avatar.glb")], room="none")
        process, window = self.start("--size", f"{WIDTH}x{HEIGHT}")
        try:
            shot = lambda: self.capture(window, "clicks.png")
            red = lambda: self.figures("colour", shot(), 450, 350)
            self.wait("the list of what was opened lately is there", lambda: self.figures("colour", shot(), 40, 182)[2] > 90)
            self.press(window, 250, 153)
            self.wait("a click opens the avatar", lambda: red()[0] > 150 and red()[1] < 90)
            self.wait("it moves", lambda: not self.stands_still(window))
            self.press(window, 86, HEIGHT - 34)
            self.wait("a click pauses it", lambda: self.stands_still(window))
            self.press(window, 158, HEIGHT - 34)
            self.wait("a click on the bar goes to the clip's begin", lambda: self.stands_still(window) and red()[0] > 150)
            before = self.capture(window, "before_focus.png")

            def nearer():  # on a busy machine both clicks may come in one frame; then they are one
                self.xdotool("mousemove", "--window", window, 450, 400, "click", "--repeat", 2, "--delay", 120, 1)
                return self.figures("differ", before, shot())[0] > 1
            self.wait("a double click goes nearer", nearer)
            self.press(window, 60, 193)
            self.wait("a click compares it with its photograph", lambda: self.figures("colour", shot(), 420, 100)[1] > 90)
            self.xdotool("key", "--window", window, "Escape")
            self.wait("Escape ends that", lambda: self.figures("colour", shot(), 420, 100)[1] < 90)
            self.press(window, 176, 106)
            self.wait("a click opens the window that exports", lambda: self.figures("colour", shot(), 300, EXPORT_TOP + 332)[2] > 90)
            self.choose(window, "ply")
            self.wait("splats are saved", lambda: (self.work / "avatar-1.ply").exists())
            self.choose(window, "picture")
            self.wait("a picture is saved", lambda: (self.work / "avatar-1.png").exists())
            self.choose(window, "cut out")
            self.wait("a transparent picture is saved", lambda: (self.work / "avatar-2.png").exists())
            expect(max(self.figures("colour", self.work / "avatar-1.png", 60, 57)) < 60, "there are no panels in it")
            expect(not self.left_overs(), f"nothing half written stays {self.left_overs()}")
            x11_send.Sender(self.display.name).close(window)
            expect(process.wait(timeout=PATIENCE_S) == 0, "the window closes, with nothing from the validation layer")
        finally:
            if process.poll() is None:
                process.kill()
        print(f"the script of clicks took {time.monotonic() - began:.0f} s")

    def beside(self):
        """Splats of a file have places of their own, and yet stand beside the avatar: alone, a board reaches neither place."""
        red = lambda picture: [self.figures("colour", picture, x, 240)[0] > 150 for x in (140, 500)]
        for name, words, wanted in (("alone", (), False), ("beside", (self.work / "avatar-1.ply",), True)):
            picture = self.work / f"splats_{name}.png"
            result = self.run("--screenshot", picture, "--size", "640x480", "--room", "none", "--hide-panels", self.avatar, *words)
            expect(result.returncode == 0 and red(picture) == [wanted, wanted], f"{name}: {red(picture)} {result.stderr}")

    def cancelling(self):
        """A video that Escape ends, and one of the clip to its end."""
        process, window = self.start(self.avatar, "--room", "none", "--size", f"{WIDTH}x{HEIGHT}")
        try:
            shot = lambda: self.capture(window, "cancelling.png")
            self.wait("the avatar is in the window", lambda: self.figures("colour", shot(), 450, 350)[0] > 150)
            bvh = self.work / "chair.bvh"
            bvh.write_text("HIERARCHY\nROOT seat\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
                           "End Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\nFrames: 2\nFrame Time: 0.1\n0 0 0\n0 0 0\n")
            x11_send.Sender(self.display.name).drop(window, [bvh])
            self.wait("a motion of another skeleton is a sentence", lambda: "chair.bvh: " in (self.work / "session.log").read_text())
            self.xdotool("key", "--window", window, "e")
            self.choose(window, "turntable")
            self.wait("a recording begins", lambda: self.left_overs())
            self.xdotool("key", "--window", window, "Escape")
            self.wait("Escape ends it and leaves nothing half written", lambda: not self.left_overs())
            self.xdotool("key", "--window", window, "e")
            self.choose(window, "clip")
            self.wait("the clip is saved as a video, or as pictures without ffmpeg",
                      lambda: any((self.work / name).exists() for name in ("board-1.mp4", "board-2.mp4", "board-1", "board-2")))
            x11_send.Sender(self.display.name).close(window)
            expect(process.wait(timeout=PATIENCE_S) == 0, "the window closes")
        finally:
            if process.poll() is None:
                process.kill()

    def failing(self):
        """No program doppel, and a disk that takes no more: a sentence each, and the window stays."""
        alone = self.work / "alone"
        alone.mkdir()
        shutil.copy(self.viewer, alone / "doppel-viewer")
        full = lambda: (signal.signal(signal.SIGXFSZ, signal.SIG_IGN), resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000)))
        with_program, self.viewer = self.viewer, str(alone / "doppel-viewer")
        process, window = self.start(self.avatar, "--room", "none", "--size", f"{WIDTH}x{HEIGHT}", preexec=full)
        self.viewer = with_program
        log = self.work / "session.log"
        try:
            shot = lambda: self.capture(window, "failing.png")
            self.wait("the avatar is in the window", lambda: self.figures("colour", shot(), 450, 350)[0] > 150)
            self.xdotool("key", "--window", window, "p")
            self.wait("a full disk is a sentence", lambda: "board-" in log.read_text() and ".png" in log.read_text())
            self.xdotool("key", "--window", window, "e")
            self.choose(window, "spz")
            self.wait("a missing program is a sentence", lambda: "install the package doppel-tools" in log.read_text())
            expect(process.poll() is None and not self.left_overs(), f"the window stays, and nothing half written {self.left_overs()}")
            x11_send.Sender(self.display.name).close(window)
            expect(process.wait(timeout=PATIENCE_S) == 0, "it closes as ever")
        finally:
            if process.poll() is None:
                process.kill()

    def new_run(self):
        """A dropped film whose run ends at once: it is no scan."""
        film = self.work / "film"
        film.mkdir()
        (film / "scan.json").write_text("{}")
        process, window = self.start("--room", "none", "--size", f"{WIDTH}x{HEIGHT}")
        try:
            x11_send.Sender(self.display.name).drop(window, [film])
            shot = lambda: self.capture(window, "film.png")
            self.wait("a dropped film is offered to be made", lambda: self.figures("colour", shot(), 40, 194)[2] > 90)
            self.press(window, 40, 194)
            out = self.work / "film-avatar"
            self.wait("a click begins its run", lambda: (out / "progress.json").exists())
            self.wait("which says why it has failed", lambda: json.loads((out / "progress.json").read_text())["state"] == "failed")
            expect(json.loads((out / "viewer-run.json").read_text())["scan"] == str(film), "a later start can go on with it")
            expect("doppel: " in (out / "reconstruct.log").read_text(), "its log has the sentence")
            expect(process.poll() is None, "the window stays")
            x11_send.Sender(self.display.name).close(window)
            process.wait(timeout=PATIENCE_S)
        finally:
            if process.poll() is None:
                process.kill()

    def same(self, name, picture, approve):
        """Compares the picture of a state with the one that was approved."""
        golden = pathlib.Path(__file__).parent / "states" / f"{name}.png"
        if approve:
            golden.parent.mkdir(exist_ok=True)
            shutil.copy(picture, golden)
            return
        psnr, = self.figures("psnr", golden, picture)
        expect(psnr >= LEAST_GOLDEN_DB, f"{name}: {psnr} dB to the approved picture, at least {LEAST_GOLDEN_DB} wanted: {picture}")

    def states(self, approve):
        run = self.run_folder("run")  # stopped: one that works is called silent soon, on a busy machine
        self.tell(run, "stopped", 1)
        (run / "viewer-run.json").write_text(json.dumps({"format": "doppel-viewer-run", "version": 1, "scan": "/film", "videos": [],
                                                         "preset": "draft", "minutes": 0}))
        self.xdotool("mousemove", 990, 790)  # no button is under it
        small, wide = "640x480", "1280x600"
        scripts = {"empty": (small,), "avatar": (small, self.avatar, "--frames", 10),
                   "bright": (small, self.avatar, self.avatar, "--room", "bright"), "run": (wide, run, "--frames", 2),
                   "compare": (wide, self.work / "finished", "--compare", "a"),
                   "scaled": ("1280x960", self.avatar, "--scale", 2, "--room", "none"), "narrow": ("320x240", self.avatar)}
        for name, (size, *words) in scripts.items():
            picture = self.work / f"state_{name}.png"
            result = self.run("--screenshot", picture, "--size", size, *words)
            expect(result.returncode == 0 and not result.stderr, f"{name} is drawn {result.stderr}")
            if result.returncode == 0:
                self.same(name, picture, approve)
        self.settings(exports="/pictures")
        process, window = self.start("--room", "dark", "--size", small)
        try:
            rests = lambda: self.stands_still(window)
            self.wait("the room is there", lambda: min(self.figures("colour", self.capture(window, "state.png"), 320, 430)) > 60)
            self.wait("the window rests", rests)
            for name, key in (("export", "e"), ("help", "F1")):
                before = self.capture(window, "before_state.png")
                self.xdotool("key", "--window", window, key)
                self.wait(f"{name} opens", lambda: self.figures("differ", before, self.capture(window, "state.png"))[0] > 1)
                self.wait("the window rests", rests)
                self.same(name, self.capture(window, f"state_{name}.png"), approve)
                self.xdotool("key", "--window", window, "Escape" if key == "e" else key)
                self.wait(f"{name} closes", lambda: self.figures("differ", before, self.capture(window, "state.png"))[0] < 0.5)
            x11_send.Sender(self.display.name).close(window)
            process.wait(timeout=PATIENCE_S)
        finally:
            if process.poll() is None:
                process.kill()


def main():
    parser = argparse.ArgumentParser()
    for name in ("viewer", "check"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--work", type=pathlib.Path, required=True)
    parser.add_argument("--approve", action="store_true")
    arguments = parser.parse_args()
    viewer_test.prepare(arguments)
    display = viewer_test.Display()
    try:
        test = Panels(arguments, display)
        test.shot("room_bright.png", "--room", "bright")
        test.finished_run()
        test.states(arguments.approve)
        test.clicks()
        test.beside()
        test.cancelling()
        test.failing()
        test.new_run()
    finally:
        display.close()
    return 1 if viewer_test.failures else 0


if __name__ == "__main__":
    sys.exit(main())
