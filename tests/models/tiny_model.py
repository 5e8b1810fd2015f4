# SPDX-License-Identifier: Apache-2.0
"""A made-up TensorFlow.js model, and an evaluation of it in plain Python, in TensorFlow's order N, H, W, C."""
import base64
import itertools
import json
import math
import random
import struct

SIDE = 8  # of the input; odd paddings and windows that do not divide it are among the layers


def _text(value):
    return {"s": base64.b64encode(value.encode()).decode()}


def _list(values):
    return {"list": {"i": [str(v) for v in values]}}


class TinyModel:
    """Builds nodes and weights. evaluate() runs them on a picture given as a function of (y, x, c)."""

    def __init__(self):
        self.random = random.Random(7)
        self.nodes, self.entries, self.data, self.constants = [], [], b"", {}
        self.nodes.append({"name": "input", "op": "Placeholder", "attr": {}})
        self._layers()

    def weights(self, name, shape, store="float16"):
        count = math.prod(shape)
        values = [self.random.uniform(-1, 1) for _ in range(count)]
        entry = {"name": name, "shape": shape, "dtype": "float32"}
        if store == "float16":
            raw = struct.pack(f"<{count}e", *values)
            values = list(struct.unpack(f"<{count}e", raw))
            entry["quantization"] = {"dtype": "float16", "original_dtype": "float32"}
        elif store == "uint8":
            codes = [self.random.randrange(256) for _ in range(count)]
            raw, values = bytes(codes), [c * 0.0078125 - 1.0 for c in codes]
            entry["quantization"] = {"dtype": "uint8", "scale": 0.0078125, "min": -1.0}
        else:
            raw = struct.pack(f"<{count}f", *values)
            values = list(struct.unpack(f"<{count}f", raw))
        self._constant(name, entry, raw, shape, values)
        return name

    def numbers(self, name, shape, values):
        self._constant(name, {"name": name, "shape": shape, "dtype": "int32"}, struct.pack(f"<{len(values)}i", *values), shape, values)
        return name

    def _constant(self, name, entry, raw, shape, values):
        self.entries.append(entry)
        self.data += raw
        self.constants[name] = (shape, values)
        self.nodes.append({"name": name, "op": "Const", "attr": {}})

    def node(self, op, name, inputs, **attributes):
        self.nodes.append({"name": name, "op": op, "input": inputs, "attr": attributes})
        return name

    def conv(self, name, source, shape, stride, padding, fused, depthwise=False, store="float16"):
        inputs = [source, self.weights(name + "/weights", shape, store)]
        attributes = {"strides": _list([1, stride, stride, 1]), "padding": _text(padding), "data_format": _text("NHWC"),
                      "dilations": _list([1, 1, 1, 1])}
        op = "DepthwiseConv2dNative" if depthwise else "Conv2D"
        if fused:
            inputs.append(self.weights(name + "/bias", [shape[2] * shape[3] if depthwise else shape[3]], "float32"))
            attributes["fused_ops"] = {"list": {"s": [base64.b64encode(f.encode()).decode() for f in fused]}}
            op = "FusedDepthwiseConv2dNative" if depthwise else "_FusedConv2D"
        return self.node(op, name, inputs, **attributes)

    def _layers(self):
        pads = self.numbers("pads", [4, 2], [0, 0, 0, 1, 0, 1, 0, 0])
        a = self.conv("a", self.node("Pad", "padded", ["input", pads]), [3, 3, 3, 4], 2, "VALID", ["BiasAdd", "Relu6"])  # 4×4×4
        b = self.conv("b", a, [3, 3, 4, 1], 1, "SAME", ["BiasAdd", "Relu"], depthwise=True, store="uint8")
        c = self.conv("c", b, [1, 1, 4, 4], 1, "VALID", ["BiasAdd"], store="float32")
        added = self.node("Relu6", "six", [self.node("AddV2", "added", [c, a])])
        more = self.node("Pad", "more", [added, self.numbers("channels", [4, 2], [0, 0, 0, 0, 0, 0, 0, 4])])  # 4×4×8
        pooled = self.node("MaxPool", "pooled", [more], ksize=_list([1, 2, 2, 1]), strides=_list([1, 2, 2, 1]), padding=_text("VALID"),
                           data_format=_text("NHWC"))  # 2×2×8
        even = self.conv("even", more, [3, 3, 8, 2], 2, "SAME", [], depthwise=True)  # SAME with stride 2: more padding after than before
        large = self.node("ResizeBilinear", "large", [even, self.numbers("size", [2], [4, 4])], half_pixel_centers={"b": True},
                          align_corners={"b": False})  # 4×4×16
        mixed = self.conv("mixed", large, [1, 1, 16, 4], 1, "SAME", [])
        blocks = self.node("DepthToSpace", "blocks", [mixed], block_size={"i": "2"}, data_format=_text("NHWC"))  # 8×8×1
        map_ = self.node("Sigmoid", "map_sigmoid", [blocks])
        self.node("Identity", "Identity", [map_])
        shape = self.node("Shape", "shape", [pooled])
        batch = self.node("StridedSlice", "batch", [shape] + [self.numbers(f"slice{i}", [1], [v]) for i, v in enumerate((0, 1, 1))],
                          shrink_axis_mask={"i": "1"})
        wanted = self.node("Pack", "wanted", [batch, self.numbers("any", [], [-1]), self.numbers("four", [], [4])], N={"i": "3"}, axis={"i": "0"})
        first = self.node("Reshape", "first", [pooled, wanted])  # 8×4
        other = self.node("Reshape", "other", [mixed, wanted])  # 16×4
        joined = self.node("ConcatV2", "joined", [first, other, self.numbers("axis", [], [1])], N={"i": "2"})  # 24×4
        self.node("Identity", "Identity_1", [joined])
        self._gated_layers(mixed, six=added)

    def _gated_layers(self, mixed, six):
        """A squeeze-and-excite block with hard swish, and what enlarges its result: the operations of selfie segmentation."""
        def number(name, value):
            self._constant(name, {"name": name, "shape": [], "dtype": "float32"}, struct.pack("<f", value), [], [value])
            return name
        biased = self.node("Add", "biased", [self.weights("bias", [4]), mixed])  # 4×4×4
        scaled = self.node("Mul", "scaled", [biased, self.weights("scales", [1, 1, 1, 4])])
        part = self.node("Mul", "part", [number("eighth", 0.125), scaled])
        raised = self.node("AddV2", "raised", [scaled, number("three", 3.0)])
        swish = self.node("Mul", "swish", [part, self.node("Relu6", "high", [raised])])
        mean = self.node("AvgPool", "mean", [swish], ksize=_list([1, 4, 4, 1]), strides=_list([1, 4, 4, 1]), padding=_text("VALID"))
        gate = self.node("Sigmoid", "gate", [self.conv("gates", mean, [1, 1, 4, 4], 1, "VALID", [])])  # 1×1×4
        gated = self.node("Mul", "gated", [gate, swish])
        near = self.node("AvgPool", "near", [gated], ksize=_list([1, 3, 3, 1]), strides=_list([1, 1, 1, 1]), padding=_text("SAME"))
        total = self.node("AddN", "total", [gated, six, near], N={"i": "3"})
        positive = self.node("Relu", "positive", [total])
        self.node("Conv2DBackpropInput", "up",
                  [self.numbers("up/sizes", [4], [1, 8, 8, 2]), self.weights("up/weights", [4, 4, 2, 4]), positive],
                  strides=_list([1, 2, 2, 1]), padding=_text("SAME"), data_format=_text("NHWC"), dilations=_list([1, 1, 1, 1]))  # 8×8×2
        self._rows_of_means(positive)

    def _rows_of_means(self, picture):
        """Means of channels times matrices, with and without what is fused into the product: the ends of the hand's landmarks."""
        means = self.node("Mean", "means", [picture, self.numbers("means/axes", [2], [1, 2])], keep_dims={"b": False})  # 4
        fused = {"fused_ops": {"list": {"s": [base64.b64encode(f.encode()).decode() for f in ("BiasAdd", "Relu")]}}}
        hidden = self.node("_FusedMatMul", "hidden", [means, self.weights("hidden/weights", [4, 6]), self.weights("hidden/bias", [6])], **fused)
        self.node("Sigmoid", "flag", [self.node("MatMul", "flags", [hidden, self.weights("flags/weights", [6, 3])])])

    def files(self):
        """model.json and the weights, as bytes."""
        def port(name, shape):
            return {"name": name + ":0", "dtype": "DT_FLOAT", "tensorShape": {"dim": [{"size": str(s)} for s in shape]}}
        root = {"format": "graph-model",
                "signature": {"inputs": {"input": port("input", [-1, SIDE, SIDE, 3])},
                              "outputs": {"map": port("Identity", [-1, 8, 8, 1]), "rows": port("Identity_1", [-1, 24, 4]),
                                          "up:0": port("up", [1, 8, 8, 2]), "flags:0": port("flag", [1, 3])}},
                "modelTopology": {"node": self.nodes},
                "weightsManifest": [{"paths": ["tiny.bin"], "weights": self.entries}]}
        return json.dumps(root).encode(), self.data

    # The evaluation. A picture is a list of rows of columns of channels.

    def evaluate(self, picture):
        def constant(name):
            return self.constants[name][1]

        def window(source, kernel, stride, padding):
            """For each place of the result, the list of (tap, channels) that lie inside the source."""
            h, w = len(source), len(source[0])
            sizes, begins = [], []
            for size, k in ((h, kernel[0]), (w, kernel[1])):
                out = -(-size // stride) if padding == "SAME" else (size - k) // stride + 1
                sizes.append(out)
                begins.append(max(0, (out - 1) * stride + k - size) // 2 if padding == "SAME" else 0)
            return [[[(ky * kernel[1] + kx, source[oy * stride + ky - begins[0]][ox * stride + kx - begins[1]])
                      for ky in range(kernel[0]) for kx in range(kernel[1])
                      if 0 <= oy * stride + ky - begins[0] < h and 0 <= ox * stride + kx - begins[1] < w]
                     for ox in range(sizes[1])] for oy in range(sizes[0])]

        def conv(name, source, shape, stride, padding, bias, activation, depthwise):
            weights = constant(name + "/weights")
            biases = constant(name + "/bias") if bias else None
            channels, last = shape[2], shape[3]
            count = channels * last if depthwise else last

            def at(taps, o):
                total = biases[o] if biases else 0.0
                for tap, pixel in taps:
                    if depthwise:
                        total += pixel[o // last] * weights[(tap * channels + o // last) * last + o % last]
                    else:
                        total += sum(pixel[i] * weights[(tap * channels + i) * last + o] for i in range(channels))
                return activation(total)
            return [[[at(taps, o) for o in range(count)] for taps in row] for row in window(source, shape[:2], stride, padding)]

        def each(function, *pictures):
            return [[[function(*v) for v in zip(*pixels)] for pixels in zip(*rows)] for rows in zip(*pictures)]

        def six(x):
            return min(6.0, max(0.0, x))

        def relu(x):
            return max(0.0, x)

        def same(x):
            return x

        padded = [row + [[0.0] * 3] for row in picture] + [[[0.0] * 3] * (SIDE + 1)]
        a = conv("a", padded, [3, 3, 3, 4], 2, "VALID", True, six, False)
        b = conv("b", a, [3, 3, 4, 1], 1, "SAME", True, relu, True)
        c = conv("c", b, [1, 1, 4, 4], 1, "VALID", True, same, False)
        added = each(lambda x, y: six(x + y), c, a)
        more = [[pixel + [0.0] * 4 for pixel in row] for row in added]
        pooled = [[[max(pixel[k] for _, pixel in taps) for k in range(8)] for taps in row] for row in window(more, [2, 2], 2, "VALID")]
        even = conv("even", more, [3, 3, 8, 2], 2, "SAME", False, same, True)

        def sample(y, x):
            result = [0.0] * 16
            fy, fx = (y + 0.5) / 2 - 0.5, (x + 0.5) / 2 - 0.5
            for iy in (math.floor(fy), math.floor(fy) + 1):
                for ix in (math.floor(fx), math.floor(fx) + 1):
                    share = (1 - abs(fy - iy)) * (1 - abs(fx - ix))
                    pixel = even[min(1, max(0, iy))][min(1, max(0, ix))]
                    result = [r + share * p for r, p in zip(result, pixel)]
            return result
        large = [[sample(y, x) for x in range(4)] for y in range(4)]
        mixed = conv("mixed", large, [1, 1, 16, 4], 1, "SAME", False, same, False)
        blocks = [[1 / (1 + math.exp(-mixed[y // 2][x // 2][y % 2 * 2 + x % 2])) for x in range(8)] for y in range(8)]
        flat = [v for row in pooled for pixel in row for v in pixel] + [v for row in mixed for pixel in row for v in pixel]

        bias, scales = constant("bias"), constant("scales")
        scaled = [[[(v + b) * s for v, b, s in zip(pixel, bias, scales)] for pixel in row] for row in mixed]
        swish = each(lambda x: x * 0.125 * six(x + 3.0), scaled)

        def mean(taps, k):
            return sum(pixel[k] for _, pixel in taps) / len(taps)  # of the places inside the picture
        means = [[[mean(taps, k) for k in range(4)] for taps in row] for row in window(swish, [4, 4], 4, "VALID")]
        gate = conv("gates", means, [1, 1, 4, 4], 1, "VALID", False, lambda x: 1 / (1 + math.exp(-x)), False)[0][0]
        gated = [[[v * g for v, g in zip(pixel, gate)] for pixel in row] for row in swish]
        near = [[[mean(taps, k) for k in range(4)] for taps in row] for row in window(gated, [3, 3], 1, "SAME")]
        positive = each(lambda x, y, z: relu(x + y + z), gated, added, near)
        # Each number spreads over the places from which a convolution with stride 2 and a margin of 1 would gather it.
        up, weights = [[[0.0] * 8 for _ in range(8)] for _ in range(2)], constant("up/weights")
        for y, x, ky, kx in itertools.product(range(4), range(4), range(4), range(4)):
            to_y, to_x = 2 * y - 1 + ky, 2 * x - 1 + kx
            if 0 <= to_y < 8 and 0 <= to_x < 8:
                for o, k in itertools.product(range(2), range(4)):
                    up[o][to_y][to_x] += positive[y][x][k] * weights[((ky * 4 + kx) * 2 + o) * 4 + k]
        means = [sum(pixel[k] for row in positive for pixel in row) / 16 for k in range(4)]

        def times(row, name, columns):
            return [sum(v * constant(name)[i * columns + c] for i, v in enumerate(row)) for c in range(columns)]
        hidden = [relu(v + b) for v, b in zip(times(means, "hidden/weights", 6), constant("hidden/bias"))]
        flags = [1 / (1 + math.exp(-v)) for v in times(hidden, "flags/weights", 3)]
        return {"map": [v for row in blocks for v in row], "rows": flat, "up:0": [v for plane in up for row in plane for v in row],
                "flags:0": flags}
