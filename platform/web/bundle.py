#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Joins ES modules into one script without imports, for pages that hold everything in themselves.

    bundle.py FIRST.js OUT.js

Each module becomes a function that returns what it exports, so that their names do not meet. Comments of lines and at their ends and spaces
before and behind lines are left out, in templates too, and what a page with a person in itself does not need: lines from `// [not in pages]`
to `// [in pages]`, and of shaders from `#ifdef IN_SCENE` to `#else` or `#endif`. Knows
`import { a, b } from './file.js'`, `import './file.js'`, and `export` before const, function, async function and class; other forms
are an error. No module may await outside of its functions.
"""
import pathlib
import re
import sys

IMPORT = re.compile(r"^import\s+(?:\{([^}]*)\}\s+from\s+)?['\"](\.{1,2}/[^'\"]+)['\"];\s*$", re.MULTILINE)
EXPORT = re.compile(r"^export\s+((?:async\s+)?function\*?|class|const)\s+(\w+)", re.MULTILINE)
TRAILING = re.compile(r"[ \t]{2,}// [^'\"`\n]*$", re.MULTILINE)  # without quotes: so it stands in no string
LEFT_OUT = re.compile(r"^[ \t]*// \[not in pages\]\n.*?^[ \t]*// \[in pages\]\n", re.MULTILINE | re.DOTALL)
IN_SCENE = re.compile(r"^#ifdef IN_SCENE\n(?:(?!^#).*\n)*?(?:#else\n((?:(?!^#).*\n)*?))?#endif\n", re.MULTILINE)
COMMENT = re.compile(r"^[ \t]*(?://[^\n]*|/\*\*?.*?\*/[ \t]*)\n", re.MULTILINE | re.DOTALL)


def bundle(first):
    order, seen = [], {}

    def visit(path):
        if path in seen:
            return
        seen[path] = None
        text = IN_SCENE.sub(lambda m: m.group(1) or "", LEFT_OUT.sub("", path.read_text(encoding="utf-8")))
        if odd := re.search(r"IN_SCENE\b(?! \()|// \[(?:not )?in pages\]", text):
            sys.exit(f"{path}: '{odd.group(0)}' has no partner")
        text = TRAILING.sub("", COMMENT.sub("", text))
        for _, target in IMPORT.findall(text):
            visit((path.parent / target).resolve())
        seen[path] = f"m{len(order)}"
        order.append((path, text))

    visit(first.resolve())
    out = "// SPDX-License-Identifier: Apache-2.0\n"
    for path, text in order:
        def imported(match):
            names, target = match.group(1), seen[(path.parent / match.group(2)).resolve()]
            if target is None:
                sys.exit(f"{path}: imports {match.group(2)}, which imports it")
            return f"const {{{names.replace(' as ', ': ')}}} = {target};" if names else ""
        text = IMPORT.sub(imported, text)
        names = [name for _, name in EXPORT.findall(text)]
        text = EXPORT.sub(r"\1 \2", text)
        if odd := re.search(r"^(?:import\b(?!\s*\()|export\b).*$", text, re.MULTILINE):
            sys.exit(f"{path}: bundle.py does not know '{odd.group(0)}'")
        out += f"const {seen[path]} = (() => {{\n{text.strip()}\nreturn {{ {', '.join(names)} }};\n}})();\n"
    out = "\n".join(line.strip() for line in out.splitlines() if line.strip()) + "\n"
    if re.search(r"</script|<!--", out, re.IGNORECASE):
        sys.exit(f"{first}: the script would end the page's script element")
    return out


if __name__ == "__main__":
    if len(sys.argv) != 3 or sys.argv[1].startswith("-"):
        print(__doc__, file=sys.stderr)
        sys.exit(2)
    pathlib.Path(sys.argv[2]).write_text(bundle(pathlib.Path(sys.argv[1])), encoding="utf-8")
