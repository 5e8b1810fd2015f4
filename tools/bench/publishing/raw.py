# SPDX-License-Identifier: Apache-2.0
"""Raw figures: docs/benchmarks/NAME.json, one file a bench.

{"bench": name, "command": text, "run": {date, commit, compiler, processor, driver, seconds, other_work_cores, loaded, ...},
 "rows": [{..., "device": renderer and its device, "bars": {field: {"value": number, "kind": "at most" or "at least"}}}, ...]}

"run" holds for every row of its file. A bar belongs to the field of its row that has the bar's name.
"""
import json
import os


def dump(value, depth=0):
    """JSON with one line for each value below the second level: a changed figure changes one line."""
    if depth < 2 and isinstance(value, (dict, list)) and value:
        pad, end = " " * (depth + 1), " " * depth
        if isinstance(value, dict):
            parts = [f"{pad}{json.dumps(k)}: {dump(v, depth + 1)}" for k, v in value.items()]
            return "{\n" + ",\n".join(parts) + f"\n{end}}}"
        return "[\n" + ",\n".join(pad + dump(v, depth + 1) for v in value) + f"\n{end}]"
    return json.dumps(value, ensure_ascii=False)


def write_text(path, text):
    """Atomically: a run that is cut off never leaves half a file."""
    part = path.with_name(path.name + ".part")
    part.write_text(text, encoding="utf-8")
    os.replace(part, path)


def write(folder, name, command, run, rows):
    folder.mkdir(parents=True, exist_ok=True)
    write_text(folder / f"{name}.json", dump({"bench": name, "command": command, "run": run, "rows": rows}) + "\n")


class Store:
    """All raw files of a folder, read once."""

    def __init__(self, folder):
        self.files = {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*.json"))}

    def get(self, name):
        """The file of one bench, or None where it was never taken."""
        return self.files.get(name)

    def rows(self, name):
        found = self.get(name)
        return found["rows"] if found else []


def met(row, field):
    """True or False where the row has a bar for the field, else None."""
    bar = row.get("bars", {}).get(field)
    if bar is None or row.get(field) is None:
        return None
    return row[field] <= bar["value"] if bar["kind"] == "at most" else row[field] >= bar["value"]
