#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Converts the tiny model and refuses damaged ones.

    converter_test.py SOURCE OUT     SOURCE: the repository; OUT receives tiny.onnx and expected.json for converted_network_test.cpp
"""
import hashlib
import json
import pathlib
import sys
import tempfile
import unittest

SOURCE, OUT = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
sys.path.insert(0, str(SOURCE / "tools" / "tfjs2onnx"))
sys.path.insert(0, str(SOURCE / "tests" / "models"))
from convert import convert  # noqa: E402
from tfjs_model import ModelError  # noqa: E402
from tiny_model import SIDE, TinyModel  # noqa: E402


class Converter(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = pathlib.Path(self.folder.name) / "tiny.json"
        self.topology, self.weights = TinyModel().files()
        self.write(self.topology, self.weights)

    def write(self, topology, weights):
        self.path.write_bytes(topology)
        (self.path.parent / "tiny.bin").write_bytes(weights)

    def convert(self):
        return convert(self.path, "tiny", "a test")

    def refuses(self, *words):
        with self.assertRaises(ModelError) as caught:
            self.convert()
        for word in words:
            self.assertIn(word, str(caught.exception))

    def changed(self, change):
        root = json.loads(self.topology)
        change(root, {n["name"]: n for n in root["modelTopology"]["node"]})
        self.write(json.dumps(root).encode(), self.weights)

    def test_same_model_gives_same_bytes(self):
        first = self.convert()
        self.assertEqual(hashlib.sha256(first).digest(), hashlib.sha256(self.convert()).digest())
        OUT.mkdir(parents=True, exist_ok=True)
        (OUT / "tiny.onnx").write_bytes(first)
        # The picture of converted_network_test.cpp: in the order c, y, x, value i is (i·7919 mod 1000) / 1000.
        picture = [[[((c * SIDE + y) * SIDE + x) * 7919 % 1000 / 1000 for c in range(3)] for x in range(SIDE)] for y in range(SIDE)]
        expected = TinyModel().evaluate(picture)
        self.assertGreater(max(expected["rows"]) - min(expected["rows"]), 1, "the expected values say nothing")
        (OUT / "expected.json").write_text(json.dumps(expected))

    def test_truncations_are_refused(self):
        for length in range(0, len(self.topology), 61):
            self.write(self.topology[:length], self.weights)
            self.refuses()
        for length in range(0, len(self.weights), 3):
            self.write(self.topology, self.weights[:length])
            self.refuses("download")

    def test_unknown_operation_is_named(self):
        self.changed(lambda root, nodes: nodes["six"].update(op="Erf"))
        self.refuses("six", "Erf")

    def test_what_would_give_other_values_is_refused(self):
        def attribute(name, key, value):
            return lambda root, nodes: nodes[name]["attr"].__setitem__(key, value)
        for change in (attribute("large", "half_pixel_centers", {"b": False}), attribute("large", "align_corners", {"b": True}),
                       attribute("a", "data_format", {"s": "TkNIVw=="}), attribute("a", "padding", {"s": "RVhQTElDSVQ="}),
                       attribute("a", "fused_ops", {"list": {"s": ["Qmlhc0FkZA==", "RWx1"]}}), attribute("blocks", "block_size", {"i": "3"}),
                       lambda root, nodes: nodes["added"].__setitem__("input", ["a", "input"]),
                       lambda root, nodes: nodes["joined"].__setitem__("input", ["first", "map_sigmoid", "axis"])):
            self.changed(change)
            self.refuses()

    def test_loops_missing_nodes_and_foreign_paths_are_refused(self):
        self.changed(lambda root, nodes: nodes["a"]["input"].__setitem__(0, "six"))
        self.refuses("loop")
        self.changed(lambda root, nodes: nodes["a"]["input"].__setitem__(0, "nowhere"))
        self.refuses("nowhere")
        self.changed(lambda root, nodes: root["weightsManifest"][0].__setitem__("paths", ["../tiny.bin"]))
        self.refuses("beside")
        self.changed(lambda root, nodes: root["signature"]["outputs"].__setitem__("six", root["signature"]["outputs"].pop("map")))
        self.refuses("six")

    def test_weights_that_are_not_finite_are_refused(self):
        at = 0
        for entry in json.loads(self.topology)["weightsManifest"][0]["weights"]:
            if entry["name"] == "a/weights":
                break
            at += 4 * 8
        self.write(self.topology, self.weights[:at] + b"\x00\x7c" + self.weights[at + 2:])  # infinity in 16 bits
        self.refuses("a/weights", "finite")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
