#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fetches a tiny archive with tools/models from a server of this process, which cuts, lies and refuses; and kills `doppel setup` in the
middle of it.

    fetch_test.py SOURCE [DOPPEL]     SOURCE: the repository; DOPPEL: the program, without which nothing is killed
"""
import fcntl
import hashlib
import http.server
import io
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import sys
import tarfile
import tempfile
import threading
import unittest

SOURCE = pathlib.Path(sys.argv[1])
DOPPEL = sys.argv[2] if len(sys.argv) > 2 else None
BLOCK = 256 * 1024  # tools/models keeps what it fetched in such blocks
sys.path.insert(0, str(SOURCE / "tools" / "tfjs2onnx"))
sys.path.insert(0, str(SOURCE / "tests" / "models"))
from convert import convert  # noqa: E402
from tiny_model import TinyModel  # noqa: E402


class Server(http.server.BaseHTTPRequestHandler):
    archive, cut_after, ranges, served = b"", None, True, []
    go_on = None  # an event: what comes after `cut_after` is held back until it is set

    def do_GET(self):
        begin = 0
        if self.ranges and (wanted := self.headers.get("Range")):
            begin = int(wanted.removeprefix("bytes=").rstrip("-"))
        Server.served.append(begin)
        body = self.archive[begin:]
        self.send_response(206 if begin else 200)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body if self.cut_after is None else body[:self.cut_after])
        if self.go_on:
            self.wfile.flush()
            self.go_on.wait(600)

    def log_message(self, *_):
        pass


class Served(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        self.out = self.folder / "models"
        topology, weights = TinyModel().files()
        (self.folder / "tiny.json").write_bytes(topology)
        (self.folder / "tiny.bin").write_bytes(weights)
        self.note = "Weights: Tiny, Google MediaPipe, Apache-2.0. Converted from tiny@1 by Doppel's tools/models."
        self.network = convert(self.folder / "tiny.json", "tiny", self.note)
        packed = io.BytesIO()
        with tarfile.open(fileobj=packed, mode="w:gz") as package:
            for name, data in (("LICENSE", b"MIT"), ("models/tiny.json", topology), ("models/tiny.bin", weights),
                               ("filling", os.urandom(300_000))):
                member = tarfile.TarInfo("package/" + name)
                member.size = len(data)
                package.addfile(member, io.BytesIO(data))
        Server.archive, Server.cut_after, Server.ranges, Server.served, Server.go_on = packed.getvalue(), None, True, [], None
        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Server)
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        self.addCleanup(self.server.server_close)
        self.addCleanup(self.server.shutdown)
        self.pins = {"package": "tiny@1", "url": f"http://127.0.0.1:{self.server.server_port}/tiny.tgz", "bytes": len(Server.archive), "installed_bytes": len(self.network),
                     "sha256": hashlib.sha256(Server.archive).hexdigest(), "package_licence": "MIT", "weights": "Tiny weights",
                     "weights_licence": "Apache-2.0",
                     "networks": [{"model": "tiny", "title": "Tiny", "file": "tiny.onnx",
                                   "sha256": hashlib.sha256(self.network).hexdigest()}]}

    def installed(self, run):
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual((self.out / "tiny.onnx").read_bytes(), self.network)
        self.assertEqual(sorted(p.name for p in self.out.iterdir()), [".setup.lock", "LICENCE.txt", "tiny.onnx"], "the archive goes")


class Fetch(Served):
    def run_models(self, *arguments, limit_bytes=None):
        (self.folder / "pins.json").write_text(json.dumps(self.pins))
        environment = {k: v for k, v in os.environ.items() if "proxy" not in k.lower()}
        limit = (lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit_bytes, limit_bytes))) if limit_bytes else None
        run = subprocess.run([sys.executable, SOURCE / "tools" / "models", "--pins", self.folder / "pins.json", "--out", self.out, *arguments],
                             capture_output=True, text=True, timeout=600, env=environment, preexec_fn=limit)
        self.assertNotIn("Traceback", run.stderr)
        return run

    def refuses(self, run, *words):
        self.assertEqual(run.returncode, 1, run.stderr)
        for word in words:
            self.assertIn(word, run.stderr)
        self.assertFalse((self.out / "tiny.onnx").exists())

    def test_fetches_and_installs(self):
        self.installed(self.run_models())
        self.assertEqual(self.run_models("--check").returncode, 0)

    def test_goes_on_where_it_was_cut(self):
        Server.cut_after = 100_000
        self.refuses(self.run_models(), "broke off", "are kept", "Run the same command again")
        kept = (self.out / "archive.part").stat().st_size
        self.assertEqual(kept, 100_000)
        Server.cut_after = None
        self.installed(self.run_models())
        self.assertEqual(Server.served, [0, kept])

    def test_begins_anew_where_the_server_cannot_go_on(self):
        Server.cut_after, Server.ranges = 100_000, False
        self.refuses(self.run_models(), "broke off")
        Server.cut_after = None
        self.installed(self.run_models())

    def test_a_wrong_sum_installs_nothing_and_does_not_stay(self):
        self.pins["sha256"] = "0" * 64
        self.refuses(self.run_models(), "SHA-256 differs", "Nothing was installed", "run the same command again")
        self.assertFalse((self.out / "archive.part").exists())

    def test_more_than_the_archive_is_not_taken(self):
        self.pins["bytes"] -= 1000
        self.refuses(self.run_models(), "sends more than")

    def test_without_network(self):
        self.pins["url"] = "http://127.0.0.1:9/tiny.tgz"
        self.refuses(self.run_models(), "cannot fetch from 127.0.0.1:9", "Check the network", "--package")

    def test_a_full_disk_keeps_what_is_there(self):
        self.refuses(self.run_models(limit_bytes=150_000), "the disk is full", "goes on from here")
        self.assertGreater((self.out / "archive.part").stat().st_size, 0)
        self.installed(self.run_models())
        self.assertGreater(Server.served[1], 0)

    def test_an_archive_at_hand_is_not_fetched_and_stays(self):
        archive = self.folder / "mine.tgz"
        archive.write_bytes(Server.archive)
        self.installed(self.run_models("--package", archive))
        self.assertEqual(Server.served, [])
        self.assertTrue(archive.exists())

    def test_what_a_killed_conversion_left_goes(self):
        (self.out / ".convert-killed").mkdir(parents=True)
        (self.out / ".convert-killed" / "tiny.bin").write_bytes(b"half")
        self.installed(self.run_models())

    def test_says_what_it_would_fetch(self):
        text = self.run_models("--describe").stdout
        for word in ("Tiny weights", "Apache-2.0", "MIT", "127.0.0.1", "MiB"):
            self.assertIn(word, text)
        self.assertFalse(self.out.exists())


@unittest.skipUnless(DOPPEL, "no program to kill")
class KilledSetup(Served):
    """An installed `doppel setup`, with the archive of these tests in the place of the real one."""

    def setUp(self):
        super().setUp()
        self.out = self.folder / "share" / "doppel" / "models"
        installed = self.folder / "prefix" / "share" / "doppel" / "setup"
        for folder in (installed, self.folder / "prefix" / "bin", self.folder / "bin"):
            folder.mkdir(parents=True)
        shutil.copy2(DOPPEL, self.folder / "prefix" / "bin" / "doppel")
        shutil.copy2(SOURCE / "tools" / "models", installed)
        shutil.copytree(SOURCE / "tools" / "tfjs2onnx", installed / "tfjs2onnx")
        (installed / "networks.json").write_text(json.dumps(self.pins))
        (self.folder / "bin" / "python3").symlink_to(sys.executable)
        for program in ("ffmpeg", "colmap"):  # only the networks are missing
            (self.folder / "bin" / program).write_text("#!/bin/sh\n")
            (self.folder / "bin" / program).chmod(0o755)

    def begin(self):
        return subprocess.Popen([self.folder / "prefix" / "bin" / "doppel", "setup", "--yes"], stdin=subprocess.DEVNULL, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                env={"PATH": str(self.folder / "bin"), "XDG_DATA_HOME": str(self.folder / "share")})

    def set_up(self):
        process = self.begin()
        text = process.communicate(timeout=600)[0]
        return subprocess.CompletedProcess(process.args, process.returncode, text, text)

    def begin_until_a_block_is_kept(self):
        """A setup whose fetch waits for more. Returns it and its fetch."""
        Server.cut_after, Server.go_on = BLOCK + 1000, threading.Event()
        self.addCleanup(Server.go_on.set)
        setup = self.begin()
        self.addCleanup(setup.stdout.close)
        line = " "
        while not re.match(r"  [\d.]+ MiB of ", line):  # the first line of progress comes after the first block
            self.assertTrue(line, "it ended by itself")
            line = setup.stdout.readline()
        fetch = "".join(path.read_text() for path in pathlib.Path(f"/proc/{setup.pid}/task").glob("*/children"))
        return setup, int(fetch)

    def server_goes_on(self):
        Server.go_on.set()
        Server.cut_after, Server.go_on = None, None

    def test_all_of_it_is_killed_and_the_next_one_goes_on(self):
        setup, fetch = self.begin_until_a_block_is_kept()
        setup.kill()
        os.kill(fetch, signal.SIGKILL)
        setup.wait()
        self.server_goes_on()
        kept = (self.out / "archive.part").read_bytes()
        self.assertEqual(kept, Server.archive[:BLOCK])
        with open(self.out / ".setup.lock") as lock:  # until the killed fetch is gone
            fcntl.flock(lock, fcntl.LOCK_EX)
        run = self.set_up()
        self.installed(run)
        self.assertIn("going on after", run.stdout)
        self.assertEqual(Server.served, [0, BLOCK])
        self.assertIn("Everything is there", self.set_up().stdout)

    def test_the_program_is_killed_and_its_fetch_lives_on(self):
        setup, _ = self.begin_until_a_block_is_kept()
        setup.kill()
        setup.wait()
        run = self.set_up()
        self.assertEqual(run.returncode, 1, run.stdout)
        self.assertIn("another setup writes", run.stdout)
        self.server_goes_on()
        with open(self.out / ".setup.lock") as lock:  # until the fetch has heard that its server is gone
            fcntl.flock(lock, fcntl.LOCK_EX)
        self.installed(self.set_up())
        self.assertGreaterEqual(Server.served[1], BLOCK)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
