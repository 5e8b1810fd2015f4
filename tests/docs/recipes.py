#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Recipes: the lines by which a page has its reader install the SDK and build and run the page's whole programs.

A page's `c` or `cpp` block with a main() is a program. The page's `sh` blocks that name its file (app.c, app.cpp), or that call CMake
where the page's `cmake` block names its file, are the recipes of that program; each runs it on avatar.glb. What the page has exported
before stays, as in the reader's shell.
  recipes.py PAGE FOLDER PREFIX    writes FOLDER/packages.sh, FOLDER/install.sh and a folder with a run.sh for each recipe
"""
import dataclasses
import pathlib
import re
import sys

import markdown

RUNS = re.compile(r"^(\./|build/)app avatar\.glb$", re.MULTILINE)


@dataclasses.dataclass
class Recipe:
    line: int  # of the sh block
    script: str
    files: dict  # name: text

    def write(self, folder, prefix):
        folder.mkdir(parents=True)
        for name, text in {**self.files, "run.sh": self.script}.items():
            (folder / name).write_text(with_prefix(text, prefix))


def with_prefix(text, prefix):
    return re.sub(r"\bPREFIX\b", str(prefix), text)


def is_program(block):
    return block.language in ("c", "cpp") and re.search(r"\bint main\(", block.text) is not None


def recipes_of(page, program):
    """The recipes of one program of a page."""
    source = f"app.{program.language}"
    names_source = re.compile(rf"\b{re.escape(source)}(?![\w.])")
    exported = ""
    projects = [block.text for block in page.blocks if block.language == "cmake" and names_source.search(block.text)]
    for block in page.blocks:
        if block.language != "sh":
            continue
        if names_source.search(block.text):
            yield Recipe(block.line, exported + block.text, {source: program.text})
        elif projects and re.search(r"^cmake -S \. ", block.text, re.MULTILINE):
            yield Recipe(block.line, exported + block.text, {source: program.text, "CMakeLists.txt": projects[0]})
        exported += "".join(line for line in block.text.splitlines(keepends=True) if line.startswith("export "))


def install_lines(page, what):
    """The first sh block of a page that contains `what`."""
    return next(block.text for block in page.blocks if block.language == "sh" and what in block.text)


def main():
    path, folder, prefix = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]), sys.argv[3]
    page = markdown.read_page(path.parent, path)
    folder.mkdir(parents=True)
    (folder / "packages.sh").write_text(install_lines(page, "apt-get install"))
    (folder / "install.sh").write_text(with_prefix(install_lines(page, "--prefix PREFIX"), prefix))
    recipes = [(program, recipe) for program in page.blocks if is_program(program) for recipe in recipes_of(page, program)]
    for program, recipe in recipes:
        recipe.write(folder / f"line{recipe.line}-{program.language}-of-line{program.line}", prefix)
    print(f"{len(recipes)} recipes")
    return 0 if recipes else 1


if __name__ == "__main__":
    sys.exit(main())
