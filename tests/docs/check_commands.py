#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds the commands in the documents: subcommands, options, presets and scripts exist; cheap commands on avatar.glb are run."""
import argparse
import functools
import json
import pathlib
import re
import runpy
import shlex
import subprocess
import sys
import tempfile

import markdown

TINY_AVATAR = "avatar.glb"  # commands that read just this file are run on a tiny avatar of that name
RUN = ("inspect", "export", "render")
TOO_DEAR = (".mp4",)
SDK_GUIDE = "docs/guides/sdk.md"
# Pages that begin at nothing: before the first command of the kind on the left they show every command on the right.
PREPARED = {"docs/guides/capture.md": ("doppel check", ("doppel setup",)),
            "docs/guides/viewer.md": ("doppel-viewer ", ("tools/bootstrap", "cmake --build --preset release --target doppel_viewer"))}


class Checker:
    def __init__(self, root, doppel, viewer=None):
        self.root, self.doppel, self.viewer = root, doppel, viewer
        self.presets = {p["name"] for p in json.loads((root / "CMakePresets.json").read_text())["configurePresets"]}
        self.commands = 0

    @functools.cached_property
    def build_text(self):
        files = [f for f in self.root.rglob("CMakeLists.txt") if "build" not in f.relative_to(self.root).parts]
        return "\n".join(f.read_text() for f in files + sorted((self.root / "tools/cmake").glob("*.cmake")))

    @functools.cached_property
    def release_packages(self):
        return runpy.run_path(str(self.root / "tools/packaging/notices.py"))["COMPILED_IN"]

    def help(self, subcommands):
        return self.help_of(self.doppel, *subcommands)

    @functools.lru_cache(maxsize=None)
    def help_of(self, program, *subcommands):
        result = subprocess.run([program, *subcommands, "--help"], capture_output=True, text=True)
        return result.stdout if result.returncode == 0 else None

    def check(self, line):
        """What is wrong with a command line, or nothing. Other programs than ours give None of both."""
        words = [w.strip("[]") for w in shlex.split(line, comments=True)]
        while words and re.fullmatch(r"\w+=.*", words[0]):  # VARIABLE=value
            words.pop(0)
        if not words:
            return []
        program = words[0]
        if program == "doppel" or program.endswith("/doppel"):
            return self.check_doppel(words[1:])
        if program == "doppel-xr":  # need not be built
            self.commands += 1
            text = (self.root / "apps/xr/main.cpp").read_text()
            return [f"doppel-xr has no option {w}" for w in words[1:] if w.startswith("--") and f'"{w}"' not in text]
        if program == "doppel-viewer" or program.endswith("/doppel-viewer"):
            return self.check_viewer(words[1:])
        if program.startswith("tools/"):
            return self.check_script(program, words[1:])
        if program in ("cc", "c++", "sha256sum", "export", "./app", "build/app"):  # of the user's own program, which check_snippets builds and runs
            return []
        if program == "sudo":
            return self.check_packages(words[1:])
        if program in ("cmake", "ctest"):
            return self.check_build(words[1:])
        if program == "snakemake":
            return self.check_farm(words[1:])
        return [f"'{program}' is no program that this test knows"]

    def check_doppel(self, words):
        self.commands += 1
        subcommands = []
        while words and re.fullmatch(r"[a-z][a-z-]*", words[0]) and len(subcommands) < 2:
            if subcommands and not self.help((*subcommands, words[0])):
                break
            subcommands.append(words.pop(0))
        text = self.help(tuple(subcommands))
        if text is None:
            return [f"'doppel {' '.join(subcommands)}' does not exist"]
        return self.unknown_options(f"doppel {' '.join(subcommands)}", words, text)

    def check_viewer(self, words):
        self.commands += 1
        if not self.viewer:  # not built, because a library of its window is missing
            return []
        return self.unknown_options("doppel-viewer", words, self.help_of(self.viewer) or "")

    @staticmethod
    def unknown_options(program, words, text):
        wanted = [w.split("=")[0] for w in words if re.match(r"--?[a-z]", w)]
        return [f"'{program}' has no option {o}" for o in wanted if not re.search(rf"(?<![\w-]){o}(?![\w-])", text)]

    def check_script(self, program, words):
        self.commands += 1
        path = self.root / program
        if not path.exists():
            return [] if path.with_suffix(".cpp").exists() else [f"{program} does not exist"]
        options = [w.split("=")[0] for w in words if w.startswith("--")]
        text = path.read_text()
        if any(o not in text for o in options):  # its options are parsed elsewhere; its help names them
            text += subprocess.run([path, "--help"], capture_output=True, text=True, timeout=600).stdout
        return [f"{program} does not know {o}" for o in options if o not in text]

    def check_packages(self, words):
        self.commands += 1
        if words[:2] == ["apt", "install"]:  # packages of a release, by their files
            return [f"'{word}' is no package of a release" for word in words[2:]
                    if not re.fullmatch(r"\./[a-z0-9-]+\*\.deb", word) or word[2:-5] not in self.release_packages]
        if words[:2] != ["apt-get", "install"]:
            return [f"'sudo {' '.join(words[:2])}' is no command that this test knows"]
        known = [name for path in (self.root / "tools").glob("packages*.txt") for name in path.read_text().split()]
        return [f"tools/bootstrap installs no '{word}'" for word in words[2:] if word not in known]

    def check_farm(self, words):
        self.commands += 1
        text = (self.root / "tools/farm/Snakefile").read_text()
        paths = [word for word in words if word.startswith("tools/")]
        keys = [word.split("=")[0] for word in words if re.fullmatch(r"[a-z_]+=.*", word)]
        return [f"{path} does not exist" for path in paths if not (self.root / path).exists()] + [
            f"the farm reads no '{key}'" for key in keys if f'"{key}"' not in text]

    def check_build(self, words):
        self.commands += 1
        wrong = []
        for before, word in zip([""] + words, words):
            if before == "--preset" and word not in self.presets:
                wrong.append(f"there is no preset '{word}'")
            if before == "--component" and word not in self.build_text:
                wrong.append(f"there is no component '{word}'")
            if before == "--target" and not re.search(rf"\b{re.escape(word)}\b", self.build_text):
                wrong.append(f"there is no target '{word}'")
            option = re.match(r"-D(DOPPEL_\w+)", word)
            if option and option.group(1) not in self.build_text:
                wrong.append(f"there is no build option {option.group(1)}")
        return wrong


def lines_of(block):
    """The commands of a sh block, each part of a && by itself."""
    for number, line in block.commands():
        yield from parts_of(number, line)


def parts_of(number, line):
    """The commands of a line, which && separates."""
    return ((number, part.strip()) for part in line.split("&&"))


def commands_of(page):
    for block in page.blocks:
        if block.language == "sh":
            yield from lines_of(block)
    for number, span in page.spans():
        if re.match(r"(doppel [a-z]|doppel-viewer |tools/[\w/]+ -|(cmake|ctest) --)", span) and "…" not in span:
            yield from parts_of(number, span)


def sdk_packages_problems(root, page):
    """The guide's line installs what tools/bootstrap --sdk installs."""
    lines = [(number, line) for number, line in commands_of(page) if "apt-get install" in line]
    if len(lines) != 1:
        yield f"{page.name}: {len(lines)} lines with apt-get install, where there should be one"
        return
    wanted = set((root / "tools/packages-sdk.txt").read_text().split())
    named = set(shlex.split(lines[0][1], comments=True)) - {"sudo", "apt-get", "install"}
    if named != wanted:
        yield f"{page.name}:{lines[0][0]}: apt-get and tools/packages-sdk.txt differ in {', '.join(sorted(named ^ wanted))}"


def unprepared(page):
    """The commands without which those of the page do not work for somebody who begins with it."""
    use, needed = PREPARED.get(page.name, ("", ()))
    before = []
    for block in page.blocks:
        for number, line in lines_of(block) if block.language == "sh" else ():
            if not line.startswith(use):
                before.append(" ".join(shlex.split(line, comments=True)))
                continue
            yield from (f"{page.name}:{number}: '{command}' must come before '{use.strip()}'" for command in needed if command not in before)
            return


def is_cheap(line):
    words = shlex.split(line, comments=True)
    return len(words) > 2 and words[0] == "doppel" and words[1] in RUN and words[2] == TINY_AVATAR and not line.endswith(TOO_DEAR) and not any(
        w.endswith(TOO_DEAR) for w in words)


def problems(root, doppel, make_avatar=None, viewer=None):
    checker, cheap = Checker(root, doppel, viewer), []
    for page in markdown.pages(root):
        if page.is_history():
            continue
        if page.name == SDK_GUIDE:
            yield from sdk_packages_problems(root, page)
        yield from unprepared(page)
        for number, line in commands_of(page):
            for problem in checker.check(line):
                yield f"{page.name}:{number}: {problem}"
            if is_cheap(line):
                cheap.append((page.name, number, line))
    if not make_avatar:
        return
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([make_avatar, pathlib.Path(folder) / TINY_AVATAR], check=True)
        for name, number, line in cheap:
            words = [doppel] + shlex.split(line, comments=True)[1:]
            result = subprocess.run(words, cwd=folder, capture_output=True, text=True)
            if result.returncode != 0:
                yield f"{name}:{number}: '{line}' failed ({result.returncode}): {result.stderr.strip()}"
    print(f"{checker.commands} commands, {len(cheap)} of them run")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("root", type=pathlib.Path)
    parser.add_argument("--doppel", required=True)
    parser.add_argument("--make-avatar", required=True)
    parser.add_argument("--viewer")
    arguments = parser.parse_args()
    return markdown.report(list(problems(arguments.root.resolve(), arguments.doppel, arguments.make_avatar, arguments.viewer)), "commands")


if __name__ == "__main__":
    sys.exit(main())
