# SPDX-License-Identifier: Apache-2.0
"""Reads TensorFlow.js graph models: model.json with its topology and weights manifest, and the weight shards beside it.

The layout is that of tensorflow/tfjs, tfjs-core/src/io/types.ts (WeightsManifestConfig) and tfjs-converter (quantization.py).
"""
import base64
import json
import math
import pathlib
import struct

MAX_JSON_BYTES = 64 << 20
MAX_WEIGHT_BYTES = 512 << 20


class ModelError(Exception):
    """The file is damaged or uses something that is not supported. The text names what."""


class Tensor:
    """A constant: its shape and its values, row by row."""

    def __init__(self, shape, values):
        self.shape, self.values = tuple(shape), values


def _unpack(code, data):
    size = struct.calcsize("<" + code)
    if len(data) % size:
        raise ModelError("the weights end within a number; download the model again")
    return list(struct.unpack(f"<{len(data) // size}{code}", data))


def _decode(entry, data, at):
    """The tensor of one manifest entry, whose bytes start at `at`, and where they end."""
    name, shape = entry.get("name"), entry.get("shape")
    if not isinstance(name, str) or not isinstance(shape, list) or any(type(s) is not int or s < 0 for s in shape):
        raise ModelError("the weights manifest has an entry without name or shape")
    count, quantized = math.prod(shape), entry.get("quantization")
    kind = entry.get("dtype")
    if kind not in ("float32", "int32"):
        raise ModelError(f"{name}: weights of type {kind!r} are not supported")
    stored = quantized.get("dtype") if isinstance(quantized, dict) else kind
    codes = {"float32": "f", "int32": "i", "float16": "e", "uint8": "B", "uint16": "H"}
    if stored not in codes:
        raise ModelError(f"{name}: quantisation to {stored!r} is not supported")
    end = at + count * struct.calcsize("<" + codes[stored])
    if end > len(data):
        raise ModelError(f"{name}: the weights end after {len(data)} bytes, {end} are needed; download the model again")
    values = _unpack(codes[stored], data[at:end])
    if stored in ("uint8", "uint16"):
        scale, low = quantized.get("scale"), quantized.get("min", 0)
        if not isinstance(scale, (int, float)) or not isinstance(low, (int, float)):
            raise ModelError(f"{name}: its quantisation has no scale")
        values = [v * scale + low for v in values]
        if kind == "int32":
            values = [round(v) for v in values]
    if any(isinstance(v, float) and not math.isfinite(v) for v in values):
        raise ModelError(f"{name}: a weight is not finite")
    return name, Tensor(shape, values), end


class Attributes:
    """The `attr` object of a node."""

    def __init__(self, node):
        self.node, self.raw = node, node.get("attr") or {}

    def _value(self, key, kind):
        value = self.raw.get(key)
        return value.get(kind) if isinstance(value, dict) else None

    def text(self, key, default=""):
        value = self._value(key, "s")
        return default if value is None else base64.b64decode(value).decode()

    def integer(self, key, default=0):
        value = self._value(key, "i")
        return default if value is None else int(value)

    def boolean(self, key):
        return bool(self._value(key, "b"))

    def integers(self, key):
        return [int(i) for i in (self._value(key, "list") or {}).get("i", [])]

    def texts(self, key):
        return [base64.b64decode(s).decode() for s in (self._value(key, "list") or {}).get("s", [])]


class Model:
    """nodes: in the order of the file. constants: name -> Tensor. inputs: name -> shape. outputs: name -> node."""

    def __init__(self, path):
        path = pathlib.Path(path)
        if path.stat().st_size > MAX_JSON_BYTES:
            raise ModelError(f"{path.name}: larger than {MAX_JSON_BYTES >> 20} MiB")
        try:
            root = json.loads(path.read_text())
            self.nodes = root["modelTopology"]["node"]
            groups = root["weightsManifest"]
            signature = root["signature"]
            self.inputs = {v["name"].split(":")[0]: [int(d["size"]) for d in v["tensorShape"]["dim"]] for v in signature["inputs"].values()}
            self.outputs = {name: v["name"].split(":")[0] for name, v in signature["outputs"].items()}
            self.constants = {}
            for group in groups:
                self._read_group(path.parent, group)
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise ModelError(f"{path.name}: not a TensorFlow.js graph model ({type(error).__name__}: {error})") from error

    def _read_group(self, folder, group):
        data = b""
        for name in group["paths"]:
            if pathlib.PurePath(name).name != name:
                raise ModelError(f"the weights file {name!r} does not lie beside the model")
            shard = folder / name
            if len(data) + shard.stat().st_size > MAX_WEIGHT_BYTES:
                raise ModelError(f"{name}: more than {MAX_WEIGHT_BYTES >> 20} MiB of weights")
            data += shard.read_bytes()
        at = 0
        for entry in group["weights"]:
            name, tensor, at = _decode(entry, data, at)
            self.constants[name] = tensor
