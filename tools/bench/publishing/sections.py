# SPDX-License-Identifier: Apache-2.0
"""The parts that pages are made of: rows that are looked up, and sections of one bench each."""
from .markdown import taken

BACK = "[All benchmarks](../benchmarks.md)\n\n"


def find(rows, **wanted):
    """The first row with these values, or None."""
    return next((r for r in rows if all(r.get(k) == v for k, v in wanted.items())), None)


def missing(*names):
    return "Not taken yet: `tools/bench/publish " + " ".join(f"--only {n}" for n in names) + "`.\n\n"


def missing_of(store, names):
    """One sentence for all of these benches that were never taken."""
    absent = [name for name, _ in names if not store.get(name)]
    return missing(*absent) if absent else ""


def section(store, name, title, body):
    """A heading, the body of one bench, and how its figures came about."""
    file = store.get(name)
    return f"## {title}\n\n" + (body(file["rows"]) + "\n" + taken(file) + "\n" if file else missing(name))
