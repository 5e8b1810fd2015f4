#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes doppel.d.ts: the signatures of doppel.d.ts.in with what the C headers say of each function.

    make_types.py FILE        writes FILE
    make_types.py --check     only checks

A line ` * @c dplName` takes what stands above the declaration of dplName in doppel.h or another public header. Fails where there is no such function or it has no words, and where doppel.js has a public function that the types lack, or the other way round.
"""
import pathlib
import re
import sys

HERE = pathlib.Path(__file__).resolve().parent
WEB, ROOT = HERE.parent, HERE.parent.parent.parent
HEADERS = [ROOT / "sdk/include/doppel" / name for name in ("doppel.h", "doppel_convert.h", "doppel_posed.h", "doppel_splats.h", "doppel_surface.h")]
DECLARATION = re.compile(r"/\*\*((?:(?!\*/).)*)\*/\s*(?:DPL_API|DPL_EXPERIMENTAL)\s[^;{/]*?\b(dpl\w+)\(", re.DOTALL)


def words_of_header():
    found = {}
    for header in HEADERS:
        for comment, name in DECLARATION.findall(header.read_text(encoding="utf-8")):
            found[name] = [line.strip().lstrip("*").strip() for line in comment.strip().splitlines()]
    return found


def public_of_script(text):
    body = text[text.index("export class Doppel {"):]
    body = body[:body.index("\n}\n")]
    return set(re.findall(r"^  (?:static )?(?:async )?([a-z]\w*)\(", body, re.MULTILINE)) | set(re.findall(r"\bthis\.([a-z]\w*) =", body))


def public_of_types(text):
    body = text[text.index("export class Doppel {"):]
    body = body[:body.index("\n}\n")]
    return set(re.findall(r"^  (?:static |readonly )*([a-z]\w*)[(:]", body, re.MULTILINE)) - {"private"}


def types():
    header, used = words_of_header(), []

    def said(match):
        indent, before, name = match.group(1), match.group(2), match.group(3)
        used.append(name)
        if not header.get(name):
            sys.exit(f"doppel.d.ts.in: no header says a word of {name}")
        lines = [f"{indent}{before}In C, {name}: {header[name][0]}"] + [f"{indent} * {line}" for line in header[name][1:]]
        return "\n".join(lines) + " */\n"

    template = (HERE / "doppel.d.ts.in").read_text(encoding="utf-8")
    text = re.sub(r"^( *)( \* |/\*\* )@c (dpl\w+) \*/\n", said, template, flags=re.MULTILINE)
    script, typed = public_of_script((WEB / "doppel.js").read_text(encoding="utf-8")), public_of_types(template)
    if script != typed:
        sys.exit(f"doppel.d.ts.in: lacks {sorted(script - typed)}, and has {sorted(typed - script)}, which doppel.js has not")
    if not used:
        sys.exit("doppel.d.ts.in: takes nothing from a header")
    return text


if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1] in ("-h", "--help"):
        print(__doc__, file=sys.stderr)
        sys.exit(2)
    made = types()
    if sys.argv[1] == "--check":
        print(f"doppel.d.ts: {len(made.splitlines())} lines, as headers and doppel.js say")
    else:
        pathlib.Path(sys.argv[1]).write_text(made, encoding="utf-8")
