#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The bill of materials of a release names every file with its sum and every licence inside; the look for GPL libraries finds them.

    release_test.py ROOT LIBDOPPEL [DOPPEL-WITH-GPL-PARTS]
"""
import hashlib
import io
import json
import pathlib
import subprocess
import sys
import tarfile
import tempfile
import unittest

ROOT = pathlib.Path(sys.argv[1]).resolve()
LIBRARY, GPL_PROGRAM = sys.argv[2], (sys.argv[3:] or [None])[0]
sys.path.insert(0, str(ROOT / "tools/packaging"))
import notices  # noqa: E402
import sbom  # noqa: E402


class Release(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        for name in ("doppel-tools_1.0.0~rc.1-1~deb12_amd64.deb", "doppel-web-1.tgz", "sample-built-in.glb"):
            (self.folder / name).write_text(name)
        with tarfile.open(self.folder / "doppel-1-linux-x86_64.tar.gz", "w:gz") as tar:
            text = b"CONTAINS libtbb12 2021.8.0-2 Apache-2.0\n"
            member = tarfile.TarInfo("doppel/licences/contents.txt")
            member.size = len(text)
            tar.addfile(member, io.BytesIO(text))
        notices.version_of = lambda package: "1"  # packages need not be installed where tests run

    def document(self):
        return sbom.document(self.folder, "1", 1_700_000_000)

    def test_names_every_file_with_its_sum(self):
        sums, bill = self.document()
        for file in self.folder.iterdir():
            digest = hashlib.sha256(file.read_bytes()).hexdigest()
            self.assertIn(f"{digest}  {file.name}\n", sums)
            package = next(p for p in bill["packages"] if p["name"] == file.name)
            self.assertEqual(package["checksums"][0]["checksumValue"], digest)

    def test_relates_what_is_inside(self):
        bill = self.document()[1]
        identities = [p["SPDXID"] for p in bill["packages"]]
        self.assertEqual(len(identities), len(set(identities)))
        for relation in bill["relationships"]:
            self.assertIn(relation["relatedSpdxElement"], identities)
        inside = {(r["spdxElementId"], r["relationshipType"], r["relatedSpdxElement"]) for r in bill["relationships"]}
        self.assertIn(("SPDXRef-doppel-1-linux-x86-64.tar.gz", "CONTAINS", "SPDXRef-libtbb12-2021.8.0-2"), inside)
        self.assertIn(("SPDXRef-doppel-web-1.tgz", "STATIC_LINK", "SPDXRef-wasi-libc-1"), inside)
        self.assertIn(("SPDXRef-doppel-tools-1.0.0-rc.1-1-deb12-amd64.deb", "STATIC_LINK", "SPDXRef-libceres-dev-1"), inside)

    def test_same_files_give_the_same_bytes(self):
        self.assertEqual(json.dumps(self.document()[1]), json.dumps(self.document()[1]))

    def test_no_gpl_licence_without_exception_is_compiled_in(self):
        for package, inside in notices.COMPILED_IN.items():
            for name, licence in inside.items():
                self.assertTrue("GPL" not in licence or "WITH" in licence, f"{package}: {name} ({licence})")

    def links(self, program):
        return subprocess.run([ROOT / "tools/prove-release", "--links", program], capture_output=True, text=True, check=False)

    def test_look_for_gpl_libraries(self):
        self.assertEqual(self.links(LIBRARY).returncode, 0)
        if GPL_PROGRAM is None:
            self.skipTest("this build of doppel has no GPL parts to find")
        found = self.links(GPL_PROGRAM)
        self.assertEqual(found.returncode, 1)
        self.assertIn("libcholmod", found.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
