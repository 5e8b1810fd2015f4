#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""check_schema.py SCHEMA FILE...: checks DPL_gaussian_avatar of each .glb against the JSON Schema. Exit 77: skipped, the reason is printed.

It also checks that the schema can fail: damaged copies of the extension must be refused."""
import copy
import json
import struct
import sys

try:
    import jsonschema
except ImportError:
    print("skipped: python3-jsonschema is not installed (apt-get install python3-jsonschema)")
    sys.exit(77)


def extension(path):
    data = open(path, "rb").read()
    (length,) = struct.unpack_from("<I", data, 12)
    return json.loads(data[20 : 20 + length])["extensions"]["DPL_gaussian_avatar"]


def damaged(good):
    for name, change in {
        "version 4": lambda e: e.update(version=4),
        "motion modes in version 2": lambda e: e.update(version=2, poseCorrectives=dict(CORRECTIVES, motion=MOTION)),
        "correctives in version 1": lambda e: e.update(version=1, poseCorrectives=CORRECTIVES),
        "hash in capitals": lambda e: e.update(contentHash="xxh3:ABCDEF0123456789"),
        "no units": lambda e: e.pop("units"),
        "unknown field": lambda e: e.update(colour="red"),
        "trained pixel 0": lambda e: e.update(trainedPixelM=0),
        "trained pixel of 2 m": lambda e: e.update(trainedPixelM=2),
        "trained pixel as text": lambda e: e.update(trainedPixelM="0.002"),
        "unknown role": lambda e: e["layers"][0].update(role="shoe"),
        "negative count": lambda e: e["splats"].update(count=-1),
        "bits without encoding 3": lambda e: e["splats"].update(encoding=1, bits=BITS),
        "0 bits": lambda e: e["splats"].update(encoding=3, bits=dict(BITS, uv=0), streams={"ranges": 1, "coded": 2}),
        "encoding 3 without bits": lambda e: (e["splats"].update(encoding=3, streams={"ranges": 1, "coded": 2}), e["splats"].pop("bits", None)),
        "encoding 3 with words": lambda e: e["splats"].update(encoding=3, bits=BITS, streams={"ranges": 1, "coded": 2, "place": 3}),
        "stream as text": lambda e: e["splats"]["streams"].update(place="1"),
        "evidence without reason": lambda e: e["evidence"][0].pop("reason"),
    }.items():
        bad = copy.deepcopy(good)
        change(bad)
        yield name, bad


BITS = {"uv": 8, "phi": 7, "scale": 8, "opacity": 6, "colour": 8}
CORRECTIVES = {
    "encoding": 1, "modeCount": 2, "nodeCount": 3, "joints": [0, 1], "reach": 1.5, "reachOffModes": 0.25,
    "streams": {"mean": 1, "modes": 2, "ranges": 3, "nodes": 4, "nodeIndices": 5, "nodeWeights": 6},
}

MOTION = {
    "encoding": 1, "joints": [0, 1], "movedFrom": 0.1, "movedTo": 0.3, "holds": [0, 1.5], "lags": [0.4],
    "streams": {"groups": 10, "still": 7, "ranges": 8, "modes": 9},
}


def damaged_motion():
    for name, change in {
        "no joints": lambda m: m.update(joints=[]),
        "no holds": lambda m: m.update(holds=[]),
        "hold negative": lambda m: m.update(holds=[-1]),
        "13 joints": lambda m: m.update(joints=list(range(13))),
        "motion encoding 2": lambda m: m.update(encoding=2),
        "no still stream": lambda m: m["streams"].pop("still"),
        "no groups stream": lambda m: m["streams"].pop("groups"),
        "lag of 0": lambda m: m.update(lags=[0]),
        "unknown motion field": lambda m: m.update(springs=[1]),
    }.items():
        bad = copy.deepcopy(MOTION)
        change(bad)
        yield name, dict(CORRECTIVES, motion=bad)


def damaged_correctives():
    for name, change in {
        "65 modes": lambda c: c.update(modeCount=65),
        "no nodes": lambda c: c.update(nodeCount=0),
        "joint twice": lambda c: c.update(joints=[1, 1]),
        "no reach": lambda c: c.pop("reach"),
        "reach 0": lambda c: c.update(reach=0),
        "reach off the modes 0": lambda c: c.update(reachOffModes=0),
        "no nodes stream": lambda c: c["streams"].pop("nodes"),
        "unknown corrective field": lambda c: c.update(colour="red"),
        "coded in encoding 1": lambda c: c["streams"].update(coded=7),
        "encoding 2 with nodes": lambda c: (c.update(encoding=2), c["streams"].update(coded=7)),
        "encoding 2 without coded": lambda c: c.update(encoding=2, streams={"mean": 1, "modes": 2, "ranges": 3}),
    }.items():
        bad = copy.deepcopy(CORRECTIVES)
        change(bad)
        yield name, bad


schema = json.load(open(sys.argv[1]))
jsonschema.Draft7Validator.check_schema(schema)
validator = jsonschema.Draft7Validator(schema)
failures = 0
for path in sys.argv[2:]:
    good = extension(path)
    for error in validator.iter_errors(good):
        failures += 1
        print(f"{path}: {'/'.join(map(str, error.path))}: {error.message}")
    if not validator.is_valid({**good, "version": 2, "poseCorrectives": CORRECTIVES, "trainedPixelM": 0.002}):
        failures += 1
        print(f"{path}: the schema refuses good correctives or a trained pixel")
    if not validator.is_valid({**good, "version": 3, "poseCorrectives": dict(CORRECTIVES, motion=MOTION)}):
        failures += 1
        print(f"{path}: the schema refuses good motion modes")
    bad_files = list(damaged(good))
    for version, damages in ((2, damaged_correctives()), (3, damaged_motion())):
        bad_files += [(name, {**good, "version": version, "poseCorrectives": c}) for name, c in damages]
    for name, bad in bad_files:
        if validator.is_valid(bad):
            failures += 1
            print(f"{path}: the schema accepts '{name}'")
print(f"{len(sys.argv) - 2} files, {failures} failures")
sys.exit(1 if failures or len(sys.argv) < 3 else 0)
