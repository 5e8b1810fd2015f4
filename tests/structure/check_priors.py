#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds the table of priors. docs/reference/priors.md must be the page generated from reconstruction/priors.h, every prior must be used, and
no other file of reconstruction may name a scan of the development set: a constant chosen on one belongs in the table.

    tests/structure/check_priors.py ROOT            check; exit 1 says what is wrong
    tests/structure/check_priors.py ROOT --write    write the page, then check
"""
import pathlib
import re
import sys

# Names of development scans in comments. provenance.cpp lists the set.
DEVELOPMENT = re.compile(r"scan-[ac]\b|scan-tiny|biker|procedural seed", re.I)
EXEMPT = {"reconstruction/priors.h", "reconstruction/report/provenance.cpp", "reconstruction/report/provenance.h"}
COMMENT = re.compile(r"/\*\*(.*?)\*/\s*inline constexpr (?:double|float|size_t) (k\w+) = ([^;]+);", re.S)


def page(header):
    intro = re.search(r"// Priors: (.*?)#pragma once", header, re.S).group(1)
    intro = [re.sub(r"\s*//\s?", " ", part).strip() for part in intro.split("\n//\n")]
    intro[0] = intro[0][0].upper() + intro[0][1:]
    lines = ["# Priors", "Generated from `reconstruction/priors.h` by `tests/structure/check_priors.py . --write`. Edit the header, not this page.", ""]
    lines += [part for paragraph in intro for part in (paragraph, "")]
    found = 0
    for section in re.split(r"^// ---- ", header, flags=re.M)[1:]:
        heading, body = section.split("\n", 1)
        lines += [f"## {heading}", "", "| prior | value | unit | meaning | origin | half and double |", "|---|---|---|---|---|---|"]
        for comment, name, value in COMMENT.findall(body):
            text = " ".join(re.sub(r"^\s*\*", "", line).strip() for line in comment.strip().splitlines())
            entry = re.fullmatch(r"(.+?)\s+unit: (.+?) \| origin: (.+?) \| half, double: (.+)", text)
            if not entry:
                raise SystemExit(f"priors.h: {name} needs 'meaning. unit: ... | origin: ... | half, double: ...'")
            meaning, unit, origin, sweep = entry.groups()
            lines.append(f"| `{name}` | {value.rstrip('f')} | {unit} | {meaning} | {origin} | {sweep} |")
            found += 1
        lines.append("")
    if found != len(re.findall(r"^inline constexpr (?:double|float|size_t)", header, re.M)):
        raise SystemExit("priors.h: an entry has no comment of its own")
    return "\n".join(lines).rstrip() + "\n"


def misplaced(root, names):
    """Sentences about priors that nothing uses and about development scans named outside the table."""
    texts = {p.relative_to(root).as_posix(): p.read_text(encoding="utf-8") for p in sorted((root / "reconstruction").rglob("*"))
             if p.suffix in (".h", ".cpp")}
    found = [f"priors.h: nothing uses {name}" for name in names
             if not any(re.search(rf"priors::{name}\b", text) for path, text in texts.items())]
    for path, text in texts.items():
        for number, line in enumerate(text.splitlines(), 1):
            if path not in EXEMPT and DEVELOPMENT.search(line):
                found.append(f"{path}:{number}: names a development scan; move the constant to reconstruction/priors.h")
    return found


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    wanted = page((root / "reconstruction/priors.h").read_text(encoding="utf-8"))
    target = root / "docs/reference/priors.md"
    if "--write" in sys.argv:
        target.write_text(wanted, encoding="utf-8")
    problems = misplaced(root, re.findall(r"^\| `(k\w+)`", wanted, re.M))
    if not target.exists() or target.read_text(encoding="utf-8") != wanted:
        problems.append("docs/reference/priors.md differs from reconstruction/priors.h; run tests/structure/check_priors.py . --write")
    print("\n".join(problems) or f"priors.md holds the {wanted.count('| `k')} priors of priors.h")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
