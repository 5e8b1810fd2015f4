#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reads a glTF binary with DPL_skinned_gaussian_splatting and poses its splats, by docs/formats/skinned-splats.md alone.

    python3 skinned_splats.py FILE.glb [ANIMATION TIME]      says what the file holds, posed at a time in seconds
"""
import json
import struct
import sys

import numpy as np

COMPONENTS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
EXTENSION = "DPL_skinned_gaussian_splatting"


class File:
    def __init__(self, path):
        data = open(path, "rb").read()
        (length,) = struct.unpack_from("<I", data, 12)
        self.json = json.loads(data[20 : 20 + length])
        self.binary = data[28 + length :]

    def accessor(self, index):
        """All elements as rows. Normalised integers become floats."""
        a = self.json["accessors"][index]
        view = self.json["bufferViews"][a["bufferView"]]
        kind, width = np.dtype(COMPONENTS[a["componentType"]]), WIDTHS[a["type"]]
        start, stride = view.get("byteOffset", 0) + a.get("byteOffset", 0), view.get("byteStride", kind.itemsize * width)
        rows = np.ndarray((a["count"], width), kind, self.binary, start, (stride, kind.itemsize))
        return rows / np.iinfo(kind).max if a.get("normalized") else rows

    def local_transforms(self, animation, time):
        """4×4 of each node, at a time of an animation or at rest."""
        nodes = [dict(node) for node in self.json["nodes"]]
        for channel in animation["channels"] if animation else []:
            sampler = animation["samplers"][channel["sampler"]]
            times, values = self.accessor(sampler["input"])[:, 0], self.accessor(sampler["output"])
            key = int(np.clip(np.searchsorted(times, time, "right") - 1, 0, max(len(times) - 2, 0)))
            share = np.clip((time - times[key]) / (times[key + 1] - times[key]), 0, 1) if len(times) > 1 else 0
            a, b = values[key], values[min(key + 1, len(values) - 1)]
            rotation = channel["target"]["path"] == "rotation"
            nodes[channel["target"]["node"]][channel["target"]["path"]] = slerp(a, b, share) if rotation else a + share * (b - a)
        out = []
        for node in nodes:
            m = np.eye(4)
            m[:3, :3] = matrix(node.get("rotation", [0, 0, 0, 1])) * np.asarray(node.get("scale", [1, 1, 1]))
            m[:3, 3] = node.get("translation", [0, 0, 0])
            out.append(m)
        return out

    def world_transforms(self, animation, time):
        local = self.local_transforms(animation, time)
        parent = {child: p for p, node in enumerate(self.json["nodes"]) for child in node.get("children", [])}

        def world(node):
            return world(parent[node]) @ local[node] if node in parent else local[node]

        return [world(node) for node in range(len(local))]


def slerp(a, b, share):
    a, b = np.float64(a), np.float64(b) * (1 if np.dot(a, b) >= 0 else -1)
    angle = np.arccos(np.clip(np.dot(a, b), -1, 1))
    return a if angle < 1e-6 else (np.sin((1 - share) * angle) * a + np.sin(share * angle) * b) / np.sin(angle)


def matrix(quaternion):
    x, y, z, w = np.float64(quaternion) / np.linalg.norm(quaternion)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def dot(a, b):
    return np.sum(a * b, axis=-1, keepdims=True)


def unit(a):
    return a / np.maximum(np.linalg.norm(a, axis=-1, keepdims=True), 1e-30)


def smooth(t):
    t = np.clip(t, 0, 1)
    return t * t * (3 - 2 * t)


def shows(d1, d2):
    area2, longest2 = np.linalg.norm(np.cross(d1, d2), axis=-1, keepdims=True), np.maximum(dot(d1, d1), dot(d2, d2))
    return (area2 > 2e-10) & (np.maximum(longest2, dot(d2 - d1, d2 - d1)) < 1e4 * area2)


class Splats:
    """centre (n, 3), covariance (n, 3, 3), opacity (n, 1), normal (n, 3) in the world; turn (n, 3, 3) from rest; sh (n, k, 3)."""

    def __init__(self, file, primitive, skin, world):
        a = {name: file.accessor(index) for name, index in primitive["extensions"][EXTENSION]["attributes"].items()}
        rest = np.float64(file.accessor(primitive["attributes"]["POSITION"]))
        bind = file.accessor(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
        joints = np.array([world[node] for node in skin["joints"]]) @ bind
        of_vertex, weights = file.accessor(primitive["attributes"]["JOINTS_0"]), file.accessor(primitive["attributes"]["WEIGHTS_0"])
        skinning = np.einsum("vk,vkij->vij", weights, joints[of_vertex])
        posed = np.einsum("vij,vj->vi", skinning[:, :3, :3], rest) + skinning[:, :3, 3]
        corners = file.accessor(primitive["indices"])[:, 0].reshape(-1, 3)[a["TRIANGLE"][:, 0]]
        self._pose(a, rest[corners], posed[corners])
        self.outside = a.get("OUTSIDE", np.zeros_like(a["OPACITY"])) > 0
        names = [f"SH_DEGREE_{d}_COEF_{m}" for d in range(4) for m in range(2 * d + 1)]
        self.sh = np.stack([a[name] for name in names if name in a], axis=1)

    def _pose(self, a, rest, posed):
        e1, e2 = rest[:, 1] - rest[:, 0], rest[:, 2] - rest[:, 0]
        t1, n = unit(e1), unit(np.cross(e1, e2))
        t2 = np.cross(n, t1)
        at_rest = np.stack([t1, t2, n], axis=2)
        d1, d2 = posed[:, 1] - posed[:, 0], posed[:, 2] - posed[:, 0]
        visible = shows(e1, e2) & shows(d1, d2)
        with np.errstate(all="ignore"):  # triangles without area show nothing
            i00, i11 = 1 / dot(e1, t1), 1 / dot(e2, t2)
            f0, f1 = d1 * i00, -d1 * dot(e2, t1) * i00 * i11 + d2 * i11
            t1, n = unit(d1), unit(np.cross(d1, d2))
            t2 = np.cross(n, t1)
            s, c = -dot(f1, t1), dot(f0, t1) + dot(f1, t2)
            length = np.hypot(s, c)
            p1, p2 = (c * t1 + s * t2) / length, (c * t2 - s * t1) / length
            f0, f1, shown = bounded(f0, f1, p1, p2)
        u, v, phi = a["BARYCENTRIC"][:, :1], a["BARYCENTRIC"][:, 1:], a["ANGLE"]
        a1 = a["SCALE"][:, :1] * (np.cos(phi) * f0 + np.sin(phi) * f1)
        a2 = a["SCALE"][:, 1:] * (np.cos(phi) * f1 - np.sin(phi) * f0)
        axes = np.where(visible[..., None], np.stack([a1, a2], axis=2), 0)
        self.centre = (1 - u - v) * posed[:, 0] + u * posed[:, 1] + v * posed[:, 2]
        self.covariance = axes @ axes.transpose(0, 2, 1)
        self.opacity = a["OPACITY"] * np.where(visible, shown, 0)
        self.normal, self.turn = n, np.stack([p1, p2, n], axis=2) @ at_rest.transpose(0, 2, 1)

    def seen_from(self, eye):
        """opacity (n, 1) and colour (n, 3)."""
        d = unit(self.centre - eye)
        gate = np.where(self.outside, smooth(-dot(self.normal, d) / 0.1), 1)
        basis = harmonics(np.einsum("nji,nj->ni", self.turn, d))[:, : self.sh.shape[1]]
        return self.opacity * gate, np.clip(0.5 + np.einsum("nk,nkc->nc", basis, self.sh), 0, 1)


def bounded(f0, f1, p1, p2):
    """F with its singular values in bounds, and what is left of the opacity."""
    h, k, m = (dot(p1, f0) - dot(p2, f1)) / 2, dot(p1, f1), (dot(p1, f0) + dot(p2, f1)) / 2
    g = np.hypot(h, k)
    high, low = m + g, m - g

    def bound(s):
        over, under = np.maximum(s - 1.7, 0), np.maximum(0.5 - s, 0)
        return np.clip(s, 0.5, 1.7) + over * 0.3 / (0.3 + over) - under * 0.25 / (0.25 + under)

    outside = (high > 1.7) | (low < 0.5)
    mean, w = (bound(high) + bound(low)) / 2, np.where(g > 0, (bound(high) - bound(low)) / (2 * g), 0)
    shown = smooth(4 - high) * smooth(4 * high) * smooth(4 - low) * smooth(4 * low)
    return (np.where(outside, (mean + w * h) * p1 + w * k * p2, f0), np.where(outside, w * k * p1 + (mean - w * h) * p2, f1),
            np.where(outside, shown, 1))


def harmonics(d):
    x, y, z = d.T
    return np.stack([
        0.28209479 + 0 * x, -0.48860251 * y, 0.48860251 * z, -0.48860251 * x, 1.09254843 * x * y, -1.09254843 * y * z,
        0.31539157 * (2 * z * z - x * x - y * y), -1.09254843 * x * z, 0.54627422 * (x * x - y * y),
        -0.59004359 * y * (3 * x * x - y * y), 2.89061144 * x * y * z, -0.45704580 * y * (4 * z * z - x * x - y * y),
        0.37317633 * z * (2 * z * z - 3 * x * x - 3 * y * y), -0.45704580 * x * (4 * z * z - x * x - y * y),
        1.44530572 * z * (x * x - y * y), -0.59004359 * x * (x * x - 3 * y * y)], axis=1)


def posed(file, animation=None, time=0.0):
    """Splats of all primitives that have the extension, in the world."""
    chosen = next((a for a in file.json.get("animations", []) if a.get("name") == animation), None)
    if animation is not None and chosen is None:
        raise ValueError(f"there is no animation '{animation}'")
    world = file.world_transforms(chosen, time)
    return [Splats(file, primitive, file.json["skins"][node["skin"]], world) for node in file.json["nodes"] if "mesh" in node
            for primitive in file.json["meshes"][node["mesh"]]["primitives"] if EXTENSION in primitive.get("extensions", {})]


if __name__ == "__main__":
    name, at = (sys.argv[2], float(sys.argv[3])) if len(sys.argv) > 3 else (None, 0.0)
    for part in posed(File(sys.argv[1]), name, at):
        print(f"{len(part.centre)} splats, from {part.centre.min(axis=0).round(3)} to {part.centre.max(axis=0).round(3)} m, "
              f"{int((part.opacity > 0).sum())} shown, SH of {part.sh.shape[1]} coefficients")
