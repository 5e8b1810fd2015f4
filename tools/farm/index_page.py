#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the page of a farm's results to standard output: failures first, a row a scan with its figures, and what 10,000 such scans need.

Example: tools/farm/index_page.py AVATARS ada ben > AVATARS/index.html
"""
import html
import json
import math
import pathlib
import sys

HEAD = """<!doctype html><html lang="en"><meta charset="utf-8"><title>Doppel: {count} scans</title>
<style>body{{font:15px/1.5 system-ui,sans-serif;margin:2em auto;max-width:70em;padding:0 1em}}table{{border-collapse:collapse;width:100%}}
td,th{{padding:.4em .8em;border-bottom:1px solid #ddd;text-align:left;vertical-align:top}}td.n{{text-align:right}}.bad{{color:#a00}}</style>
<h1>{count} scans</h1><p>{done} avatars, {failed} without one. {plan}</p>
<table><tr><th>scan<th>result<th>static, dB<th>moving, dB<th>MB<th>minutes<th>peak memory, MiB</tr>"""


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


def row(name, result):
    """A scan's row."""
    if "error" in result:
        message = html.escape(result["error"].get("message", "failed")).replace("\n", "<br>")
        return f'<tr><td>{html.escape(name)}<td class="bad" colspan="6">{message}</tr>'
    report = json.loads(pathlib.Path(result["figures"]).read_text())
    minutes = sum(stage["seconds"] for stage in result["stages"]) / 60
    cells = [f"{value:.2f}" if value is not None else "–" for value in (mean_psnr(report, "static"), mean_psnr(report, "dynamic"))]
    cells += [f"{pathlib.Path(result['avatar']).stat().st_size / 1e6:.2f}", f"{minutes:.1f}", f"{result['peakBytes'] >> 20}"]
    link = f'<a href="{html.escape(name)}/report.html">report</a>, <a href="{html.escape(name)}/avatar.glb">avatar.glb</a>'
    return f"<tr><td>{html.escape(name)}<td>{link}" + "".join(f'<td class="n">{cell}' for cell in cells) + "</tr>"


def main():
    if len(sys.argv) < 3 or sys.argv[1] in ("-h", "--help"):
        print(__doc__, file=sys.stderr)
        return 2
    out, names = pathlib.Path(sys.argv[1]), sys.argv[2:]
    results = {name: json.loads((out / name / "result.json").read_text()) for name in names}
    made = [name for name in names if "error" not in results[name]]
    needed = [need for need in (needs(out, name, results[name]) for name in made) if need]
    print(HEAD.format(count=len(names), done=len(made), failed=len(names) - len(made), plan=plan(needed)))
    for name in sorted(names, key=lambda n: n in made):
        print(row(name, results[name]))
    print("</table></html>")
    return 0


if __name__ == "__main__":
    sys.exit(main())
