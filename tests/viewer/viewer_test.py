#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs doppel-viewer in a virtual display: scripted pictures against the CPU's, and a session with mouse, dropped files and other sizes.
Exit 77, with the reason: something that the test needs is missing."""
import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import time

import x11_send

SKIPPED = 77
PATIENCE_S = 600  # for what must come; only what hangs takes so long
LEAST_PSNR_DB = 50  # measured 58.5 and 59; the splats and the composed picture are rounded to 8 bits one after the other
failures = 0


def skip(reason):
    print(f"skipped: {reason}")
    sys.exit(SKIPPED)


def expect(truth, what):
    global failures
    print(("ok: " if truth else "FAILED: ") + what, flush=True)
    failures += not truth


class Display:
    """Xvfb on a free display."""

    def __init__(self):
        read, write = os.pipe()
        words = ["Xvfb", "-displayfd", str(write), "-screen", "0", "1000x800x24", "-nolisten", "tcp", "-noreset"]
        self.process = subprocess.Popen(words, pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as answer:
            number = answer.readline().strip()
        if not number:
            skip("Xvfb does not start here")
        self.name = ":" + number

    def close(self):
        self.process.terminate()
        self.process.wait()


class Test:
    def __init__(self, arguments, display):
        self.viewer, self.check, self.work = arguments.viewer, arguments.check, arguments.work
        self.display = display
        self.environment = dict(os.environ, DISPLAY=display.name, XDG_CACHE_HOME=str(self.work / "cache"), HOME=str(self.work))
        self.environment.pop("WAYLAND_DISPLAY", None)
        self.environment.pop("XDG_CONFIG_HOME", None)  # settings lie in HOME
        self.avatar = self.work / "board.glb"
        subprocess.run([self.check, "make", self.avatar], check=True)

    def run(self, *words, environment=None):
        return subprocess.run([self.viewer, "--validation", *map(str, words)], cwd=self.work, env=environment or self.environment,
                              capture_output=True, text=True, timeout=PATIENCE_S)

    def figures(self, *words):
        result = subprocess.run([self.check, *map(str, words)], capture_output=True, text=True)
        if result.returncode != 0:
            raise RuntimeError(result.stderr)
        return [float(word) for word in result.stdout.split()]

    def shot(self, name, *words):
        """A scripted picture without panels."""
        path = self.work / name
        result = self.run("--screenshot", path, "--size", "420x300", "--hide-panels", *words)
        if "no Vulkan" in result.stderr or "validation layer is not installed" in result.stderr:
            skip(result.stderr.strip())
        expect(result.returncode == 0 and not result.stderr, f"{name} is drawn and the validation layer is silent {result.stderr}")
        return path

    def scripts(self):
        for light in ("dark", "bright"):
            room = self.shot(f"room_{light}.png", "--room", light)
            avatar = self.shot(f"avatar_{light}.png", self.avatar, "--room", light, "--frames", 10)
            psnr, = self.figures("compose", self.avatar, room, avatar, 9 / 30)
            expect(psnr >= LEAST_PSNR_DB, f"{light}: {psnr} dB to the CPU's composition, at least {LEAST_PSNR_DB} wanted")
            expect(self.figures("differ", room, avatar)[0] > 1, f"{light}: the avatar is in the picture")
        difference, = self.figures("differ", self.work / "room_dark.png", self.work / "room_bright.png")
        expect(difference > 50, f"the rooms differ by {difference} levels")

        broken = self.work / "broken.glb"
        broken.write_bytes(self.avatar.read_bytes()[:1000])
        result = self.run("--screenshot", self.work / "never.png", "--size", "64x64", broken)
        expect(result.returncode == 1 and "broken.glb: " in result.stderr and not (self.work / "never.png").exists(),
               f"a script with a broken file fails with a sentence: {result.stderr.strip()}")
        result = self.run(self.avatar, "--turntable", self.work / "turn", "--frames", 3, "--size", "64x64")
        pictures = sorted(path.name for path in (self.work / "turn").glob("*"))
        expect(result.returncode == 0 and pictures == ["00000.png", "00001.png", "00002.png"], f"a turntable writes {pictures}")
        expect(self.figures("differ", self.work / "turn/00000.png", self.work / "turn/00001.png")[0] > 2, "the turntable turns")

    def tell(self, folder, state, beat, **rest):
        """progress.json of a run, replaced as a run does it."""
        progress = {"format": "doppel-progress", "version": 1, "state": state, "sentence": "no space left on device", "started_unix_s": 1,
                    "unix_s": int(time.time()), "beat": beat, "seconds": 90, "words": "painting", "place": 7, "places": 11, "share": 0.5,
                    "seconds_left": 400, "steps": 800, "curve": [[100 * i, 18 + i, 0.1] for i in range(1, 8)],
                    "held_back": {"frame": "dyn_003", "picture": "watch/held-back.jpg"},
                    "avatar": {"file": "watch/avatar.glb", "step": 700, "change": 1}} | rest
        (folder / "progress.part").write_text(json.dumps(progress))
        (folder / "progress.part").rename(folder / "progress.json")

    def run_folder(self, name):
        folder = self.work / name
        (folder / "watch").mkdir(parents=True)
        shutil.copy(self.avatar, folder / "watch/avatar.glb")
        shutil.copy(self.work / "room_bright.png", folder / "watch/held-back.jpg")  # told by its content
        return folder

    def watching(self):
        """Runs that are played: what the viewer shows of one that works, fails, and is deleted."""
        folder = self.run_folder("run")
        self.tell(folder, "running", 1)
        shot = self.work / "watch.png"
        result = self.run(folder, "--screenshot", shot, "--size", "1280x800", "--room", "dark", "--frames", 2)
        expect(result.returncode == 0 and not result.stderr, f"a run is drawn {result.stderr}")

        def is_bar(picture):
            _, green, blue = self.figures("colour", picture, 30, 78)
            return green > 110 and blue < 100
        expect(is_bar(shot), "the panel has the bar of its progress")
        red, green, _ = self.figures("colour", shot, 820, 400)
        expect(red > 150 and green < 90, "the avatar so far stands to the right")
        expect(min(self.figures("colour", shot, 484, 300)) > 60, "the held-back picture lies to the left")

        result = self.run("--screenshot", self.work / "never.png", self.work / "cache")
        expect(result.returncode == 1 and "cache: this folder is neither a run" in result.stderr, f"another folder is refused: {result.stderr.strip()}")

        process, window = self.start(folder, "--size", "900x700")
        elsewhere = Display()
        other = subprocess.Popen([self.viewer, folder, "--size", "300x200"], cwd=self.work, env=dict(self.environment, DISPLAY=elsewhere.name),
                                 stderr=subprocess.DEVNULL)
        try:
            self.wait("the window shows that the run works", lambda: is_bar(self.capture(window, "watch_window.png")))
            self.tell(folder, "failed", 2)
            self.wait("the window shows that it failed", lambda: not is_bar(self.capture(window, "watch_failed.png")))
            self.tell(folder, "running", 3)
            self.wait("and that it goes on", lambda: is_bar(self.capture(window, "watch_again.png")))
            (folder / "progress.json").write_text('{"format":')
            shutil.rmtree(folder)
            self.wait("the window stays when the run is deleted", lambda: not is_bar(self.capture(window, "watch_gone.png")))
            expect(process.poll() is None and other.poll() is None, "two viewers watched it, and both live")
            x11_send.Sender(self.display.name).close(window)
            expect(process.wait(timeout=PATIENCE_S) == 0, "the window closes, with nothing from the validation layer")
        finally:
            for viewer in (process, other):
                if viewer.poll() is None:
                    viewer.kill()
                viewer.wait()
            elsewhere.close()

    def comparing(self):
        """A finished run with two frames whose photographs are a bright wall and a dark one, which the avatar stands before."""
        folder = self.run_folder("finished")
        shutil.copy(self.avatar, folder / "avatar.glb")
        self.tell(folder, "done", 9)
        scan = folder / "scan"
        scan.mkdir()
        (scan / "scan.json").write_text("{}")
        rest, frames, poses = [[0, 0, 0, 1]] * 2, [], []
        for name, light in (("a", "bright"), ("b", "dark")):
            shutil.copy(self.work / f"room_{light}.png", scan / f"{name}.png")
            frames.append({"name": name, "image": f"{name}.png", "mask": "", "size": [420, 300],
                           "camera": [300, 300, 210, 150, 1, 0, 0, 0, -1, 0, 0, 0, -1, 0, 1, 2.5]})
            poses.append({"name": name, "split": "train", "pose": {"rotations_xyzw": rest, "root_translation": [0, 0, 0]}})
        (folder / "frames.json").write_text(json.dumps({"format": "doppel-frames", "version": 1, "scan": "scan", "frames": frames}))
        (folder / "poses.json").write_text(json.dumps({"format": "doppel-poses", "version": 1, "joints": ["pelvis", "left_shoulder"],
                                                       "frames": poses}))
        shot = self.work / "compare.png"
        result = self.run(folder, "--compare", "a", "--screenshot", shot, "--size", "1280x800")
        expect(result.returncode == 0 and not result.stderr, f"a comparison is drawn {result.stderr}")
        expect(min(self.figures("colour", shot, 340, 400)) > 100, "the photograph is to the left of the line")
        red, green, _ = self.figures("colour", shot, 680, 400)
        expect(red > 200 and green < 90, "the avatar is to the right of it")
        expect(max(self.figures("colour", shot, 960, 400)) < 80, "with grey around it")
        result = self.run(folder, "--compare", "c", "--screenshot", self.work / "never.png")
        expect(result.returncode == 1 and "no frame is called c" in result.stderr, f"another frame is refused: {result.stderr.strip()}")

        process, window = self.start(folder / "avatar.glb", "--hide-panels", "--room", "none", "--size", "420x300")
        try:
            def is_photo(dark):
                value = max(self.figures("colour", self.capture(window, "compare_window.png"), 60, 60))
                return value < 60 if dark else value > 100
            self.wait("the avatar is in the window", lambda: self.figures("colour", self.capture(window, "compare_window.png"), 210, 170)[0] > 150)
            x11_send.Sender(self.display.name).drop(window, [scan])
            self.wait("a dropped scan is compared with the avatar of its run", lambda: is_photo(False))
            self.xdotool("key", "--window", window, "Right")
            self.wait("the arrow goes to the next frame", lambda: is_photo(True))
            self.xdotool("mousemove", "--window", window, 30, 150, "mousedown", 1, "mouseup", 1)
            self.xdotool("key", "--window", window, "Left")
            self.wait("the photograph gives way where the mouse was", lambda: not is_photo(False))
            self.xdotool("key", "--window", window, "Escape")
            x11_send.Sender(self.display.name).close(window)
            expect(process.wait(timeout=PATIENCE_S) == 0, "the window closes, with nothing from the validation layer")
        finally:
            if process.poll() is None:
                process.kill()

    def opening(self):
        """The window that chooses a file, what it opens, and what the next start remembers."""
        folder = self.work / "files"
        folder.mkdir()
        shutil.copy(self.avatar, folder / "only.glb")
        settings = self.work / ".config/doppel/viewer.json"
        process, window = self.start("--room", "none", "--size", "900x700")
        try:
            x11_send.Sender(self.display.name).drop(window, [folder / "only.glb"])
            self.wait("what was opened is remembered", lambda: settings.exists() and "only.glb" in settings.read_text())
            red = lambda: self.figures("colour", self.capture(window, "open_window.png"), 450, 300)[0]
            self.wait("the avatar is in the window", lambda: red() > 150)
            self.xdotool("key", "--window", window, "o")
            self.wait("the key O opens the window over it", lambda: red() < 100)
            self.capture(window, "open_list.png")
            self.wait("its folder is remembered", lambda: json.loads(settings.read_text())["folder"] == str(self.work))
            self.xdotool("key", "--window", window, "Escape")
            self.wait("Escape closes it", lambda: red() > 150)
            x11_send.Sender(self.display.name).close(window)
            expect(process.wait(timeout=PATIENCE_S) == 0, "the window closes, with nothing from the validation layer")
        finally:
            if process.poll() is None:
                process.kill()
        settings.write_text(json.dumps({"recent": [str(folder / "only.glb"), str(folder / "gone.glb")], "room": "bright"}))
        process, window = self.start("--size", "900x700")
        try:
            self.wait("the room of the last time is there", lambda: min(self.figures("colour", self.capture(window, "kept.png"), 450, 100)) > 100)
            self.xdotool("mousemove", "--window", window, 60, 153, "click", 1)  # the first of what was opened lately
            red = lambda: self.figures("colour", self.capture(window, "recent_window.png"), 450, 300)
            self.wait("a click opens what was opened lately", lambda: red()[0] > 150 and red()[1] < 90)
            x11_send.Sender(self.display.name).close(window)
            process.wait(timeout=PATIENCE_S)
        finally:
            if process.poll() is None:
                process.kill()

    def refusals(self):
        """What a user reads where no window can open."""
        nowhere = dict(self.environment, DISPLAY=":no-such-display")
        result = self.run("--timings", environment=nowhere)
        expect(result.returncode == 1 and result.stderr.startswith("doppel-viewer: cannot open a window: ") and "program loaded" in result.stdout,
               f"without a display the viewer says why, and how long it took: {result.stderr.strip()}")
        result = self.run(environment=dict(self.environment, VK_DRIVER_FILES="/no/driver.json", VK_ICD_FILENAMES="/no/driver.json"))
        expect(result.returncode == 1 and result.stderr.startswith("doppel-viewer: no Vulkan driver ") and len(result.stderr.splitlines()) == 1,
               f"without a driver too: {result.stderr.strip()}")

    def capture(self, window, name):
        path = self.work / name
        # Of a window that is gone, `import` waits for somebody to click on another.
        subprocess.run(["import", "-display", self.display.name, "-window", str(window), path], check=True, timeout=PATIENCE_S)
        return path

    def xdotool(self, *words):
        return subprocess.run(["xdotool", *map(str, words)], env=self.environment, check=True, capture_output=True, text=True).stdout

    def wait(self, what, condition):
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            if condition():
                expect(True, what)
                return True
            time.sleep(0.1)
        expect(False, what)
        return False

    def stands_still(self, window):
        """Whether four pictures in a row are the same."""
        first = self.capture(window, "still.png")
        for _ in range(3):
            time.sleep(0.1)
            if self.figures("differ", first, self.capture(window, "later.png"))[0] >= 0.1:
                return False
        return True

    def start(self, *words, preexec=None):
        log = open(self.work / "session.log", "w")
        process = subprocess.Popen([self.viewer, "--validation", *map(str, words)], cwd=self.work, env=self.environment, stderr=log,
                                   preexec_fn=preexec)
        window = int(self.xdotool("search", "--sync", "--onlyvisible", "--name", "^Doppel$").split()[0])
        return process, window

    def session(self):
        process, window = self.start(self.avatar, "--room", "bright", "--hide-panels", "--size", "420x300")
        sender = x11_send.Sender(self.display.name)
        log = self.work / "session.log"
        try:
            def centre_is_red():
                red, green, _ = self.figures("colour", self.capture(window, "window.png"), 210, 170)
                return red > 150 and green < 90
            self.wait("the avatar is in the window", centre_is_red)
            self.xdotool("mousemove", "--window", window, 300, 200, "key", "--window", window, "space")
            self.wait("space has paused the clip", lambda: self.stands_still(window))
            before = self.capture(window, "before.png")
            self.xdotool("mousedown", 1, "mousemove", "--window", window, 330, 205, "mousemove", "--window", window, 380, 220, "mouseup", 1)
            self.wait("dragging turns the camera", lambda: self.figures("differ", before, self.capture(window, "turned.png"))[0] > 3)

            def changes(what, least, *words):
                self.wait("the camera has come to rest", lambda: self.stands_still(window))
                picture = self.capture(window, "before_step.png")
                self.xdotool(*words)
                self.wait(what, lambda: self.figures("differ", picture, self.capture(window, "after_step.png"))[0] > least)
                return picture
            changes("F1 lists keys and mouse", 3, "key", "--window", window, "F1")
            changes("F1 again closes the list", 3, "key", "--window", window, "F1")
            changes("a double click goes nearer to the place", 3, "mousemove", "--window", window, 230, 190, "click", "--repeat", 2, "--delay", 40, 1)
            changes("the key 1 shows the whole body", 3, "key", "--window", window, "1")
            changes("the wheel goes nearer", 1, "mousemove", "--window", window, 200, 150, "click", "--repeat", 3, "--delay", 60, 4)
            changes("the key 3 says that no joint is a hand", 1, "key", "--window", window, "3")

            self.wait("the camera has come to rest", lambda: self.stands_still(window))
            broken = self.work / "broken.glb"
            before = self.capture(window, "before_drop.png")
            sender.drop(window, [broken])
            self.wait("a broken file is named on standard error", lambda: "broken.glb: " in log.read_text())
            self.wait("its sentence appears in the window", lambda: self.figures("differ", before, self.capture(window, "error.png"))[0] > 1)

            for width, height in ((640, 400), (200, 150), (500, 420)):
                self.xdotool("windowsize", window, width, height)

                def fills_the_window():  # the bright room reaches into every corner
                    picture = self.capture(window, "resized.png")
                    corners = [(3, 3), (width - 4, 3), (3, height - 40)]
                    try:
                        return all(min(self.figures("colour", picture, *corner)) > 60 for corner in corners)
                    except RuntimeError:  # the window does not have its size yet
                        return False
                self.wait(f"the picture fills {width} x {height}", fills_the_window)
            sender.drop(window, [self.avatar])
            sender.close(window)  # while the avatar may still be loading
            expect(process.wait(timeout=PATIENCE_S) == 0, "the window closes, with nothing from the validation layer")
        finally:
            if process.poll() is None:
                process.kill()
        expect("validation" not in log.read_text(), "standard error has only the broken file's sentence: " + log.read_text().strip())

        process, window = self.start(self.avatar, self.avatar, self.avatar)
        sender.close(window)
        expect(process.wait(timeout=PATIENCE_S) == 0 and not log.read_text(), "closing at once is clean " + log.read_text())


def prepare(arguments):
    """Empties the work folder. Ends the test where a program that it needs is missing."""
    for program in ("Xvfb", "xdotool", "import"):
        if not shutil.which(program):
            skip(f"the program {program} is not installed (Debian: xvfb, xdotool, imagemagick)")
    cache = arguments.work / "cache"
    for path in arguments.work.glob("*") if arguments.work.exists() else []:
        if path != cache:  # the self-test of the driver takes seconds
            shutil.rmtree(path) if path.is_dir() else path.unlink()
    cache.mkdir(parents=True, exist_ok=True)


def main():
    parser = argparse.ArgumentParser()
    for name in ("viewer", "check"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--work", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    prepare(arguments)
    display = Display()
    try:
        test = Test(arguments, display)
        test.scripts()
        test.refusals()
        test.watching()
        test.comparing()
        test.opening()
        test.session()
    finally:
        display.close()
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
