#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Lays report.html out in headless Chromium, 1280 and 390 px wide, and measures that nothing runs out of the page and that a phone's first
screen holds the person. Skips where Chromium is not installed: page_test.cpp then holds the same as far as the text of the page shows it.

    layout_test.py REPORT_PAGE        pages that the program report_page writes
    layout_test.py FILE.html ...      given pages
"""
import html
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SKIP = 77
SCREENS = ((1280, 800), (390, 844))
FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
         "--disable-component-update", "--disable-sync", "--hide-scrollbars", "--window-size=1800,1000", "--virtual-time-budget=5000")
SMALLEST_FONT_PX = 11
# Runs inside the page. A box is cut when its content is wider than itself and it cannot scroll.
MEASURE = """<script>addEventListener("load", () => {
    const root = document.scrollingElement, person = document.querySelector(".top img"), verdict = document.querySelector(".verdict"), download = document.querySelector("a[download]");
    const closed = {width: root.scrollWidth, bottom: person && person.getBoundingClientRect().bottom,
                    personHeight: person && person.getBoundingClientRect().height, verdict: verdict && verdict.getBoundingClientRect().bottom,
                    download: download && download.getBoundingClientRect().bottom};
    document.querySelectorAll("details").forEach(d => d.open = true);
    const cut = [], out = [], small = [];
    for (const e of document.body.querySelectorAll("*")) {
        const box = e.getBoundingClientRect(), scrolls = getComputedStyle(e).overflowX == "auto";
        if (e.clientWidth && e.scrollWidth > e.clientWidth + 1 && !scrolls && !e.closest("svg")) cut.push(e.outerHTML.slice(0, 90));
        if (box.right > root.clientWidth + 1 && !e.parentElement.closest(".scroll")) out.push(e.outerHTML.slice(0, 90));
        if ([...e.childNodes].some(n => n.nodeType == 3 && n.data.trim()) && box.height) {
            const scale = e.ownerSVGElement ? e.ownerSVGElement.getBoundingClientRect().width / e.ownerSVGElement.viewBox.baseVal.width : 1;
            if (parseFloat(getComputedStyle(e).fontSize) * scale < SMALLEST) small.push(e.outerHTML.slice(0, 90));
        }
    }
    parent.postMessage({name: window.name, client: root.clientWidth, closed, opened: root.scrollWidth, cut, out, small}, "*");
});</script>"""
FRAME = """<!doctype html><meta charset=utf-8><body><script>
    const seen = {};
    addEventListener("message", m => { seen[m.data.name] = m.data; document.body.dataset.seen = JSON.stringify(seen); });
</script>%s</body>"""


def measures(chromium, page, folder):
    """What the page measures on each screen."""
    (folder / "page.html").write_text(page.read_text(encoding="utf-8") + MEASURE.replace("SMALLEST", str(SMALLEST_FONT_PX)), encoding="utf-8")
    frames = "".join(f'<iframe name="{w}" src="page.html" width={w} height={h} style="border:0"></iframe>' for w, h in SCREENS)
    (folder / "frame.html").write_text(FRAME % frames, encoding="utf-8")
    run = subprocess.run([chromium, *FLAGS, f"--user-data-dir={folder / 'profile'}", "--dump-dom", (folder / "frame.html").as_uri()],
                         capture_output=True, text=True, timeout=600)
    found = re.search(r'data-seen="([^"]*)"', run.stdout)
    if not found:
        sys.exit(f"FAILED: Chromium measured nothing in {page}:\n{run.stderr[-2000:]}")
    return json.loads(html.unescape(found.group(1)))


def problems(seen):
    for width, height in SCREENS:
        m = seen.get(str(width))
        if m is None:
            yield f"{width} px: not measured"
            continue
        for when, wide in (("", m["closed"]["width"]), (" with its details open", m["opened"])):
            if wide > m["client"]:
                yield f"{width} px: the page{when} is {wide} px wide and scrolls sideways"
        for what, elements in (("cut off", m["cut"]), ("outside the page", m["out"]), (f"smaller than {SMALLEST_FONT_PX} px", m["small"])):
            for element in elements[:5]:
                yield f"{width} px: {what}: {element}"
        if m["closed"]["bottom"] is None:
            yield f"{width} px: no picture"
        elif not 150 <= m["closed"]["personHeight"] or m["closed"]["bottom"] > height:
            yield f"{width} px: the person is {m['closed']['personHeight']:.0f} px high and ends at {m['closed']['bottom']:.0f} px"
        if m["closed"]["verdict"] is None or m["closed"]["verdict"] > height:
            yield f"{width} px: the verdict ends at {m['closed']['verdict']} px"
        if m["closed"]["download"] is not None and m["closed"]["download"] > height:
            yield f"{width} px: Download ends at {m['closed']['download']} px"


def main():
    chromium = shutil.which("chromium") or shutil.which("chromium-headless-shell")
    if not chromium:
        print("SKIPPED: chromium is not installed (Debian package chromium), so no page was laid out")
        sys.exit(SKIP)
    failed = False
    with tempfile.TemporaryDirectory() as made:
        folder = pathlib.Path(made)
        if sys.argv[1].endswith(".html"):
            pages = [pathlib.Path(name) for name in sys.argv[1:]]
        else:
            pages = [folder / f"{which}.html" for which in ("tall", "wide", "bare", "live")]
            for page in pages:
                subprocess.run([sys.argv[1], page.stem, page], check=True)
        for page in pages:
            seen = measures(chromium, page, folder)
            found = list(problems(seen))
            failed |= bool(found)
            for width, m in seen.items():
                print(f"{page.name} at {width} px: the person ends at {m['closed']['bottom']} px, the verdict at {m['closed']['verdict']} px")
            for line in found:
                print(f"FAILED: {page.name}: {line}")
    sys.exit(failed)


if __name__ == "__main__":
    main()
