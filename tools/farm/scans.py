# SPDX-License-Identifier: Apache-2.0
"""Which scans a farm has, and what of each changed last. The Snakefile imports it."""
import os
import pathlib


def scans_below(folder, out):
    """Names of the scans: the visible folders of `folder` but `out`. And names of its visible files, which are none."""
    entries = sorted(path for path in folder.iterdir() if not path.name.startswith("."))
    scans = [path.name for path in entries if path.is_dir() and path.resolve() != out]
    return scans, [path.name for path in entries if not path.is_dir()]


def changed_last(scan):
    """The file or folder of a scan that changed last, as text. It stands for all of them: who adds, replaces or removes a file changes its
    folder, and who writes into one changes the file."""
    newest = (scan.stat().st_mtime_ns, str(scan))
    for root, folders, files in os.walk(scan):
        for name in folders + files:
            path = pathlib.Path(root, name)
            if path.exists():  # links may lead nowhere
                newest = max(newest, (path.stat().st_mtime_ns, str(path)))
    return newest[1]
