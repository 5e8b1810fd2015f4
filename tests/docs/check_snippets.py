#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compiles the C and C++ blocks of the documents. Whole programs are built and run against an installed SDK by the lines of their page
and nothing else (recipes.py). Blocks with a `given` line become functions."""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import markdown
import recipes

GIVEN = re.compile(r"\s*// given: (.+)\n")


class Compiler:
    def __init__(self, root, prefix, cc, cxx, folder):
        self.prefix, self.folder = pathlib.Path(prefix).resolve(), pathlib.Path(folder)
        include = f"-I{root / 'sdk/include'}"
        warnings = ["-Wall", "-Wextra", "-pedantic", "-Werror", include]
        self.command = {"c": [cc, "-std=c99", *warnings], "cpp": [cxx, "-std=c++20", *warnings]}

    def run(self, *words, folder=None, env=None):
        result = subprocess.run([str(w) for w in words], capture_output=True, text=True, cwd=folder or self.folder, env=env)
        return "" if result.returncode == 0 else f"({result.returncode}) {(result.stderr or result.stdout).strip()}"

    def program(self, page, block, name, avatar):
        """What is wrong with a whole program: its warnings first, then whatever the page's own lines meet."""
        source = self.folder / f"{name}.{block.language}"
        source.write_text(block.text)
        error = self.run(*self.command[block.language], "-fsyntax-only", source)
        if error:
            return f"does not compile: {error}"
        found = list(recipes.recipes_of(page, block))
        if not found:
            return "is a program, and no lines of the page build it"
        for recipe in found:
            if not recipes.RUNS.search(recipe.script):
                return f"is built by the lines from {recipe.line}, which do not run it on avatar.glb"
            folder = self.folder / f"{name}-line{recipe.line}"
            recipe.write(folder, self.prefix)
            shutil.copy(avatar, folder / "avatar.glb")
            # Nothing of this process's environment: a variable that finds headers or libraries would hide what the page leaves out.
            error = self.run("bash", "-e", "run.sh", folder=folder, env={k: os.environ[k] for k in ("PATH", "HOME") if k in os.environ})
            if error:
                return f"fails by the lines from {recipe.line}: {error}"
        return ""

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
            if recipes.is_program(block):
                problem = compiler.program(page, block, name, tiny_avatar)
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
    for option in ("--prefix", "--make-avatar", "--cc", "--cxx"):
        parser.add_argument(option, required=True)
    a = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        tiny = pathlib.Path(folder) / "tiny.glb"
        subprocess.run([a.make_avatar, tiny], check=True)
        compiler = Compiler(a.root.resolve(), a.prefix, a.cc, a.cxx, folder)
        return markdown.report(list(problems(a.root.resolve(), compiler, tiny)), "snippets")


if __name__ == "__main__":
    sys.exit(main())
