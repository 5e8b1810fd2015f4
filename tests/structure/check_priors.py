#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds the tables of priors. docs/reference/priors.md must be the page generated from the priors.h of every room of reconstruction, every
prior must be used, and no other file of reconstruction may name a scan of the development set: a constant chosen on one belongs in a table.

    tests/structure/check_priors.py ROOT            check; exit 1 says what is wrong
    tests/structure/check_priors.py ROOT --write    write the page, then check
"""
import pathlib
import re
import sys

# Names of development scans in comments. provenance.cpp lists the set.
DEVELOPMENT = re.compile(r"scan-[ac]\b|scan-tiny|biker|procedural seed", re.I)
EXEMPT = {"reconstruction/judging/report/provenance.cpp", "reconstruction/judging/report/provenance.h"}
COMMENT = re.compile(r"/\*\*(.*?)\*/\s*inline constexpr (?:double|float|size_t) (k\w+) = ([^;]+);", re.S)


INTRO = """# Priors
Generated from the `priors.h` of each room of `reconstruction` by `tests/structure/check_priors.py . --write`. Edit the headers, not this page.

What reconstruction assumes about people, clothes, cameras and detectors, because it cannot be estimated from one scan. Each entry states meaning, unit, origin, and what half and double the value do. The table of a room stands in that room, and its constants are in the namespace `dpl::priors`.

Origins. "round figure": chosen by judgement, to one or two digits. "dev": chosen on the development set, which `reconstruction/judging/report/provenance.cpp` names. Figures of those scans are optimistic.

In the body fit a length, angle or acceleration is the standard deviation of a term unless its text says otherwise. The spreads of single joints are not here: `reconstruction/subject/body/pose_prior.cpp` holds them, a row a joint. Nor are the places where our networks mark joints: `reconstruction/subject/body/landmark_offsets.cpp` holds them, a row a keypoint.
"""
WINGS = ["input", "subject", "training", "output", "judging"]  # the order of a run


def headers(root):
    """The priors.h of each room, by room, in the order of a run."""
    found = sorted((root / "reconstruction").glob("*/*/priors.h"), key=lambda p: (WINGS.index(p.parts[-3]), p.parts[-2]))
    return {p.parent.relative_to(root).as_posix(): p.read_text(encoding="utf-8") for p in found}


def tables(room, header):
    lines = []
    found = 0
    for section in re.split(r"^// ---- ", header, flags=re.M)[1:]:
        heading, body = section.split("\n", 1)
        lines += [f"## {heading}", f"`{room}/priors.h`", "", "| prior | value | unit | meaning | origin | half and double |", "|---|---|---|---|---|---|"]
        for comment, name, value in COMMENT.findall(body):
            text = " ".join(re.sub(r"^\s*\*", "", line).strip() for line in comment.strip().splitlines())
            entry = re.fullmatch(r"(.+?)\s+unit: (.+?) \| origin: (.+?) \| half, double: (.+)", text)
            if not entry:
                raise SystemExit(f"{room}/priors.h: {name} needs 'meaning. unit: ... | origin: ... | half, double: ...'")
            meaning, unit, origin, sweep = entry.groups()
            lines.append(f"| `{name}` | {value.rstrip('f')} | {unit} | {meaning} | {origin} | {sweep} |")
            found += 1
        lines.append("")
    if found != len(re.findall(r"^inline constexpr (?:double|float|size_t)", header, re.M)):
        raise SystemExit(f"{room}/priors.h: an entry has no comment of its own")
    return lines


def page(root):
    lines = [INTRO]
    for room, header in headers(root).items():
        lines += tables(room, header)
    return "\n".join(lines).rstrip() + "\n"


def misplaced(root, names):
    """Sentences about priors that nothing uses and about development scans named outside the table."""
    texts = {p.relative_to(root).as_posix(): p.read_text(encoding="utf-8") for p in sorted((root / "reconstruction").rglob("*"))
             if p.suffix in (".h", ".cpp")}
    found = [f"nothing uses the prior {name}" for name in names
             if not any(re.search(rf"priors::{name}\b", text) for path, text in texts.items())]
    for path, text in texts.items():
        for number, line in enumerate(text.splitlines(), 1):
            if path not in EXEMPT and not path.endswith("/priors.h") and DEVELOPMENT.search(line):
                found.append(f"{path}:{number}: names a development scan; move the constant to the room's priors.h")
    return found


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    wanted = page(root)
    target = root / "docs/reference/priors.md"
    if "--write" in sys.argv:
        target.write_text(wanted, encoding="utf-8")
    problems = misplaced(root, re.findall(r"^\| `(k\w+)`", wanted, re.M))
    if not target.exists() or target.read_text(encoding="utf-8") != wanted:
        problems.append("docs/reference/priors.md differs from the priors of the rooms; run tests/structure/check_priors.py . --write")
    print("\n".join(problems) or f"priors.md holds the {wanted.count('| `k')} priors of the rooms")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
