# SPDX-License-Identifier: Apache-2.0
"""Markdown tables whose cells cannot get out of step with their headings."""
from . import raw

NOTHING = "–"


def number(value, digits=2):
    if value is None:
        return NOTHING
    return f"{value:,.{digits}f}" if digits > 0 else f"{value:,.0f}"


def barred(row, field, digits=2, unit="", scale=1.0):
    """The figure, and behind it its bar and whether it is met."""
    value = row.get(field)
    if value is None:
        return NOTHING
    text = number(value * scale, digits) + (f" {unit}" if unit else "")
    fulfilled = raw.met(row, field)
    if fulfilled is None:
        return text
    bar = row["bars"][field]
    sign = "≤" if bar["kind"] == "at most" else "≥"
    return f"{text} ({'met' if fulfilled else '**missed**'}: {sign} {bar['value'] * scale:g})"


def table(headings, rows):
    """Refuses a row that has more or fewer cells than there are headings."""
    for row in rows:
        if len(row) != len(headings):
            raise ValueError(f"{len(row)} cells under {len(headings)} headings: {row}")
    lines = [headings, ["---"] * len(headings), *rows]
    return "".join("| " + " | ".join(str(cell).replace("|", "\\|") for cell in line) + " |\n" for line in lines)


def taken(file, indent=""):
    """The sentence below a table: how its figures came about. `indent`: of the lines behind the first, inside a list."""
    run = file["run"]
    cpu = run["processor"]
    parts = [f"Taken {run['date']} at commit `{run['commit']}`" + (" with changes that were not committed" if run["changed"] else "")]
    parts.append(f"{cpu['name']}, {cpu['cores']} cores, {cpu['vectors']}; {run['driver']}; {run['compiler']}")
    if run["loaded"]:
        parts.append(f"**loaded**: other work used {run['other_work_cores']:.1f} cores meanwhile, so times are upper bounds")
    return f"`{file['command']}`  \n{indent}{'. '.join(parts)}.\n"
