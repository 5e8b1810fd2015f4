#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compiles the C and C++ blocks of the documents: whole programs are linked and run, blocks with a `given` line become functions."""
import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

import markdown

GIVEN = re.compile(r"\s*// given: (.+)\n")


class Compiler:
    def __init__(self, root, library, cc, cxx, folder):
        self.library, self.folder = pathlib.Path(library), pathlib.Path(folder)
        include = f"-I{root / 'sdk/include'}"
        warnings = ["-Wall", "-Wextra", "-pedantic", "-Werror", include]
        self.command = {"c": [cc, "-std=c99", *warnings], "cpp": [cxx, "-std=c++20", *warnings]}

    def run(self, *words):
        result = subprocess.run([str(w) for w in words], capture_output=True, text=True, cwd=self.folder)
        return "" if result.returncode == 0 else f"({result.returncode}) {(result.stderr or result.stdout).strip()}"

    def program(self, language, text, name, argument):
        source, binary = self.folder / f"{name}.{language}", self.folder / name
        source.write_text(text)
        error = self.run(*self.command[language], source, self.library, f"-Wl,-rpath,{self.library.parent}", "-o", binary)
        if error:
            return f"does not build: {error}"
        error = self.run(binary, argument)
        return f"fails: {error}" if error else ""

    def function(self, text, parameters, name):
        source = self.folder / f"{name}.cpp"
        headers = "#include <cstdio>\n#include <doppel/doppel.hpp>\n"
        if "Vulkan" in text:
            headers += "#include <doppel/doppel_vulkan.h>\n#include <vulkan/vulkan.h>\n"
        lines = text.splitlines(keepends=True)
        headers += "".join(line for line in lines if line.startswith("#include"))
        text = "".join(line for line in lines if not line.startswith("#include"))
        source.write_text(f"{headers}void {name}({parameters});\nvoid {name}({parameters}) {{\n{text}}}\n")
        error = self.run(*self.command["cpp"], "-Wno-unused-result", "-Wno-unused-variable", "-fsyntax-only", source)
        return f"does not compile: {error}" if error else ""


def problems(root, compiler, tiny_avatar):
    count = 0
    for page in markdown.pages(root):
        for block in page.blocks:
            if block.language not in ("c", "cpp"):
                continue
            count += 1
            name, given = f"snippet{count}", GIVEN.match(block.text)
            if re.search(r"\bint main\(", block.text):
                problem = compiler.program(block.language, block.text, name, tiny_avatar)
            elif given:
                problem = compiler.function(block.text, given.group(1), name)
            else:
                problem = "is neither a program nor begins with '// given: TYPE NAME, ...'"
            if problem:
                yield f"{page.name}:{block.line}: the block {problem}"
    print(f"{count} blocks compiled")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("root", type=pathlib.Path)
    for option in ("--library", "--make-avatar", "--cc", "--cxx"):
        parser.add_argument(option, required=True)
    a = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        tiny = pathlib.Path(folder) / "tiny.glb"
        subprocess.run([a.make_avatar, tiny], check=True)
        compiler = Compiler(a.root.resolve(), a.library, a.cc, a.cxx, folder)
        return markdown.report(list(problems(a.root.resolve(), compiler, tiny)), "snippets")


if __name__ == "__main__":
    sys.exit(main())
