#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes a shell script of the commands of README.md and the guides, as they stand there, for a bare Debian (tools/prove-debian --guides).

  guide_lines.py ROOT                   checks the table below, and says how many commands are run
  guide_lines.py ROOT SCRIPT [PAGE...]  writes SCRIPT, of these pages alone (reconstruct, README) and of what they build upon

Every command of an `sh` block, and of code spans in the pages of SPANS, is run in the folder of the source, page after page, unless a row
of the table "Commands of the guides" in docs/portability.md says otherwise. The first row whose command fits counts; `…` stands for
anything. A row says:
  as written        run; for commands that a later row would change
  as `COMMAND`      another command is run in its place; `…` is what it was in the row's command
  a window          run until its window has been there for a while, then ended
  by `COMMAND`      run to the letter elsewhere
  not run           why, in the next cell
"""
import dataclasses
import pathlib
import re
import shlex
import sys

import markdown

TABLE, HEADING = "docs/portability.md", "## Commands of the guides"
# Pages in the order in which they run. The index of guides has no commands. sdk.md is followed by tools/prove-debian --sdk.
PAGES = ("README", "release", "viewer", "reconstruct", "dress", "web", "farm", "performance", "troubleshooting", "vulkan", "ios", "android",
         "quest", "visionos", "metal", "conventions-for-engines", "unity-splats", "unreal-splats", "sdk", "capture", "import")
SPANS = ("import", "performance", "troubleshooting")
# Blocks that run before all pages, because pages take what they make as given: the page and a part of a line of the block.
FIRST = (("viewer", "tools/bootstrap"), ("web", "tools/prove-web --build"), ("reconstruct", "doppel_installed"),
         ("reconstruct", "doppel sample -o SCAN"))
TINY = '{"like": "draft", "steps": 60, "startSplats": 5000, "maxSplats": 6000, "polishSteps": 5, "poseFitRounds": 2}'
# A motion of six bones, in the names that the SDK knows.
BVH = """HIERARCHY
ROOT Hips
{ OFFSET 0 0 0 CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
JOINT LeftUpLeg { OFFSET 9 0 0 CHANNELS 3 Zrotation Xrotation Yrotation
JOINT LeftLeg { OFFSET 0 -42 0 CHANNELS 3 Zrotation Xrotation Yrotation End Site { OFFSET 0 -42 0 } } }
JOINT RightUpLeg { OFFSET -9 0 0 CHANNELS 3 Zrotation Xrotation Yrotation
JOINT RightLeg { OFFSET 0 -42 0 CHANNELS 3 Zrotation Xrotation Yrotation End Site { OFFSET 0 -42 0 } } }
JOINT Spine { OFFSET 0 12 0 CHANNELS 3 Zrotation Xrotation Yrotation End Site { OFFSET 0 40 0 } } }
MOTION
Frames: 3
Frame Time: 0.2
0 92 0 0 0 0 0 20 0 0 5 0 0 -20 0 0 20 0 0 0 0
0 92 0 0 0 0 0 0 0 0 5 0 0 0 0 0 5 0 0 5 0
0 92 0 0 0 0 0 -20 0 0 20 0 0 20 0 0 5 0 0 0 0
"""
AVATARS = ("[ -e ada/avatar.glb ] || for who in 1-ada 2-ben 3-cleo; do mkdir -p ${who#*-} && doppel sample-avatar -o ${who#*-}/avatar.glb"
           " --seed ${who%-*}; done")
# film NAME KIND RATE: a video of the pictures of the scan FILMED.
FILMS = ("[ -e FILMED ] || doppel sample -o FILMED --small --size 378x504 --posters",
         "film() { python3 -c 'import json, sys; [print(\"file FILMED/\" + f[\"image\"]) for f in json.load(open(\"FILMED/scan.json\"))[\"frames\"]"
         " if f[\"kind\"] == sys.argv[1]]' $2 >film.txt; ffmpeg -y -loglevel error -r $3 -f concat -safe 0 -i film.txt -c:v libx264 -crf 16"
         " -pix_fmt yuv420p $1; }",
         "film walk.mp4 static_full 4; film close.mp4 static_closeup 4; film moves.mp4 dynamic 5; rm -rf ada")
# What the reader of a page has, made before the first command that begins so ("": before the page).
MADE = {
    ("viewer", "build/release/apps/viewer/doppel-viewer"): (
        "cmake --build --preset release --target doppel_cli", "build/release/apps/doppel/doppel sample-avatar -o ada.glb",
        "Xvfb :99 -screen 0 1600x1000x24 >/dev/null 2>&1 & export DISPLAY=:99; until xdotool getdisplaygeometry; do sleep 0.2; done"),
    ("viewer", "doppel-viewer ada.glb walk.bvh"): (
        "cp ada.glb bob.glb", "cp motion.bvh walk.bvh", "cp motion.bvh run.bvh", "doppel export ada.glb -o guitar.ply"),
    ("release", "doppel render"): ("doppel sample-avatar -o sample-built-in.glb",),
    ("reconstruct", "doppel reconstruct ORBIT"): ("tools/strip_scan.py SCAN ORBIT mask labels keypoints", ),
    ("reconstruct", "doppel reconstruct SCAN -o OUT --preset mine.json"): (f"echo '{TINY}' >mine.json",),
    ("reconstruct", "doppel cameras"): (
        "rm -rf OUT", "mv SCAN GIVEN", "doppel sample -o LARGE --small --size 378x504 --posters", "tools/strip_scan.py LARGE SCAN camera"),
    ("reconstruct", "doppel reconstruct SCAN -o OUT --json"): ("rm -rf SCAN OUT", "mv GIVEN SCAN"),
    ("reconstruct", "doppel body import rigged.glb"): ("doppel export ada.glb --mesh -o rigged.glb",),
    ("reconstruct", "doppel inspect avatar.glb"): ("cp OUT/avatar.glb avatar.glb", "cp motion.bvh walk.bvh", "ln -sfn SCAN scan"),
    ("dress", ""): (AVATARS,),
    ("web", "doppel share"): (AVATARS,),
    ("farm", ""): ("apt-get install -y snakemake", "mkdir -p SCANS && doppel sample -o SCANS/one --small"),
    ("performance", ""): ("cp ada.glb avatar.glb",),
    ("troubleshooting", ""): (
        "cp ada.glb avatar.glb", "cp motion.bvh walk.bvh", "[ -e OUT/avatar.glb ] || { mkdir -p OUT && cp ada.glb OUT/avatar.glb; }"),
    ("capture", ""): FILMS,
    ("import", ""): (*FILMS, "rm -rf scan photos", "cp walk.mp4 orbit.mp4",
                     "for name in face hand; do ffmpeg -y -loglevel error -i close.mp4 -c copy $name.mov; done", "cp -r FILMED/images photos"),
    ("import", "doppel import walk.mp4"): ("rm -rf scan",),
    ("import", "doppel import --static orbit.mp4 --closeup face.mov --motion"): ("rm -rf scan",),
    ("import", "doppel import --static orbit.mp4 --closeup face.mov hand.mov"): ("rm -rf scan",),
    ("import", "doppel import photos"): ("rm -rf scan",),
}
PRELUDE = """#!/usr/bin/env bash
# Made by tests/docs/guide_lines.py. Runs in the folder of the source.
. tools/lib.sh
[ -n "$DOPPEL_COMPILER_LAUNCHER" ] || unset DOPPEL_COMPILER_LAUNCHER
trap 'kill $(jobs -p) 2>/dev/null' EXIT
logs=guide-logs commands=0 failures=()
rm -rf $logs && mkdir -p $logs
cat >tiny.json <<'J'
%s
J
cat >motion.bvh <<'B'
%sB
shown() { printf '%%s\\n' "$@"; }
# made COMMAND: what a page takes as given.
made() {
    shown "   made first: $1"
    eval "$1" >$logs/made 2>&1 </dev/null || { tail -n 5 $logs/made; failures+=("made first: $1"); }
}
# run WHERE WRITTEN COMMAND: the command that is written there, or the one that stands for it.
run() {
    local code=0 started=$SECONDS
    commands=$((commands + 1))
    shown "$1: $2"
    [ "$2" = "$3" ] || shown "   as: $3"
    eval "$3" >$logs/$commands 2>&1 </dev/null || code=$?
    ended $code "$1: $2" $((SECONDS - started))
}
# window WHERE COMMAND: runs it until a window of it has been there for ten seconds.
window() {
    local code=0 pid started=$SECONDS
    commands=$((commands + 1))
    shown "$1: $2" "   until its window has been there for ten seconds"
    eval "exec $2" >$logs/$commands 2>&1 </dev/null & pid=$!
    timeout 300 xdotool search --sync --onlyvisible --pid $pid >/dev/null 2>&1 || code=1
    sleep 10
    kill -TERM $pid 2>/dev/null || code=1
    wait $pid 2>/dev/null
    ended $code "$1: $2" $((SECONDS - started))
}
ended() {
    if [ $1 = 0 ]; then shown "   done in $3 s"; return; fi
    tail -n 8 $logs/$commands | sed 's/^/   | /'
    shown "   FAILED ($1) after $3 s"
    failures+=("$2")
}
"""
END = """
echo
echo "$commands commands, ${#failures[@]} failed"
[ ${#failures[@]} = 0 ] || { printf 'failed: %s\\n' "${failures[@]}"; exit 1; }
"""


@dataclasses.dataclass
class Row:
    line: int
    command: str
    what: str  # as written, as, a window, by, not run
    other: str  # the command of `as` and `by`
    why: str
    used: bool = False

    def fits(self, command):
        return re.fullmatch(re.escape(self.command).replace("…", "(.*)"), command)


@dataclasses.dataclass
class Command:
    page: str
    where: str
    block: int  # its first line; 0: a span
    text: str  # the command, without its comment, in one line
    row: Row = None

    def run_as(self):
        """What is run, or nothing."""
        what = self.row.what if self.row else "as written"
        if what in ("by", "not run"):
            return None
        if what != "as":
            return self.text
        parts = iter(self.row.fits(self.text).groups())
        return re.sub("…", lambda _: next(parts), self.row.other)


def rows_of(root):
    """The rows of the table, and what is wrong with them."""
    rows, wrong, inside = [], [], False
    page = markdown.read_page(root, root / TABLE)
    for number, line in page.prose:
        if line.startswith("#"):
            inside = line.strip() == HEADING
        cells = [cell.strip() for cell in line.strip().strip("|").split(" | ")] if inside and line.startswith("| `") else None
        if not cells:
            continue
        match = re.fullmatch(r"(as written|a window|not run|(as|by) `([^`]+)`)", cells[1])
        commands = re.findall(r"`([^`]+)`", cells[0])
        if len(cells) != 3 or not match or not cells[2]:
            wrong.append(f"{TABLE}:{number}: a row is a command, what is done with it, and why")
            continue
        rows += [Row(number, command, match.group(2) or match.group(1), match.group(3) or "", cells[2]) for command in commands]
    return rows, wrong


def page_path(root, name):
    return root / "README.md" if name == "README" else root / f"docs/guides/{name}.md"


def without_comment(line):
    return re.sub(r"\s+#\s.*$", "", re.sub(r"\s+", " ", line.strip()) + " ").strip()


def commands_of(root, name):
    page = markdown.read_page(root, page_path(root, name))
    for block in page.blocks:
        if block.language == "sh":
            for number, line in block.commands():
                yield Command(name, f"{page.name}:{number}", block.line, without_comment(line))
    for number, span in page.spans() if name in SPANS else ():
        if re.match(r"(doppel|doppel-viewer) [\w-]+ \S", span) and "…" not in span:
            yield Command(name, f"{page.name}:{number}", 0, span)


def plan(root):
    """All commands in the order in which they run, and what is wrong with the tables."""
    rows, wrong = rows_of(root)
    guides = {path.stem for path in (root / "docs/guides").glob("*.md")} - {"README"}
    wrong += [f"docs/guides/{name}.md is not among the pages of guide_lines.py" for name in sorted(guides - set(PAGES))]
    commands = {name: list(commands_of(root, name)) for name in PAGES if page_path(root, name).exists()}
    for command in (command for name in commands for command in commands[name]):
        command.row = next((row for row in rows if row.fits(command.text)), None)
        if command.row:
            command.row.used = True
    wrong += [f"{TABLE}:{row.line}: no guide has the command '{row.command}'" for row in rows if not row.used]
    ahead = []
    for name, part in FIRST:
        blocks = {c.block for c in commands.get(name, ()) if c.block and part in c.text}
        if len(blocks) != 1:
            wrong.append(f"{name}: {len(blocks)} blocks have '{part}', which runs first; there should be one")
        ahead += [c for c in commands.get(name, ()) if c.block in blocks]
    rest = [c for name in PAGES for c in commands.get(name, ()) if not any(c is other for other in ahead)]
    for name, start in MADE:
        if start and not any(c.page == name and c.text.startswith(start) for c in ahead + rest):
            wrong.append(f"{name}: no command begins with '{start}', before which guide_lines.py makes something")
    return ahead, rest, wrong


def script(ahead, rest, pages):
    lines, made = [PRELUDE % (TINY, BVH)], set()
    wanted = [c for c in rest if not pages or c.page in pages]
    for command in ahead + wanted:
        run = command.run_as()
        if run is None:
            continue
        for key, before in MADE.items():
            if key not in made and key[0] == command.page and command.text.startswith(key[1]) and (key[1] or not any(command is c for c in ahead)):
                made.add(key)
                lines += [f"made {shlex.quote(line)}\n" for line in before]
        if command.row and command.row.what == "a window":
            lines.append(f"window {shlex.quote(command.where)} {shlex.quote(run)}\n")
        else:
            lines.append(f"run {shlex.quote(command.where)} {shlex.quote(command.text)} {shlex.quote(run)}\n")
    return "".join(lines) + END


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    ahead, rest, wrong = plan(root)
    pages = sys.argv[3:]
    wrong += [f"guide_lines.py knows no page '{page}'; it knows {', '.join(PAGES)}" for page in pages if page not in PAGES]
    if len(sys.argv) > 2 and not wrong:
        pathlib.Path(sys.argv[2]).write_text(script(ahead, rest, pages), encoding="utf-8")
    count = {what: sum((c.row.what if c.row else "as written") == what for c in ahead + rest)
             for what in ("as written", "as", "a window", "by", "not run")}
    return markdown.report(wrong, f"commands of guides: {count['as written']} as written, {count['as']} as another, "
                                  f"{count['a window']} windows, {count['by']} run elsewhere, {count['not run']} not run")


if __name__ == "__main__":
    sys.exit(main())
