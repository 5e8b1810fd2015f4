#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares a converted network, run by OpenCV, with an evaluation of the original graph by NumPy in double precision. Not part of the test
run: it needs python3-numpy, python3-opencv and a downloaded package of networks (tools/networks.json).

    compare_with_numpy.py MODEL.json     converts MODEL.json, with its weights beside it, and compares on three pictures: noise, a
                                         gradient, and a bright disc; exit 1 when a value differs by more than 1e-4 of the largest
"""
import pathlib
import sys
import tempfile

import cv2
import numpy as np

SOURCE = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "tools" / "tfjs2onnx"))
from convert import convert  # noqa: E402
from tfjs_model import Attributes, Model  # noqa: E402

TOLERANCE = 1e-4  # of the largest value of an output; 32-bit sums of up to thousands of products


def windows(x, kernel, stride, padding, fill):
    """The input of each place of the result: N, H, W, taps, C."""
    size = [-(-x.shape[1 + i] // stride) if padding == "SAME" else (x.shape[1 + i] - kernel[i]) // stride + 1 for i in (0, 1)]
    total = [max(0, (size[i] - 1) * stride + kernel[i] - x.shape[1 + i]) if padding == "SAME" else 0 for i in (0, 1)]
    x = np.pad(x, [(0, 0)] + [(t // 2, t - t // 2) for t in total] + [(0, 0)], constant_values=fill)
    return np.stack([x[:, ky:ky + (size[0] - 1) * stride + 1:stride, kx:kx + (size[1] - 1) * stride + 1:stride]
                     for ky in range(kernel[0]) for kx in range(kernel[1])], axis=3)


def activate(x, fused):
    for kind in fused:
        x = {"Relu": lambda v: np.maximum(v, 0), "Relu6": lambda v: np.clip(v, 0, 6), "Sigmoid": lambda v: 1 / (1 + np.exp(-v))}[kind](x)
    return x


def evaluate(model, picture):
    """Values of all outputs, in TensorFlow's order."""
    values = {name: np.array(t.values, np.float64).reshape(t.shape) for name, t in model.constants.items()}
    nodes = {n["name"]: n for n in model.nodes}

    def compute(key):
        stack = [key]
        while stack:
            top = stack[-1]
            needed = [i.split(":")[0] for i in nodes[top].get("input", []) if not i.startswith("^")]
            missing = [i for i in needed if i not in values]
            if top in values or not missing:
                stack.pop()
                if top not in values:
                    values[top] = run(nodes[top], [values[i] for i in needed])
            else:
                stack += missing
        return values[key]

    def run(node, x):
        op, a = node["op"].lstrip("_"), Attributes(node)
        fused = a.texts("fused_ops")
        bias = x[2] if fused and op != "Conv2DBackpropInput" else 0
        if op == "Placeholder":
            return picture
        if op == "Identity":
            return x[0]
        if op in ("Relu", "Relu6", "Sigmoid"):
            return activate(x[0], [op])
        if op in ("AddV2", "Add", "AddN"):
            return sum(x[1:], x[0])
        if op == "Mul":
            return x[0] * x[1]
        if op in ("FusedMatMul", "MatMul"):
            return activate(x[0] @ x[1] + bias, fused[1:])
        if op == "Mean":
            return x[0].mean(axis=tuple(x[1].astype(int)), keepdims=a.boolean("keep_dims"))
        if op == "Reshape":
            return x[0].reshape(x[1].astype(int))
        if op == "ConcatV2":
            return np.concatenate(x[:-1], axis=int(x[-1]))
        if op == "Pad":
            return np.pad(x[0], x[1].astype(int))
        strides, padding = a.integers("strides"), a.text("padding")
        if op == "MaxPool":
            return windows(x[0], a.integers("ksize")[1:3], strides[1], padding, -np.inf).max(axis=3)
        if op in ("FusedConv2D", "Conv2D"):
            w = x[1]
            out = np.tensordot(windows(x[0], w.shape[:2], strides[1], padding, 0), w.reshape(-1, *w.shape[2:]), axes=([3, 4], [0, 1]))
            return activate(out + bias, fused[1:])
        if op in ("FusedDepthwiseConv2dNative", "DepthwiseConv2dNative"):
            w = x[1]
            out = np.einsum("nhwtc,tcm->nhwcm", windows(x[0], w.shape[:2], strides[1], padding, 0), w.reshape(-1, *w.shape[2:]))
            return activate(out.reshape(*out.shape[:3], -1) + bias, fused[1:])
        if op == "Conv2DBackpropInput":
            size, w, source = x[0].astype(int), x[1], x[2]
            out = np.zeros((1, size[1] + w.shape[0], size[2] + w.shape[1], size[3]))
            margin = [((source.shape[1 + i] - 1) * strides[1] + w.shape[i] - size[1 + i]) // 2 for i in (0, 1)]
            for y in range(source.shape[1]):
                for c in range(source.shape[2]):
                    out[0, y * strides[1]:y * strides[1] + w.shape[0], c * strides[1]:c * strides[1] + w.shape[1]] += w @ source[0, y, c]
            return out[:, margin[0]:margin[0] + size[1], margin[1]:margin[1] + size[2]]
        raise SystemExit(f"{node['name']}: {op} is not in this reference")

    return {name: compute(key) for name, key in model.outputs.items()}


def pictures(side):
    y, x = np.mgrid[0:side, 0:side] / side
    disc = ((x - 0.4) ** 2 + (y - 0.6) ** 2 < 0.1).astype(float)
    return {"noise": np.random.default_rng(7).random((side, side, 3)), "gradient": np.stack([x, y, x * y], axis=2),
            "disc": np.stack([disc, 0.6 * disc, 0.2 + 0.3 * disc], axis=2)}


def main():
    path = pathlib.Path(sys.argv[1])
    model = Model(path)
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "network.onnx"
        file.write_bytes(convert(path, path.stem, "compared with NumPy"))
        net = cv2.dnn.readNetFromONNX(str(file))
    side = next(iter(model.inputs.values()))[1]
    names, bad = list(model.outputs), 0
    for title, picture in pictures(side).items():
        picture = picture.astype(np.float32)
        net.setInput(np.ascontiguousarray(picture.transpose(2, 0, 1)[None]))
        found, expected = net.forward(names), evaluate(model, picture[None].astype(np.float64))
        for name, value in zip(names, found):
            should = expected[name].transpose(0, 3, 1, 2) if expected[name].ndim == 4 else expected[name]
            worst, largest = float(np.abs(value - should).max()), float(np.abs(should).max())
            print(f"{path.stem}, {title}, {name}: {value.size} values to {largest:.4g}, largest difference {worst:.2g}")
            bad += not worst <= TOLERANCE * max(1.0, largest)
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
