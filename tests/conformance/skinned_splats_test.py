#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""skinned_splats_test.py SKINNED_EXAMPLE DOCS_FORMATS: the example of DPL_skinned_gaussian_splatting in the docs, read by skinned_splats.py,
has the splats of the library. Exit 77: skipped, the reason is printed."""
import copy
import json
import pathlib
import subprocess
import sys
import tempfile

try:
    import numpy as np
except ImportError:
    print("skipped: python3-numpy is not installed (apt-get install python3-numpy)")
    sys.exit(77)
import skinned_splats

FLOATS = 13  # a splat in a .f32: position, covariance, opacity, colour
UPPER = ([0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2])  # of a covariance: xx xy xz yy yz zz
THICKNESS_M2 = 1e-8  # the library's splats have 0.1 mm across the surface, so that others can take logarithms
# The library works in floats: one ulp of a metre is 1.2e-7, and an opacity is a smoothstep of slope 15 in the cosine.
BARS = {"position, m": 1e-6, "covariance, share of the largest": 2e-5, "opacity": 5e-5, "colour": 5e-6}

failures = []


def check(holds, what):
    if not holds:
        failures.append(what)
        print("FAILED:", what)


def differences(part, eye, numbers):
    opacity, colour = part.seen_from(eye)
    shown = (opacity[:, 0] > 1e-6) | (numbers[:, 9] > 1e-6)
    covariance = part.covariance + THICKNESS_M2 * np.einsum("ni,nj->nij", part.normal, part.normal)
    expected = numbers[:, 3:9]
    size = np.abs(expected[shown]).max(axis=1, keepdims=True)
    return {"position, m": np.abs(part.centre - numbers[:, :3])[shown].max(),
            "covariance, share of the largest": (np.abs(covariance[:, UPPER[0], UPPER[1]] - expected)[shown] / size).max(),
            "opacity": np.abs(opacity[:, 0] - numbers[:, 9]).max(),
            "colour": np.abs(colour - numbers[:, 10:13])[shown].max()}


def compare(path, view, numbers):
    file = skinned_splats.File(path)
    (part,) = skinned_splats.posed(file, view["animation"], view["time"])
    m = np.array(view["camera"]["view_from_world"]).reshape(3, 4)
    return part, differences(part, -m[:, :3].T @ m[:, 3], numbers)


def check_schema(schema_path, path):
    try:
        import jsonschema
    except ImportError:
        print("the schema was not tried: python3-jsonschema is not installed")
        return
    validator = jsonschema.Draft7Validator(json.load(open(schema_path)))
    good = skinned_splats.File(path).json["meshes"][0]["primitives"][0]["extensions"][skinned_splats.EXTENSION]
    check(validator.is_valid(good), "the example keeps to the schema")
    for name, change in {"no triangles": lambda e: e["attributes"].pop("TRIANGLE"), "linear colours": lambda e: e.update(colorSpace="lin"),
                         "an unknown attribute": lambda e: e["attributes"].update(NORMAL=1),
                         "an eighth coefficient of degree 3": lambda e: e["attributes"].update(SH_DEGREE_3_COEF_7=1)}.items():
        bad = copy.deepcopy(good)
        change(bad)
        check(not validator.is_valid(bad), f"the schema refuses {name}")


def main(example, formats):
    kept = formats / "skinned-splats"
    with tempfile.TemporaryDirectory() as folder:
        made = pathlib.Path(folder)
        check(subprocess.run([example, made, kept]).returncode == 0, f"{kept} has the pictures that {example} draws")
        for name in ("example.glb", "views.json"):
            check((made / name).read_bytes() == (kept / name).read_bytes(), f"{kept / name} is what {example} writes")
        bounded = seen_through = 0
        for view in json.loads((kept / "views.json").read_text())["views"]:
            numbers = np.fromfile(made / view["picture"].replace(".png", ".f32"), np.float32).reshape(-1, FLOATS)
            part, found = compare(kept / "example.glb", view, numbers)
            print(view["picture"] + ":", ", ".join(f"{name} {value:.1e}" for name, value in found.items()))
            for name, bar in BARS.items():
                check(found[name] <= bar, f"{view['picture']}: {name} {found[name]:.2e} is within {bar}")
            check(len(numbers) == len(part.centre) > 1000, "there are splats to compare")
            bounded += int((part.opacity < 0.8).sum())
            seen_through += int((part.outside[:, 0] & (numbers[:, 9] == 0)).sum())
            # What the extension adds shows in the numbers: without the gate they differ.
            part.outside[:] = False
            m = np.array(view["camera"]["view_from_world"]).reshape(3, 4)
            check(differences(part, -m[:, :3].T @ m[:, 3], numbers)["opacity"] > 0.5, "without OUTSIDE the opacity is wrong")
        check(bounded > 20, "some triangles are torn so far that they fade")
        check(seen_through > 1000, "some splats show their backs")
    check_schema(formats / "skinned-splats.schema.json", kept / "example.glb")
    print(f"{len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], pathlib.Path(sys.argv[2])))
