# SPDX-License-Identifier: Apache-2.0
"""Converts a TensorFlow.js graph model to ONNX.

TensorFlow's pictures are N×H×W×C, ONNX' are N×C×H×W. Every value of four dimensions is therefore kept in ONNX' order, and a Transpose back
stands before each Reshape, whose result depends on the order. Shapes are known for every value (the batch is 1), so what computes
shapes becomes a constant.

The result is meant for OpenCV 4.6. It reads min and max of Clip from attributes (opset 10) and half-pixel sampling of Resize from an
attribute (opset 11), so the file carries both and states opset 11. Its transposed convolutions can only take off as much at the
beginning as at the end.
"""
import math

import onnx_writer as onnx
from tfjs_model import Attributes, Model, ModelError, Tensor

OPSET = 11
_NHWC_FROM_NCHW, _NCHW_FROM_NHWC = [0, 2, 3, 1], [0, 3, 1, 2]


def _nchw(shape):
    return [shape[i] for i in _NCHW_FROM_NHWC] if len(shape) == 4 else list(shape)


def _window_size(size, kernel, stride, padding):
    return -(-size // stride) if padding == "SAME" else (size - kernel) // stride + 1


class Converter:
    """Converts one model. `values` holds for each TensorFlow node either a Tensor (a constant) or its shape in TensorFlow's order."""

    def __init__(self, model):
        self.model = model
        self.nodes, self.initializers, self.values, self.renamed = [], [], {}, {}
        self.made = 0

    def run(self, name, note):
        inputs = []
        for node in self._sorted():
            op, key = node["op"], node["name"]
            attributes = Attributes(node)
            arguments = [i.split(":")[0] for i in node.get("input", []) if not i.startswith("^")]
            if op == "Const":
                self.values[key] = self.model.constants[key]
            elif op == "Placeholder":
                shape = [1 if size < 0 and i == 0 else size for i, size in enumerate(self.model.inputs[key])]
                if any(size <= 0 for size in shape):
                    raise ModelError(f"{key}: the input has no fixed size")
                self.values[key] = shape
                inputs.append(onnx.value_info(key, _nchw(shape)))
            else:
                convert = getattr(self, "_op_" + op.lstrip("_"), None)
                if convert is None:
                    raise ModelError(f"{key}: the operation {op} is not supported")
                convert(key, arguments, attributes)
        outputs = []
        for output, key in self.model.outputs.items():
            if output in self.values:
                raise ModelError(f"the output {output!r} has the name of another value")
            shape = self._shape(key)
            self._emit("Identity", [self._name(key)], output, {})
            outputs.append(onnx.value_info(output, _nchw(shape)))
        return onnx.model(name, self.nodes, self.initializers, inputs, outputs, OPSET, note)

    def _sorted(self):
        """The nodes that the outputs need, each after its inputs."""
        nodes = {n["name"]: n for n in self.model.nodes}
        order, state = [], {}
        stack = list(reversed(self.model.outputs.values()))
        while stack:
            key = stack[-1]
            if key not in nodes:
                raise ModelError(f"the graph has no node {key!r}")
            if state.get(key) == "done":
                stack.pop()
            elif state.get(key) == "open":
                state[key] = "done"
                order.append(nodes[key])
                stack.pop()
            else:
                state[key] = "open"
                for i in nodes[key].get("input", []):
                    source = i.lstrip("^").split(":")[0]
                    if state.get(source) == "open":
                        raise ModelError(f"{key}: the graph has a loop")
                    if source not in state:
                        stack.append(source)
        return order

    # What the operations below share.

    def _shape(self, key):
        value = self.values[key]
        return list(value.shape) if isinstance(value, Tensor) else list(value)

    def _constant(self, key):
        value = self.values[key]
        if not isinstance(value, Tensor):
            raise ModelError(f"{key}: must be a constant")
        return value

    def _is_constant(self, key):
        return isinstance(self.values[key], Tensor)

    def _name(self, key):
        return self.renamed.get(key, key)

    def _emit(self, op, inputs, output, attributes):
        self.nodes.append(onnx.node(op, output + "/" + op, inputs, [output], attributes))
        return output

    def _add_tensor(self, hint, shape, values, kind=onnx.FLOAT):
        self.made += 1
        name = f"{hint}/constant_{self.made}"
        self.initializers.append(onnx.tensor(name, shape, values, kind))
        return name

    def _activate(self, key, name, kind):
        if kind == "Relu6":
            return self._emit("Clip", [name], key, {"min": 0.0, "max": 6.0})
        if kind in ("Relu", "Sigmoid"):
            return self._emit(kind, [name], key, {})
        raise ModelError(f"{key}: the activation {kind} is not supported")

    def _window(self, key, shape, kernel, attributes, dilations=(1, 1, 1, 1)):
        """ONNX attributes of a sliding window, and the height and width of its result."""
        strides, padding = attributes.integers("strides"), attributes.text("padding")
        if attributes.text("data_format", "NHWC") != "NHWC" or padding not in ("SAME", "VALID") or len(strides) != 4:
            raise ModelError(f"{key}: padding {padding!r} or data format is not supported")
        if any(s < 1 for s in strides):
            raise ModelError(f"{key}: a stride is not positive")
        reach = [(kernel[i] - 1) * dilations[1 + i] + 1 for i in (0, 1)]
        size = [_window_size(shape[1 + i], reach[i], strides[1 + i], padding) for i in (0, 1)]
        if min(size) < 1:
            raise ModelError(f"{key}: the window is larger than its input")
        out = {"kernel_shape": list(kernel), "strides": strides[1:3], "auto_pad": "SAME_UPPER" if padding == "SAME" else "VALID"}
        return out, size

    def _convolve(self, key, arguments, attributes, depthwise):
        shape, weights = self._shape(arguments[0]), self._constant(arguments[1])
        if len(shape) != 4 or len(weights.shape) != 4 or weights.shape[2] != shape[3]:
            raise ModelError(f"{key}: input {shape} and weights {list(weights.shape)} do not fit")
        height, width, channels, last = weights.shape
        dilations = attributes.integers("dilations") or [1, 1, 1, 1]
        window, size = self._window(key, shape, (height, width), attributes, dilations)
        window["dilations"] = dilations[1:3]
        taps, w = height * width, weights.values
        if depthwise:  # H, W, C, M -> C·M, 1, H, W
            out_channels = channels * last
            values = [w[tap * out_channels + o] for o in range(out_channels) for tap in range(taps)]
            window["group"], weight_shape = channels, [out_channels, 1, height, width]
        else:  # H, W, C, O -> O, C, H, W
            out_channels = last
            values = [w[(tap * channels + c) * last + o] for o in range(last) for c in range(channels) for tap in range(taps)]
            weight_shape = [last, channels, height, width]
        inputs = [self._name(arguments[0]), self._add_tensor(key, weight_shape, values)]
        self._emit_fused("Conv", key, inputs, arguments, attributes, window, out_channels)
        self.values[key] = [shape[0], size[0], size[1], out_channels]

    def _emit_fused(self, op, key, inputs, arguments, attributes, onnx_attributes, count):
        """A node, with the bias (`count` numbers) and the activation that TensorFlow fused into it."""
        fused = attributes.texts("fused_ops")
        if fused and fused[0] != "BiasAdd":
            raise ModelError(f"{key}: the fused operation {fused[0]} is not supported")
        if fused:
            bias = self._constant(arguments[2])
            if len(bias.values) != count:
                raise ModelError(f"{key}: {len(bias.values)} biases for {count} channels")
            inputs.append(self._add_tensor(key, [count], bias.values))
        if len(fused) > 2:
            raise ModelError(f"{key}: more than one fused activation is not supported")
        self._emit(op, inputs, key + "/linear" if len(fused) == 2 else key, onnx_attributes)
        if len(fused) == 2:
            self._activate(key, key + "/linear", fused[1])

    # One function for each operation of TensorFlow.

    def _op_FusedConv2D(self, key, arguments, attributes):
        self._convolve(key, arguments, attributes, depthwise=False)

    _op_Conv2D = _op_FusedConv2D

    def _op_FusedDepthwiseConv2dNative(self, key, arguments, attributes):
        self._convolve(key, arguments, attributes, depthwise=True)

    _op_DepthwiseConv2dNative = _op_FusedDepthwiseConv2dNative

    def _op_FusedMatMul(self, key, arguments, attributes):
        """A row times a constant matrix, plus a constant row."""
        shape, weights = self._shape(arguments[0]), self._constant(arguments[1])
        if (len(shape) != 2 or len(weights.shape) != 2 or weights.shape[0] != shape[1] or attributes.boolean("transpose_a")
                or attributes.boolean("transpose_b")):
            raise ModelError(f"{key}: input {shape} and weights {list(weights.shape)} do not fit")
        rows, columns = weights.shape
        values = [weights.values[r * columns + c] for c in range(columns) for r in range(rows)]  # I, O -> O, I
        inputs = [self._name(arguments[0]), self._add_tensor(key, [columns, rows], values)]
        if not attributes.texts("fused_ops"):
            inputs.append(self._add_tensor(key, [columns], [0.0] * columns))
        self._emit_fused("Gemm", key, inputs, arguments, attributes, {"transB": 1}, columns)
        self.values[key] = [shape[0], columns]

    _op_MatMul = _op_FusedMatMul

    def _op_Mean(self, key, arguments, attributes):
        """The mean of each channel of a picture."""
        shape, axes = self._shape(arguments[0]), sorted(self._constant(arguments[1]).values)
        if len(shape) != 4 or axes != [1, 2]:
            raise ModelError(f"{key}: the mean of {shape} along {axes} is not supported")
        if attributes.boolean("keep_dims"):
            self._emit("GlobalAveragePool", [self._name(arguments[0])], key, {})
            self.values[key] = [shape[0], 1, 1, shape[3]]
        else:
            pooled = self._emit("GlobalAveragePool", [self._name(arguments[0])], key + "/pooled", {})
            self._reshape(key, pooled, [shape[0], shape[3]])
            self.values[key] = [shape[0], shape[3]]

    def _op_Identity(self, key, arguments, attributes):
        self.values[key] = self.values[arguments[0]]
        self.renamed[key] = self._name(arguments[0])

    def _pointwise(self, key, arguments, kind):
        self._activate(key, self._name(arguments[0]), kind)
        self.values[key] = self._shape(arguments[0])

    def _op_Relu(self, key, arguments, attributes):
        self._pointwise(key, arguments, "Relu")

    def _op_Relu6(self, key, arguments, attributes):
        self._pointwise(key, arguments, "Relu6")

    def _op_Sigmoid(self, key, arguments, attributes):
        self._pointwise(key, arguments, "Sigmoid")

    def _with_constant(self, key, value, constant, op):
        """Sum or product of a picture and a constant that holds one number, or one for each channel."""
        shape, numbers = self._shape(value), self._constant(constant)
        count, wide = len(numbers.values), list(numbers.shape)
        if len(shape) != 4 or len(wide) > 4 or math.prod(wide[:-1]) != 1 or count not in (1, shape[3]):
            raise ModelError(f"{key}: a constant of shape {wide} does not fit the value of shape {shape}")
        self._emit(op, [self._name(value), self._add_tensor(key, [1, count, 1, 1], numbers.values)], key, {})
        self.values[key] = shape

    def _combine(self, key, arguments, op):
        """Sum or product of values of one shape, or of a value and a constant. A factor may also hold one number for each channel."""
        constants = [a for a in arguments if self._is_constant(a)]
        if len(arguments) == 2 and len(constants) == 1:
            self._with_constant(key, arguments[1 - arguments.index(constants[0])], constants[0], op)
            return
        arguments = sorted(arguments, key=lambda a: -math.prod(self._shape(a)))
        shapes = [self._shape(a) for a in arguments]
        fitting = [shapes[0]]
        if op == "Mul" and len(shapes[0]) == 4:
            fitting.append([shapes[0][0], 1, 1, shapes[0][3]])
        if constants or len(arguments) < 2 or any(shape not in fitting for shape in shapes):
            raise ModelError(f"{key}: {op} of the shapes {shapes}, {len(constants)} of them constants, is not supported")
        name = self._name(arguments[0])
        for i, argument in enumerate(arguments[1:], 2):
            name = self._emit(op, [name, self._name(argument)], key if i == len(arguments) else f"{key}/first_{i}", {})
        self.values[key] = shapes[0]

    def _op_AddN(self, key, arguments, attributes):
        self._combine(key, arguments, "Add")

    _op_Add = _op_AddV2 = _op_AddN

    def _op_Mul(self, key, arguments, attributes):
        self._combine(key, arguments, "Mul")

    def _pool(self, key, arguments, attributes, op):
        shape, window = self._shape(arguments[0]), attributes.integers("ksize")
        if len(shape) != 4 or len(window) != 4 or window[0] != 1 or window[3] != 1:
            raise ModelError(f"{key}: only pooling of pictures is supported")
        out, size = self._window(key, shape, window[1:3], attributes)
        self._emit(op, [self._name(arguments[0])], key, out)
        self.values[key] = [shape[0], *size, shape[3]]

    def _op_AvgPool(self, key, arguments, attributes):
        self._pool(key, arguments, attributes, "AveragePool")

    def _op_MaxPool(self, key, arguments, attributes):
        self._pool(key, arguments, attributes, "MaxPool")

    def _op_Conv2DBackpropInput(self, key, arguments, attributes):
        """A transposed convolution: each number of the input spreads over the window that a convolution of the result would gather."""
        result, weights, shape = list(self._constant(arguments[0]).values), self._constant(arguments[1]), self._shape(arguments[2])
        if ([len(result), len(weights.shape), len(shape)] != [4, 4, 4] or weights.shape[2:] != (result[3], shape[3])
                or result[0] != shape[0]):
            raise ModelError(f"{key}: input {shape}, weights {list(weights.shape)} and result {result} do not fit")
        if any(d != 1 for d in attributes.integers("dilations")):
            raise ModelError(f"{key}: a dilated transposed convolution is not supported")
        height, width, last, channels = weights.shape
        window, size = self._window(key, result, (height, width), attributes)
        if size != shape[1:3]:
            raise ModelError(f"{key}: input {shape} is not what a convolution of the result {result} gives")
        margins = [(size[i] - 1) * window["strides"][i] + weights.shape[i] - result[1 + i] for i in (0, 1)]
        if any(m < 0 or m % 2 for m in margins):
            raise ModelError(f"{key}: margins of {margins} pixels cannot be taken off evenly")
        del window["auto_pad"]
        window["pads"] = [m // 2 for m in margins] * 2
        taps, w = height * width, weights.values
        values = [w[(tap * last + o) * channels + c] for c in range(channels) for o in range(last) for tap in range(taps)]
        inputs = [self._name(arguments[2]), self._add_tensor(key, [channels, last, height, width], values)]  # H, W, O, C -> C, O, H, W
        self._emit("ConvTranspose", inputs, key, window)
        self.values[key] = result

    def _op_Pad(self, key, arguments, attributes):
        shape, pads = self._shape(arguments[0]), self._constant(arguments[1]).values
        if len(shape) != 4 or len(pads) != 8 or any(p < 0 for p in pads):
            raise ModelError(f"{key}: only padding of pictures is supported")
        begin, end = [pads[2 * i] for i in _NCHW_FROM_NHWC], [pads[2 * i + 1] for i in _NCHW_FROM_NHWC]
        self._emit("Pad", [self._name(arguments[0])], key, {"mode": "constant", "pads": begin + end, "value": 0.0})
        self.values[key] = [shape[i] + pads[2 * i] + pads[2 * i + 1] for i in range(4)]

    def _op_ResizeBilinear(self, key, arguments, attributes):
        shape, size = self._shape(arguments[0]), self._constant(arguments[1]).values
        if len(shape) != 4 or len(size) != 2 or attributes.boolean("align_corners") or not attributes.boolean("half_pixel_centers"):
            raise ModelError(f"{key}: only resizing with half-pixel centres is supported")
        scales = [1.0, 1.0, size[0] / shape[1], size[1] / shape[2]]
        region = self._add_tensor(key, [0], [])
        self._emit("Resize", [self._name(arguments[0]), region, self._add_tensor(key, [4], scales)], key,
                   {"mode": "linear", "coordinate_transformation_mode": "half_pixel"})
        self.values[key] = [shape[0], size[0], size[1], shape[3]]

    def _op_DepthToSpace(self, key, arguments, attributes):
        shape, block = self._shape(arguments[0]), attributes.integer("block_size")
        if len(shape) != 4 or block < 1 or shape[3] % (block * block):
            raise ModelError(f"{key}: {shape[-1]} channels do not fill blocks of {block}")
        n, height, width, channels = shape
        channels //= block * block
        # The channels are (row in block, column in block, channel). As ONNX' DepthToSpace (DCR), in operations that every reader has.
        split = self._reshape(key + "/split", self._name(arguments[0]), [n, block, block, channels, height, width])
        turned = self._emit("Transpose", [split], key + "/turned", {"perm": [0, 3, 4, 1, 5, 2]})
        self._reshape(key, turned, [n, channels, height * block, width * block])
        self.values[key] = [n, height * block, width * block, channels]

    def _reshape(self, key, name, shape):
        return self._emit("Reshape", [name, self._add_tensor(key, [len(shape)], shape, onnx.INT64)], key, {})

    def _op_Reshape(self, key, arguments, attributes):
        shape, wanted = self._shape(arguments[0]), list(self._constant(arguments[1]).values)
        count = math.prod(shape)
        if wanted.count(-1) == 1:
            known = -math.prod(wanted)
            wanted[wanted.index(-1)] = count // known if known else 0
        if math.prod(wanted) != count:
            raise ModelError(f"{key}: {shape} cannot become {wanted}")
        name = self._name(arguments[0])
        if len(shape) == 4:
            name = self._emit("Transpose", [name], key + "/nhwc", {"perm": _NHWC_FROM_NCHW})
        if len(wanted) == 4:
            raise ModelError(f"{key}: reshaping to a picture is not supported")
        self._reshape(key, name, wanted)
        self.values[key] = wanted

    def _op_ConcatV2(self, key, arguments, attributes):
        shapes = [self._shape(a) for a in arguments[:-1]]
        rank, axis = len(shapes[0]), self._constant(arguments[-1]).values[0]
        axis += rank if axis < 0 else 0
        rest = [s[:axis] + s[axis + 1:] for s in shapes]
        if not 0 <= axis < rank or any(r != rest[0] for r in rest):
            raise ModelError(f"{key}: {shapes} cannot be joined along {axis}")
        place = _NCHW_FROM_NHWC.index(axis) if rank == 4 else axis
        self._emit("Concat", [self._name(a) for a in arguments[:-1]], key, {"axis": place})
        self.values[key] = shapes[0][:axis] + [sum(s[axis] for s in shapes)] + shapes[0][axis + 1:]

    # Operations that compute shapes. Their results are constants.

    def _op_Shape(self, key, arguments, attributes):
        shape = self._shape(arguments[0])
        self.values[key] = Tensor([len(shape)], shape)

    def _op_StridedSlice(self, key, arguments, attributes):
        values = self._constant(arguments[0]).values
        begin, end, step = (self._constant(a).values for a in arguments[1:4])
        if len(begin) != 1 or step != [1] or attributes.integer("shrink_axis_mask") != 1 or not 0 <= begin[0] < len(values):
            raise ModelError(f"{key}: only a single element of a shape is supported")
        self.values[key] = Tensor([], [values[begin[0]]])

    def _op_Pack(self, key, arguments, attributes):
        self.values[key] = Tensor([len(arguments)], [self._constant(a).values[0] for a in arguments])


def convert(path, name, note):
    """The bytes of the ONNX file for the model.json at `path`. Raises ModelError for whatever is wrong with it."""
    model = Model(path)
    try:
        return Converter(model).run(name, note)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError, ZeroDivisionError) as error:
        raise ModelError(f"the graph is damaged ({type(error).__name__}: {error}); download the model again") from error
