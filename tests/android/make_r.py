#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""make_r.py RES PACKAGE OUT: writes the class R of an app, with a number for each layout, id and string that its resources define."""
import pathlib
import re
import sys

resources, package, out = pathlib.Path(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
names = {"layout": sorted(f.stem for f in resources.glob("layout/*.xml")), "id": [], "string": []}
for file in sorted(resources.rglob("*.xml")):
    text = file.read_text()
    names["id"] += re.findall(r'"@\+id/(\w+)"', text)
    names["string"] += re.findall(r'<string name="(\w+)"', text)
    for used in re.findall(r'"@string/(\w+)"', text):
        if not re.search(rf'<string name="{used}"', (resources / "values/strings.xml").read_text()):
            sys.exit(f"{file}: the string {used} is not defined")
classes = "".join(f"    public static final class {kind} {{\n" + "".join(f"        public static final int {n} = {i};\n" for i, n in enumerate(all_names, 1)) +
                  "    }\n" for kind, all_names in names.items())
folder = out / package.replace(".", "/")
folder.mkdir(parents=True, exist_ok=True)
(folder / "R.java").write_text(f"package {package};\n\npublic final class R {{\n{classes}}}\n")
