#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Feeds the checkers broken pages: each must complain about exactly what is broken."""
import pathlib
import shutil
import sys
import tempfile
import unittest
import unittest.mock

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import check_commands
import check_pages
import check_snippets
import guide_lines

# A stand-in for doppel: knows `render` with --size, and `body import`.
DOPPEL = """#!/bin/sh
case "$*" in
    "render --help") echo "--size TEXT  Size" ;;
    "body import --help") echo "-o,--out TEXT" ;;
    "body --help") echo "import" ;;
    *) exit 2 ;;
esac
"""


class Checkers(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name).resolve()
        (self.root / "docs/adr").mkdir(parents=True)
        (self.root / "sdk/math").mkdir(parents=True)
        (self.root / "CMakePresets.json").write_text('{"configurePresets": [{"name": "dev"}]}')
        (self.root / "CMakeLists.txt").write_text("option(DOPPEL_TESTS)")
        self.doppel = self.root / "doppel"
        self.doppel.write_text(DOPPEL)
        self.doppel.chmod(0o755)

    def page(self, text, name="docs/page.md"):
        (self.root / name).write_text(text)

    def complaints(self, expected, got):
        got = list(got)
        self.assertEqual(len(got), len(expected), got)
        for part, problem in zip(expected, got):
            self.assertIn(part, problem)

    def test_links(self):
        self.page("# One two\n[good](page.md#one-two) [bad](no.md) [anchor](#three) [web](https://example.org)\n")
        self.complaints(["no.md leads nowhere", "no heading 'three'"], check_pages.problems(self.root))

    def test_index_of_guides(self):
        (self.root / "docs/guides").mkdir()
        self.page("# A\n", "docs/guides/a.md")
        self.page("# B\n", "docs/guides/b.md")
        self.page("# Guides\n[a](a.md)\n", "docs/guides/README.md")
        self.page("# X\n[gone](docs/gone.md)\n", "llms.txt")
        self.complaints(["b.md is not in this index", "docs/gone.md leads nowhere", "no link to docs/guides/README.md"],
                        check_pages.problems(self.root))

    def test_paths(self):
        self.page("`sdk/math` `sdk/gone.h` `sdk/*` `other/thing`\n```\n`sdk/in_a_block`\n```\n")
        self.complaints(["`sdk/gone.h` does not exist"], check_pages.problems(self.root))

    def test_tables(self):
        self.page("| a | b |\n|---|---|\n| 1 | 2 |\n| 1 | `x \\| y` |\n| 1 | 2 | 3 |\n")
        self.complaints(["5: a table row of 3 cells"], check_pages.problems(self.root))

    def test_decisions(self):
        self.page("# Long\nStatus: accepted\n" + "word " * 500, "docs/adr/0001-long.md")
        self.page("# No status\n", "docs/adr/0002-none.md")
        self.page("# Draft\nStatus: accepted\n", "docs/adr/0002-draft.md")
        self.page("[1](0001-long.md) [2](0002-none.md)\n", "docs/adr/README.md")
        self.complaints(["0002-draft.md: not in docs/adr/README.md", "504 words", "no line 'Status"], check_pages.problems(self.root))

    def test_cited_decisions(self):
        self.page("# Decisions\n- 0007 — folded into a page\n", "docs/adr/README.md")
        self.page("ADR 0007, ADR 0008\n")
        self.complaints(["page.md:1: ADR 0008 is not in docs/adr/README.md"], check_pages.problems(self.root))

    def test_arrows(self):
        (self.root / "tests/structure").mkdir(parents=True)
        (self.root / "tests/structure/check_arrows.py").write_text('SDK = {"sdk/a": [], "sdk/b": ["sdk/a", "shaders/x"], "sdk/c": ["sdk"]}')
        self.page("| `sdk/a` | nobody |\n| `sdk/b` | a |\n| `sdk/c` | anything in `sdk` |\n", "docs/overview.md")
        (self.root / "sdk/a").mkdir(), (self.root / "sdk/b").mkdir(), (self.root / "sdk/c").mkdir()
        self.complaints(["the row of `sdk/b` should say: a, `shaders/x`"], check_pages.problems(self.root))

    def test_commands(self):
        self.page("```sh\ndoppel render a.glb --size 8x8\ndoppel render a.glb --sise 8x8\ndoppel body import x -o y\ndoppel gone\n"
                  "cmake --preset dev -DDOPPEL_TESTS=ON\ncmake --preset no -DDOPPEL_NO=ON\ncmake --build --preset dev --target gone\ntools/no\nrm x\n```\n`doppel render --inline`\n`doppel body import x -o y && doppel render a.glb --size 8x8`\n")
        self.complaints(["no option --sise", "'doppel gone' does not exist", "no preset 'no'", "no build option DOPPEL_NO", "no target 'gone'", "tools/no does not exist",
                         "'rm' is no program", "no option --inline"], check_commands.problems(self.root, self.doppel))

    def test_readme(self):
        self.page("# Doppel\nFor app engineers, people who film and studios, on iOS, visionOS, Android, Linux and Windows.\n\n" + "word " * 61,
                  "README.md")
        self.complaints(["does not say 'Quest'", "a paragraph of 61 words"], check_pages.problems(self.root))

    def test_programs_that_grow(self):
        (self.root / "docs/guides").mkdir()
        program = "```cpp\n// a comment\n\nint main() {\n" + "    f();  // said\n" * 11 + "}\n```\n"
        self.page("# Guides\n[sdk](sdk.md)\n", "docs/guides/README.md")
        self.page(program, "docs/guides/sdk.md")
        self.complaints(["1 programs in C++, and limits for 2", "sdk.md:2: a program of 13 lines; 12 is the most"],
                        check_pages.problems(self.root))

    def guides(self, table, page="```sh\ntools/bootstrap  # once\ndoppel render a.glb \\\n    --size 8x8\ndoppel-viewer a.glb\ntools/deps no-ndk\n```\n"):
        """The script and what is wrong, of one guide."""
        (self.root / "docs/guides").mkdir(exist_ok=True)
        self.page(page, "docs/guides/viewer.md")
        self.page(f"## Commands of the guides\n| command | what | why |\n|---|---|---|\n{table}", "docs/portability.md")
        with unittest.mock.patch.multiple(guide_lines, FIRST=(("viewer", "tools/bootstrap"),), MADE={("viewer", "doppel render"): ("touch a.glb",)}):
            ahead, rest, wrong = guide_lines.plan(self.root)
            lines = [line for line in guide_lines.script(ahead, rest, ()).splitlines() if line.startswith(("made ", "run ", "window "))]
            return [line.replace("docs/guides/viewer.md", "viewer") for line in lines], wrong

    def test_guides_run_as_they_stand_there(self):
        table = ("| `doppel render …` | as `doppel render … --quiet` | dear |\n| `doppel-viewer …` | a window | no end |\n"
                 "| `tools/deps …` | not run | no NDK |\n")
        self.assertEqual(self.guides(table), ([
            "run viewer:2 tools/bootstrap tools/bootstrap", "made 'touch a.glb'",
            "run viewer:3 'doppel render a.glb --size 8x8' 'doppel render a.glb --size 8x8 --quiet'",
            "window viewer:5 'doppel-viewer a.glb'"], []))

    def test_guides_without_a_row_run_as_written(self):
        self.assertIn("run viewer:6 'tools/deps no-ndk' 'tools/deps no-ndk'", self.guides("")[0])

    def test_rows_of_guides_that_are_wrong(self):
        table = "| `gone` | not run | nobody has it |\n| `doppel render …` | sometimes | so |\n| `tools/deps …` | not run |\n"
        self.complaints(["portability.md:5: a row is", "portability.md:6: a row is", "portability.md:4: no guide has the command 'gone'"],
                        self.guides(table)[1])

    def test_fixtures_of_guides_that_nothing_needs(self):
        self.complaints(["no command begins with 'doppel render'"], self.guides("", "```sh\ntools/bootstrap\n```\n")[1])

    def test_what_a_page_must_show_first(self):
        (self.root / "docs/guides").mkdir()
        self.page("```sh\ndoppel render a.glb\ndoppel render b.glb\n```\n", "docs/guides/capture.md")
        with unittest.mock.patch.dict(check_commands.PREPARED, {"docs/guides/capture.md": ("doppel render", ("doppel setup",))}):
            self.complaints(["2: 'doppel setup' must come before 'doppel render'"], check_commands.problems(self.root, self.doppel))

    def test_commands_of_the_viewer(self):
        self.page("```sh\ndoppel-viewer a.glb --room dark\ndoppel-viewer a.glb --rom dark\n```\n`doppel-viewer --inline`\n")
        viewer = self.root / "doppel-viewer"
        viewer.write_text("#!/bin/sh\necho '--room'\n")
        viewer.chmod(0o755)
        self.complaints(["no option --rom", "no option --inline"], check_commands.problems(self.root, self.doppel, viewer=viewer))
        self.complaints([], check_commands.problems(self.root, self.doppel))

    def test_packages(self):
        (self.root / "tools").mkdir()
        (self.root / "tools/packages-sdk.txt").write_text("one\ntwo\n")
        (self.root / "tools/packages.txt").write_text("three\n")
        (self.root / "docs/guides").mkdir()
        self.page("```sh\nsudo apt-get install three four\nsudo rm x\n```\n")
        self.page("```sh\nsudo apt-get install one \\\n    three\n```\n", "docs/guides/sdk.md")
        self.complaints(["sdk.md:2: apt-get and tools/packages-sdk.txt differ in three, two", "installs no 'four'", "'sudo rm x' is no command"],
                        check_commands.problems(self.root, self.doppel))

    def snippets(self, text):
        self.page(text)
        (self.root / "sdk/include/doppel").mkdir(parents=True)
        (self.root / "sdk/include/doppel/doppel.hpp").touch()
        (self.root / "tiny.glb").touch()
        compiler = check_snippets.Compiler(self.root, self.root / "installed", "cc", "c++", self.root)
        return check_snippets.problems(self.root, compiler, self.root / "tiny.glb")

    @unittest.skipUnless(shutil.which("cc") and shutil.which("c++"), "no cc and c++ in the path")
    def test_snippets(self):
        self.complaints(["no lines of the page build it", "does not compile", "neither a program", "does not compile"], self.snippets(
            "```c\nint main(void) { return 0; }\n```\n```c\nint main(void) { return gone(); }\n```\n"
            "```cpp\nnothing();\n```\n```cpp\n// given: int x\nint y = x + gone;\n```\n"))

    @unittest.skipUnless(shutil.which("cc"), "no cc in the path")
    def test_programs_are_run_by_the_lines_of_their_page(self):
        program = "```c\nint main(int argc, char** argv) { return argc != 2 || argv[1][0] != 'a' ? 3 : %d; }\n```\n"
        lines = "```sh\ncc app.c -o app\n./app avatar.glb\n```\n"
        self.page(program % 0 + lines, "docs/good.md")
        self.complaints(["page.md:2: the block fails by the lines from 5: (4)"], self.snippets(program % 4 + lines))

    @unittest.skipUnless(shutil.which("cc"), "no cc in the path")
    def test_lines_that_do_not_build_or_run(self):
        program = "```c\nint main(void) { return 0; }\n```\n"
        self.complaints(["which do not run it"], self.snippets(program + "```sh\ncc app.c -o app\n```\n"))

    @unittest.skipUnless(shutil.which("cc") and shutil.which("cmake"), "no cc and cmake in the path")
    def test_projects_are_the_cmake_block_of_their_page(self):
        program = "```c\nint main(void) { return 0; }\n```\n"
        project = "```cmake\ncmake_minimum_required(VERSION 3.16)\nproject(app C)\n%sadd_executable(app app.c)\n```\n"
        lines = "```sh\ncmake -S . -B build -DCMAKE_PREFIX_PATH=PREFIX\ncmake --build build\nbuild/app avatar.glb\n```\n"
        self.complaints(["fails by the lines from 11: (1)"], self.snippets(program + project % "find_package(gone REQUIRED)\n" + lines))


if __name__ == "__main__":
    unittest.main()
