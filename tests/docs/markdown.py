# SPDX-License-Identifier: Apache-2.0
"""The parts of a Markdown page that the checks read: fenced blocks, prose lines, code spans, links and headings."""
import dataclasses
import pathlib
import re

FENCE = re.compile(r"^\s*```(\S*)\s*$")
SPAN = re.compile(r"`([^`]+)`")
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
SKIPPED_FOLDERS = {"build", "out", "demo", "node_modules", "third_party"}


@dataclasses.dataclass
class Block:
    language: str
    line: int  # of its first line of text
    text: str

    def commands(self):
        """Line number and text of each command of a shell block: continued lines are joined, comments and empty lines left out."""
        command, first = "", self.line
        for number, line in enumerate(self.text.splitlines(), self.line):
            first = first if command else number
            command += line.removesuffix("\\")
            if line.endswith("\\"):
                continue
            if command.strip() and not command.lstrip().startswith("#"):
                yield first, command
            command = ""


@dataclasses.dataclass
class Page:
    path: pathlib.Path
    name: str  # relative to the root, for messages
    blocks: list
    prose: list  # (line number, text) outside of fenced blocks

    def spans(self):
        for number, line in self.prose:
            for span in SPAN.findall(line):
                yield number, span

    def links(self):
        for number, line in self.prose:
            for target in LINK.findall(SPAN.sub("", line)):
                yield number, target

    def anchors(self):
        """As GitHub makes them of headings."""
        found = set()
        for _, line in self.prose:
            if line.startswith("#"):
                text = LINK.sub("", line.lstrip("#").strip()).replace("`", "").lower()
                found.add(re.sub(r"[^\w\- ]", "", text).replace(" ", "-"))
        return found

    def is_history(self):
        return self.name.startswith(("docs/adr/", "docs/notebook/"))


def read_page(root, path):
    blocks, prose, language, start, lines = [], [], None, 0, []
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        fence = FENCE.match(line)
        if language is None and fence:
            language, start, lines = fence.group(1), number + 1, []
        elif language is not None and line.strip() == "```":
            blocks.append(Block(language, start, "\n".join(lines) + "\n"))
            language = None
        elif language is not None:
            lines.append(line)
        else:
            prose.append((number, line))
    return Page(path, path.relative_to(root).as_posix(), blocks, prose)


def pages(root):
    for path in [*sorted(root.rglob("*.md")), *root.glob("llms.txt")]:  # llms.txt is Markdown by its convention
        parts = path.relative_to(root).parts
        if not any(part in SKIPPED_FOLDERS or part.startswith(".") for part in parts[:-1]):
            yield read_page(root, path)


def report(problems, what):
    """Prints and turns into an exit status."""
    for problem in problems:
        print(problem)
    print(f"{what}, {len(problems)} wrong")
    return 1 if problems else 0
