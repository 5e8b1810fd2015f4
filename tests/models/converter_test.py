#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Converts the tiny model and refuses damaged ones.

    converter_test.py SOURCE OUT     SOURCE: the repository; OUT receives tiny.onnx and expected.json for converted_network_test.cpp
"""
import hashlib
import json
import pathlib
import struct
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

    def changed(self, change, more_weights=b""):
        root = json.loads(self.topology)
        change(root, {n["name"]: n for n in root["modelTopology"]["node"]})
        self.write(json.dumps(root).encode(), self.weights + more_weights)

    def test_same_model_gives_same_bytes(self):
        first = self.convert()
        self.assertEqual(hashlib.sha256(first).digest(), hashlib.sha256(self.convert()).digest())
        OUT.mkdir(parents=True, exist_ok=True)
        (OUT / "tiny.onnx").write_bytes(first)
        # The picture of converted_network_test.cpp: in the order c, y, x, value i is (i·7919 mod 1000) / 1000.
        picture = [[[((c * SIDE + y) * SIDE + x) * 7919 % 1000 / 1000 for c in range(3)] for x in range(SIDE)] for y in range(SIDE)]
        expected = TinyModel().evaluate(picture)
        for output in ("rows", "up:0"):
            self.assertGreater(max(expected[output]) - min(expected[output]), 1, "the expected values say nothing")
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

    def test_shapes_that_do_not_fit_are_refused(self):
        def inputs(name, *values):
            return lambda root, nodes: nodes[name].__setitem__("input", list(values))

        def attribute(name, key, *numbers):
            return lambda root, nodes: nodes[name]["attr"].__setitem__(key, {"list": {"i": [str(v) for v in numbers]}})

        def shape(name, *sizes):
            def change(root, nodes):
                next(e for e in root["weightsManifest"][0]["weights"] if e["name"] == name)["shape"] = list(sizes)
            return change

        for change, words in ((inputs("biased", "gates/weights", "mixed"), ("biased", "does not fit")),  # a constant of 1×1×4×4
                              (inputs("biased", "bias", "large"), ("biased", "does not fit")),  # 4 numbers, 16 channels
                              (shape("bias", 4, 1), ("biased", "does not fit")),  # one number for each column
                              (shape("scales", 1, 1, 1, 1, 4), ("scaled", "does not fit")),  # the result would have five dimensions
                              (inputs("scaled", "joined", "scales"), ("scaled", "does not fit")),  # not a picture
                              (inputs("scaled", "bias", "bias"), ("scaled", "2 of them constants")),
                              (inputs("gated", "mean", "large"), ("gated", "Mul of the shapes")),  # 4 channels and 16
                              (inputs("gated", "pooled", "swish"), ("gated", "Mul of the shapes")),
                              (inputs("total", "gated", "gate", "near"), ("total", "Add of the shapes")),
                              (inputs("total", "gated", "bias", "near"), ("total", "1 of them constants")),
                              (inputs("total", "gated"), ("total", "Add of the shapes")),
                              (attribute("mean", "ksize", 1, 4, 4, 2), ("mean", "pooling of pictures")),
                              (attribute("up", "dilations", 1, 2, 2, 1), ("up", "dilated")),
                              (inputs("up", "up/sizes", "up/weights", "large"), ("up", "do not fit")),
                              (inputs("up", "size", "up/weights", "positive"), ("up", "do not fit")),  # two numbers for a size
                              (shape("up/weights", 4, 4, 4, 2), ("up", "do not fit")),
                              (inputs("means", "joined", "means/axes"), ("means", "is not supported")),  # not a picture
                              (inputs("means", "positive", "axis"), ("means", "is not supported")),  # along one axis
                              (inputs("means", "positive", "mean"), ("mean", "must be a constant")),
                              (shape("hidden/weights", 6, 4), ("hidden", "do not fit")),
                              (inputs("hidden", "positive", "hidden/weights", "hidden/bias"), ("hidden", "do not fit")),
                              (inputs("hidden", "means", "hidden/weights", "flags/weights"), ("hidden", "18 biases for 6")),
                              (lambda root, nodes: nodes["flags"]["attr"].__setitem__("transpose_b", {"b": True}), ("flags", "do not fit"))):
            self.changed(change)
            self.refuses(*words)

    def test_results_of_transposed_convolutions_that_do_not_fit_are_refused(self):
        def result(*sizes, source="positive", stride=2):
            def change(root, nodes):
                root["weightsManifest"][0]["weights"].append({"name": "other/sizes", "shape": [4], "dtype": "int32"})
                root["modelTopology"]["node"].append({"name": "other/sizes", "op": "Const", "attr": {}})
                nodes["up"]["input"] = ["other/sizes", "up/weights", source]
                nodes["up"]["attr"]["strides"] = {"list": {"i": ["1", str(stride), str(stride), "1"]}}
                nodes["up"]["attr"]["padding"] = {"s": "U0FNRQ==" if source == "positive" else "VkFMSUQ="}
            self.changed(change, more_weights=struct.pack("<4i", *sizes))

        result(1, 8, 8, 2)
        self.convert()
        for sizes, word in (((2, 8, 8, 2), "do not fit"), ((1, 8, 8, 3), "do not fit"), ((1, 8, 10, 2), "is not what a convolution"),
                            ((1, 7, 7, 2), "margins of [3, 3]")):  # one pixel off at the beginning and two at the end
            result(*sizes)
            self.refuses("up", word)
        result(1, 8, 8, 2, source="gate", stride=5)  # the window of 4 reaches half of the result
        self.refuses("up", "margins of [-4, -4]")

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
