#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the page of a farm's results, AVATARS/index.html: failures first, a row a scan with picture, verdict, advice and figures, those
that are not done last, and what 10,000 such scans need. While some are not done, the page loads itself again every minute.

Example: tools/farm/index_page.py AVATARS ada ben
"""
import html
import json
import math
import os
import pathlib
import sys

AGAIN = '<meta http-equiv="refresh" content="60">'
HEAD = """<!doctype html><html lang="en"><meta charset="utf-8">{again}<title>Doppel: {count} scans</title>
<style>body{{font:15px/1.5 system-ui,sans-serif;margin:2em auto;max-width:70em;padding:0 1em}}table{{border-collapse:collapse;width:100%}}
td,th{{padding:.4em .8em;border-bottom:1px solid #ddd;text-align:left;vertical-align:top}}td.n{{text-align:right}}.bad{{color:#a00}}
td img{{height:120px;display:block}}</style>
<h1>{count} scans</h1><p>{done} avatars, {failed} without one{waiting}. {plan}</p>
<table><tr><th>scan<th>result<th>verdict<th>static, dB<th>moving, dB<th>MB<th>minutes<th>peak memory, MiB</tr>"""


def mean_psnr(report, kind):
    """Mean masked PSNR of the held-out frames of a kind, with pose fit, or None."""
    return report.get("means", {}).get(kind, {}).get("with_pose_fit", {}).get("masked_psnr_db")


def size_of(folder):
    """Bytes of the files in a folder and below."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def needs(out, name, result):
    """What an avatar took: minutes, core-hours, and the peak memory and the disk in bytes. None if stages of an earlier try were reused."""
    if any(stage["reused"] for stage in result["stages"]):
        return None
    seconds = sum(stage["seconds"] for stage in result["stages"])
    return {"minutes": seconds / 60, "coreHours": result["cpuSeconds"] / 3600, "peak": result["peakBytes"], "disk": size_of(out / name)}


def plan(needed):
    """A sentence on what 10,000 scans like the measured ones need."""
    if not needed:
        return ""
    mean = {key: sum(need[key] for need in needed) / len(needed) for key in ("minutes", "coreHours", "disk")}
    hours, peak = 10000 * mean["coreHours"], max(need["peak"] for need in needed)
    return (f"{mean['minutes']:.1f} minutes a scan. 10,000 like these need {hours:,.0f} core-hours ({math.ceil(hours / 10):,} cores for a "
            f"night of ten hours), {peak / 2**30:.1f} GiB of memory a job and {10000 * mean['disk'] / 1e12:.2f} TB of disk.")


def verdict(report):
    """The report's word, and the first advice below it."""
    cell = f"<b>{html.escape(report.get('word', '–'))}</b>"
    advice = [line.strip() for line in report.get("film_again", "").splitlines() if line.strip().startswith("1. ")]
    return cell + (f"<br>{html.escape(advice[0][3:])}" if advice else "")


def row(out, name, result):
    """A scan's row. A scan without a result is not done."""
    scan = html.escape(name)
    if result is None:
        return f'<tr><td>{scan}<td colspan="7">not done yet</tr>'
    if "error" in result:
        message = html.escape(result["error"].get("message", "failed")).replace("\n", "<br>")
        return f'<tr><td>{scan}<td class="bad" colspan="7">{message}</tr>'
    report = json.loads(pathlib.Path(result["figures"]).read_text())
    minutes = sum(stage["seconds"] for stage in result["stages"]) / 60
    cells = [f"{value:.2f}" if value is not None else "–" for value in (mean_psnr(report, "static"), mean_psnr(report, "dynamic"))]
    cells += [f"{pathlib.Path(result['avatar']).stat().st_size / 1e6:.2f}", f"{minutes:.1f}", f"{result['peakBytes'] >> 20}"]
    picture = f'<img src="{scan}/portrait.jpg" alt="{scan}" loading="lazy">' if (out / name / "portrait.jpg").is_file() else ""
    link = f'{picture}<a href="{scan}/report.html">report</a>, <a href="{scan}/avatar.glb">avatar.glb</a>'
    return f"<tr><td>{scan}<td>{link}<td>{verdict(report)}" + "".join(f'<td class="n">{cell}' for cell in cells) + "</tr>"


def result_of(out, name):
    """What a scan's job left, or None: it is not done."""
    path = out / name / "result.json"
    return json.loads(path.read_text()) if path.is_file() else None


def page(out, names):
    """The page's text."""
    results = {name: result_of(out, name) for name in names}
    made = [name for name in names if results[name] and "error" not in results[name]]
    waiting = sum(result is None for result in results.values())
    needed = [need for need in (needs(out, name, results[name]) for name in made) if need]
    lines = [HEAD.format(count=len(names), done=len(made), failed=len(names) - len(made) - waiting, plan=plan(needed),
                         waiting=f", {waiting} not done yet" if waiting else "", again=AGAIN if waiting else "")]
    lines += [row(out, name, results[name]) for name in sorted(names, key=lambda n: (results[n] is None, n in made))]
    return "\n".join(lines + ["</table></html>", ""])


def write(out, names):
    """Writes the page by a rename, so that jobs that end together leave a whole one."""
    part = out / f".index.{os.getpid()}.part"
    part.write_text(page(out, names))
    part.replace(out / "index.html")


def main():
    if len(sys.argv) < 3 or sys.argv[1] in ("-h", "--help"):
        print(__doc__, file=sys.stderr)
        return 2
    write(pathlib.Path(sys.argv[1]), sys.argv[2:])
    return 0


if __name__ == "__main__":
    sys.exit(main())
