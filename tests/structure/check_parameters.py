#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""No function of the SDK and of the platforms takes more than 7 parameters. Exit 1 names each that does. Exempt: the public interface in C,
and calls that stand for one call of Apple's."""
import pathlib
import re
import sys

MOST = 7
ROOMS = ("sdk", "platform", "reconstruction", "apps")
EXEMPT_NAME = re.compile(r"dpl[A-Z]\w*$")
EXEMPT_FILES = ("sdk/backend/metal/mtl_seam.h", "sdk/backend/metal/mtl_apple.mm")
SUFFIXES = (".h", ".hpp", ".cpp", ".mm")
NOT_CODE = re.compile(r'"(?:\\.|[^"\\\n])*"|//[^\n]*|/\*.*?\*/', re.S)
# A parameter: a type, with template arguments and references, and a name; maybe an array, maybe a default value. Arguments of a call do not
# have a type before their name.
PARAMETER = re.compile(
    r"\s*(?:const\s+)?[\w:]+(?:<.*>)?(?:::\w+)*(?:\s+const)?(?:\s+|\s*[&*]+\s*(?:const\s+)?|\s*\(&)\w+(?:\)?\[\w*\])?\s*(?:=.*)?", re.S)
CALLS = re.compile(r"\s*(?:return|new|delete|throw|else|case)\b")


def without_comments(text):
    return NOT_CODE.sub(lambda found: re.sub(r"[^\n]", " ", found.group()), text)


def list_in_brackets(text, at):
    """The parts between commas of the brackets that open before `at`; empty if they do not end."""
    parts, depth, angles, first = [], 1, 0, at
    for i in range(at, len(text)):
        c = text[i]
        if c in "([{":
            depth += 1
        elif c in ")]}":
            depth -= 1
            if depth == 0:
                return parts + [text[first:i]]
        elif depth == 1 and c == "<":
            angles += 1
        elif depth == 1 and c == ">" and text[i - 1] != "-":
            angles = max(0, angles - 1)
        elif depth == 1 and c == "," and angles == 0:
            parts.append(text[first:i])
            first = i + 1
        elif depth == 1 and c == ";":
            return []
    return []


def wide_functions(text):
    """(line, name, number of parameters) of each declaration with too many."""
    text = without_comments(text)
    for found in re.finditer(r"\b([A-Za-z_][\w:~]*)\s*\(", text):
        parts = list_in_brackets(text, found.end())
        if len(parts) > MOST and all(PARAMETER.fullmatch(part) and not CALLS.match(part) for part in parts):
            yield text.count("\n", 0, found.start()) + 1, found.group(1), len(parts)


def check_itself():
    eight = "const Buffers& a, std::span<const std::pair<int, int>> b, float (&c)[3], uint32_t d = 1, const char* e, T f, bool g, int h"
    for text, wanted in ((f"Status far({eight});", 1), (f"void Room::far({eight}) {{}}", 1), (f"void far({eight.rpartition(',')[0]});", 0),
                         (f"// far({eight})", 0), ("far(a, b, c, d, e, f, g, h);", 0), ("far(1, \"a, b\", c + d, e[0], {f}, g(), -h, i);", 0)):
        if len(list(wide_functions(text))) != wanted:
            sys.exit(f"the check itself is wrong: {text}")


def main():
    check_itself()
    root = pathlib.Path(sys.argv[1])
    faults = []
    for room in ROOMS:
        for path in sorted((root / room).rglob("*")):
            name = path.relative_to(root).as_posix()
            if path.suffix not in SUFFIXES or name in EXEMPT_FILES:
                continue
            for line, function, count in wide_functions(path.read_text(encoding="utf-8")):
                if not EXEMPT_NAME.match(function):
                    faults.append(f"{name}:{line}: {function} takes {count} parameters; give it a struct of which it reads every field")
    print("\n".join(faults) if faults else "no function takes too many parameters")
    return 1 if faults else 0


sys.exit(main())
