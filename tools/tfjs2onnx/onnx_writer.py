# SPDX-License-Identifier: Apache-2.0
"""Writes ONNX files: the few messages of onnx.proto that a network of floats needs, in protobuf's wire format.

Field numbers are those of onnx/onnx.proto (https://github.com/onnx/onnx/blob/main/onnx/onnx.proto, IR version 4). The same network always
gives the same bytes.
"""
import struct

FLOAT, INT64 = 1, 7  # TensorProto.DataType
_ATTRIBUTE_FLOAT, _ATTRIBUTE_INT, _ATTRIBUTE_STRING, _ATTRIBUTE_INTS = 1, 2, 3, 7  # AttributeProto.AttributeType


def _varint(value):
    value &= (1 << 64) - 1  # negative numbers take ten bytes
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def _number(field, value):
    return _varint(field << 3) + _varint(value)


def _bytes(field, value):
    return _varint(field << 3 | 2) + _varint(len(value)) + value


def _text(field, value):
    return _bytes(field, value.encode())


def tensor(name, shape, values, kind=FLOAT):
    """A TensorProto with its values as little-endian raw data."""
    data = struct.pack(f"<{len(values)}{'f' if kind == FLOAT else 'q'}", *values)
    return b"".join(_number(1, size) for size in shape) + _number(2, kind) + _text(8, name) + _bytes(9, data)


def attribute(name, value):
    """An AttributeProto: a float, an int, a string or a list of ints."""
    head = _text(1, name)
    if isinstance(value, float):
        return head + _varint(2 << 3 | 5) + struct.pack("<f", value) + _number(20, _ATTRIBUTE_FLOAT)
    if isinstance(value, int):
        return head + _number(3, value) + _number(20, _ATTRIBUTE_INT)
    if isinstance(value, str):
        return head + _text(4, value) + _number(20, _ATTRIBUTE_STRING)
    return head + b"".join(_number(8, v) for v in value) + _number(20, _ATTRIBUTE_INTS)


def node(op, name, inputs, outputs, attributes):
    return (b"".join(_text(1, i) for i in inputs) + b"".join(_text(2, o) for o in outputs) + _text(3, name) + _text(4, op) +
            b"".join(_bytes(5, attribute(key, attributes[key])) for key in sorted(attributes)))


def value_info(name, shape):
    """A ValueInfoProto of floats with a fixed shape."""
    dims = b"".join(_bytes(1, _number(1, size)) for size in shape)
    return _text(1, name) + _bytes(2, _bytes(1, _number(1, FLOAT) + _bytes(2, dims)))


def model(graph_name, nodes, initializers, inputs, outputs, opset, note):
    """A ModelProto. nodes, initializers, inputs and outputs are lists of encoded messages."""
    graph = (b"".join(_bytes(1, n) for n in nodes) + _text(2, graph_name) + b"".join(_bytes(5, t) for t in initializers) +
             b"".join(_bytes(11, i) for i in inputs) + b"".join(_bytes(12, o) for o in outputs))
    return _number(1, 4) + _text(2, "doppel tools/tfjs2onnx") + _text(6, note) + _bytes(7, graph) + _bytes(8, _text(1, "") + _number(2, opset))
