#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds the priors in the keys of stages. A stage depends on the priors of every room that its code includes, and of the rooms that those
include. `kPriors` in reconstruction/run/stage_*.h must list exactly these, so that a changed constant makes the stages run again that use it.
Artefacts of other stages bring their own key, so their headers do not count.

    tests/structure/check_stage_priors.py ROOT      exit 1 says what each list should be
"""
import pathlib
import re
import sys

INCLUDE = re.compile(r'^#include "reconstruction/([^"]+)"', re.M)
LIST = re.compile(r"kPriors\[\] = \{(.*?)\};", re.S)
GRAPH = {"graph.h", "run_request.h", "reconstruct.h", "preset.h", "frame_table.h", "settings_json.h"}  # what every stage sees; settings are in keys by value


def room_of(path):
    parts = path.split("/")
    return "/".join(parts[:2]) if len(parts) > 2 else parts[0]


def rooms_below(root):
    """Which rooms each room includes."""
    below = {}
    for file in sorted(root.rglob("*")):
        if file.suffix in (".h", ".cpp"):
            room = room_of(file.relative_to(root).as_posix())
            below.setdefault(room, set()).update(room_of(target) for target in INCLUDE.findall(file.read_text()))
    return below


def with_all_below(rooms, below):
    seen, open_rooms = set(), list(rooms)
    while open_rooms:
        room = open_rooms.pop()
        if room not in seen:
            seen.add(room)
            open_rooms += below.get(room, ())
    return seen


def rooms_of_stage(root, source):
    """The rooms that the files of one stage include, its helpers in `run` included."""
    rooms, seen, open_files = set(), set(), [source, source.with_suffix(".h")]
    while open_files:
        file = open_files.pop()
        if file in seen or not file.exists():
            continue
        seen.add(file)
        for target in INCLUDE.findall(file.read_text()):
            if room_of(target) != "run":
                rooms.add(room_of(target))
            elif not (root / target).name in GRAPH and not (root / target).name.startswith("stage_"):
                open_files += [root / target, (root / target).with_suffix(".cpp")]
    return rooms


def problems(root):
    below = rooms_below(root)
    for source in sorted((root / "run").glob("stage_*.cpp")):
        used = with_all_below(rooms_of_stage(root, source), below)
        wanted = sorted(room for room in used if (root / room / "priors.h").exists())
        for text in LIST.findall(source.with_suffix(".h").read_text()):
            stated = sorted(re.findall(r'"([^"]+)"', text))
            if stated != wanted:
                yield f"reconstruction/run/{source.stem}.h: kPriors must be {{{', '.join(f'{chr(34)}{room}{chr(34)}' for room in wanted)}}}"


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    found = list(problems(root / "reconstruction"))
    print("\n".join(found) or "the keys of stages hold the priors that the stages use")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
