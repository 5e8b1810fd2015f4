#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds the pages of the repository: links and anchors lead somewhere, paths in backticks exist, tables are whole, ADRs fit on a page,
first programs are short."""
import pathlib
import re
import runpy
import sys

import markdown
import recipes

ROOMS = ("sdk", "shaders", "apps", "reconstruction", "tools", "tests", "docs", "platform")
PATH = re.compile(r"(?:%s)/[\w./+-]*" % "|".join(ROOMS))
MAX_ADR_WORDS = 500
MAX_README_WORDS = 60
# The most lines of the C++ programs of a page, in their order, without empty lines and those of comments alone.
MAX_PROGRAM_LINES = {"docs/guides/sdk.md": (12, 45)}
README_NAMES = ("app engineers", "people who film", "studios", "iOS", "visionOS", "Android", "Quest", "Linux", "Windows")


def link_problems(root, page, known):
    for number, target in page.links():
        if re.match(r"[a-z]+:", target):
            continue
        file, _, anchor = target.partition("#")
        path = (page.path.parent / file).resolve() if file else page.path.resolve()
        if not path.exists():
            yield f"{page.name}:{number}: the link {target} leads nowhere"
        elif anchor and path in known and anchor not in known[path].anchors():
            yield f"{page.name}:{number}: {path.relative_to(root)} has no heading '{anchor}'"


def path_problems(root, page):
    """A span that begins like a path of ours. Programs are named without .cpp, where their source is."""
    for number, span in page.spans():
        match = PATH.match(span)
        if not match or match.end() < len(span) and span[match.end()] not in " ,;:":
            continue  # no path, or a pattern with * or {}
        path = root / match.group().rstrip(".")
        if not path.exists() and not path.with_suffix(".cpp").exists():
            yield f"{page.name}:{number}: `{match.group()}` does not exist"


def cells(line):
    return len(re.findall(r"(?<!\\)\|", line.strip())) - 1


def table_problems(page):
    previous = {number: line for number, line in page.prose}
    width, start = 0, 0
    for number, line in page.prose:
        if not line.strip().startswith("|"):
            width = 0
        elif not width and re.fullmatch(r"\|[\s:|-]+\|", line.strip()):
            width, start = cells(line), number
            if cells(previous.get(number - 1, "")) != width:
                yield f"{page.name}:{number - 1}: the table has {cells(previous.get(number - 1, ''))} headings for {width} columns"
        elif width and cells(line) != width:
            yield f"{page.name}:{number}: a table row of {cells(line)} cells in a table of {width} columns (from line {start})"


def adr_problems(page):
    if not re.fullmatch(r"docs/adr/\d{4}-.*\.md", page.name):
        return
    words = len(page.path.read_text(encoding="utf-8").split())
    if words > MAX_ADR_WORDS:
        yield f"{page.name}: {words} words; a decision has at most {MAX_ADR_WORDS}"
    if not any(line.startswith("Status: ") for _, line in page.prose):
        yield f"{page.name}: no line 'Status: ...'"


def index_problems(root, all_pages):
    """Every decision stands in the index, so that a second draft of one is not left lying."""
    index = root / "docs/adr/README.md"
    listed = re.findall(r"\]\((\d{4}-[^)]*\.md)\)", index.read_text(encoding="utf-8")) if index.exists() else []
    for page in all_pages:
        if re.fullmatch(r"docs/adr/\d{4}-.*\.md", page.name) and page.path.name not in listed:
            yield f"{page.name}: not in docs/adr/README.md"


def cited_problems(root, page):
    """A decision that is cited by its number has a page, or a line in the index that says where it went."""
    index = root / "docs/adr/README.md"
    known = set(re.findall(r"\b\d{4}\b", index.read_text(encoding="utf-8"))) if index.exists() else set()
    for number, line in page.prose:
        for cited in re.findall(r"\bADR (\d{4})\b", line):
            if cited not in known:
                yield f"{page.name}:{number}: ADR {cited} is not in docs/adr/README.md"


def arrow_problems(root):
    """The overview's table of rooms says what the test of the include arrows holds."""
    arrows, overview = root / "tests/structure/check_arrows.py", root / "docs/overview.md"
    if not arrows.exists() or not overview.exists():
        return
    rules = runpy.run_path(str(arrows))["SDK"]
    text = overview.read_text(encoding="utf-8")
    for room, allowed in rules.items():
        if room == "sdk/include":
            continue
        row = re.search(rf"^\| `{room}` \| (.*) \|$", text, re.MULTILINE)
        wanted = ", ".join(f"`{a}`" if not a.startswith("sdk/") else a[4:] for a in allowed) or "nobody"
        wanted = "anything in `sdk`" if allowed == ["sdk"] else wanted
        if not row or row.group(1) != wanted:
            yield f"docs/overview.md: the row of `{room}` should say: {wanted}"


def guide_problems(root, page):
    """Every guide stands in the index of guides, which llms.txt leads coding agents to."""
    targets = {(page.path.parent / target).resolve() for _, target in page.links()}
    index = (root / "docs/guides/README.md").resolve()
    if page.name == "llms.txt" and index not in targets:
        yield "llms.txt: no link to docs/guides/README.md"
    if page.path.resolve() == index:
        for guide in sorted(index.parent.glob("*.md")):
            if guide.resolve() not in targets | {index}:
                yield f"{page.name}: {guide.name} is not in this index"


def readme_problems(root, page):
    """Says first for whom and where; stays short."""
    if page.name != "README.md":
        return
    paragraphs = [p for p in "\n".join(line for _, line in page.prose).split("\n\n") if not p.startswith(("#", "!", "|", "-"))]
    paragraphs += [line for _, line in page.prose if line.startswith("-")]
    first = next((line for _, line in page.prose if line and not line.startswith("#")), "")
    for name in README_NAMES:
        if name not in first:
            yield f"README.md: its first paragraph does not say '{name}'"
    for paragraph in paragraphs:
        words = len(markdown.LINK.sub("link", paragraph).split())
        if words > MAX_README_WORDS:
            yield f"README.md: a paragraph of {words} words, at most {MAX_README_WORDS}: {paragraph[:60]}"


def program_problems(page):
    limits = MAX_PROGRAM_LINES.get(page.name, ())
    programs = [block for block in page.blocks if block.language == "cpp" and recipes.is_program(block)]
    if len(programs) < len(limits):
        yield f"{page.name}: {len(programs)} programs in C++, and limits for {len(limits)}"
    for block, limit in zip(programs, limits):
        count = sum(not re.match(r"\s*(//.*)?$", line) for line in block.text.splitlines())
        if count > limit:
            yield f"{page.name}:{block.line}: a program of {count} lines; {limit} is the most"


def problems(root):
    yield from arrow_problems(root)
    all_pages = list(markdown.pages(root))
    yield from index_problems(root, all_pages)
    known = {page.path.resolve(): page for page in all_pages}
    for page in all_pages:
        yield from link_problems(root, page, known)
        yield from table_problems(page)
        yield from adr_problems(page)
        yield from cited_problems(root, page)
        yield from readme_problems(root, page)
        yield from guide_problems(root, page)
        yield from program_problems(page)
        if not page.is_history():
            yield from path_problems(root, page)


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    return markdown.report(list(problems(root)), f"{len(list(markdown.pages(root)))} pages")


if __name__ == "__main__":
    sys.exit(main())
