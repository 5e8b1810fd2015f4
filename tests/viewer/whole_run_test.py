#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""From a dropped film to a walking avatar: doppel-viewer without a file, a scan folder dropped, a look of the coach, the run watched to its
end. The run is a real one of scan-tiny, by a preset of few steps, which a program beside the viewer puts in place of the one that was
chosen. Exit 77, with the reason: something is missing."""
import argparse
import json
import os
import pathlib
import shutil
import sys

import viewer_test
import x11_send
from panels_test import HEIGHT, WIDTH, Panels
from viewer_test import PATIENCE_S, expect

FEW = {"like": "draft", "steps": 150, "polishSteps": 20, "poseFitRounds": 5}
DRAFT, LOOK = (36, 78), (40, 164)  # places in the window


def shared_scan():
    """scan-tiny, as tests/unit/shared_data.h finds it."""
    stated = os.environ.get("DOPPEL_SHARED_DATA")
    folders = [pathlib.Path(stated)] if stated else [at / "shared/data" for at in pathlib.Path(__file__).resolve().parents]
    for folder in folders:
        if (folder / "scan-tiny/scan.json").exists():
            return folder / "scan-tiny"
    viewer_test.skip("scan-tiny is not here (shared/data beside the source tree, or $DOPPEL_SHARED_DATA)")


class WholeRun(Panels):
    def with_few_steps(self, doppel):
        """The viewer with a program doppel beside it that takes FEW in place of any preset."""
        (self.work / "few.json").write_text(json.dumps(FEW))
        folder = self.work / "bin"
        folder.mkdir()
        shutil.copy(self.viewer, folder / "doppel-viewer")
        program = folder / "doppel"
        program.write_text("#!/usr/bin/env python3\nimport os, sys\nwords = sys.argv[1:]\n"
                           f"if '--preset' in words: words[words.index('--preset') + 1] = {str(self.work / 'few.json')!r}\n"
                           f"os.execv({str(doppel)!r}, ['doppel', *words])\n")
        program.chmod(0o755)
        self.viewer = str(folder / "doppel-viewer")

    def drop_to_walk(self, scan):
        film = self.work / "films/film"
        film.parent.mkdir()
        film.symlink_to(scan)
        out = self.work / "films/film-avatar"
        process, window = self.start("--size", f"{WIDTH}x{HEIGHT}")
        told = lambda: json.loads((out / "progress.json").read_text()) if (out / "progress.json").exists() else {}
        try:
            x11_send.Sender(self.display.name).drop(window, [film])
            blue = lambda *place: self.figures("colour", self.capture(window, "whole.png"), *place)[2] > 90
            self.wait("a dropped film is offered to be made", lambda: blue(*LOOK))
            self.press(window, *DRAFT)
            self.capture(window, "whole_1_offered.png")
            self.press(window, *LOOK)
            self.wait("the coach looks", lambda: told().get("state"))
            self.capture(window, "whole_2_coach.png")
            self.wait("it finds no fault, and the run begins", lambda: (out / "viewer-run.json").exists())
            self.wait("the training has begun", lambda: told().get("steps") or told().get("state") in ("failed", "stopped"))
            self.capture(window, "whole_3_training.png")
            foretold = []

            def ends():
                now = told()
                if now.get("run_seconds_left") is not None:
                    foretold.append((now["seconds"], now["run_seconds_left"]))
                return now.get("state") in ("failed", "stopped") or now.get("state") == "done" and (out / "avatar.glb").exists()
            self.wait("the run ends", ends)
            expect(told()["state"] == "done", f"well: {told()['state']} {told()['sentence']}")
            seconds = told()["seconds"]
            print("foretold end, part of the true one:", [round((at + left) / seconds, 2) for at, left in foretold[:: max(1, len(foretold) // 8)]])
            expect(foretold, "it has told how long it will take in all")
            self.wait("it gets the walk of the sample", lambda: list((self.work / "cache/doppel").glob("sample-*.glb")))
            self.wait("the avatar walks by itself", lambda: not self.stands_still(window))
            self.capture(window, "whole_4_walks.png")
            expect(not (self.work / "session.log").read_text(), "without a complaint " + (self.work / "session.log").read_text())
            x11_send.Sender(self.display.name).close(window)
            expect(process.wait(timeout=PATIENCE_S) == 0, "the window closes, with nothing from the validation layer")
        finally:
            if process.poll() is None:
                process.kill()
        print(f"the run took {seconds} s")


def main():
    parser = argparse.ArgumentParser()
    for name in ("viewer", "check", "doppel"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--work", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    scan = shared_scan()
    viewer_test.prepare(arguments)
    display = viewer_test.Display()
    try:
        test = WholeRun(arguments, display)
        test.with_few_steps(arguments.doppel)
        test.drop_to_walk(scan)
    finally:
        display.close()
    return 1 if viewer_test.failures else 0


if __name__ == "__main__":
    sys.exit(main())
