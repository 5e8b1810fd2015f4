# SPDX-License-Identifier: Apache-2.0
"""The command line of tools/bench/publish."""
import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import time

from . import benches, machine, pages, raw

EXAMPLES = """examples:
  tools/bench/publish                          the quick benches (about 26 minutes on two quiet cores), then all pages
  tools/bench/publish --list                   the benches, how long each takes, and what is on record
  tools/bench/publish --only load --only floor two of them
  tools/bench/publish --only long              scan-a, scan-a with the MakeHuman body, the biker
  tools/bench/publish --only unseen            procedural seeds 4 to 9
  tools/bench/publish --only gpu               frames on a GPU, where the machine has one
  tools/bench/publish --render-only            only the pages, from docs/benchmarks/*.json
A run that is cut off (Ctrl-C) continues when the same command is given again; --again starts it from the beginning."""


def parse(arguments):
    parser = argparse.ArgumentParser(prog="tools/bench/publish", description=__import__("__main__").__doc__, epilog=EXAMPLES,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", action="append", metavar="NAME",
                        help="a bench, or a group: quick, long, gpu, unseen, browser, all (default: quick)")
    parser.add_argument("--list", action="store_true", help="list the benches and run nothing")
    parser.add_argument("--render-only", action="store_true", help="write the pages from the raw figures and run nothing")
    parser.add_argument("--out", type=pathlib.Path, help="folder for the pages instead of docs/ (its raw figures are still read there)")
    parser.add_argument("--avatar", type=pathlib.Path, help="draw this avatar instead of the procedural subject of seed 1")
    parser.add_argument("--repeats", type=int, default=9, help="timed frames a case (default 9)")
    parser.add_argument("--build", type=pathlib.Path, help="build folder with the programs (default build/release)")
    parser.add_argument("--no-build", action="store_true", help="use the programs as they are")
    parser.add_argument("--shared", type=pathlib.Path, help="folder with data/ and research/ (default ../shared)")
    parser.add_argument("--work", type=pathlib.Path, help="folder for scans, avatars and logs (default out/publish)")
    parser.add_argument("--again", action="store_true", help="forget a run that was cut off")
    parser.add_argument("--loaded", action="store_true", help="flag every figure as taken on a busy machine, whatever is measured")
    return parser.parse_args(arguments)


def chosen(only):
    wanted = only or ["quick"]
    groups = {b.group for b in benches.BENCHES} | {"all"}
    names = {b.name for b in benches.BENCHES}
    for name in wanted:
        if name not in groups | names:
            raise benches.BenchError(f"there is no bench '{name}'; there are {', '.join(sorted(groups))} and {', '.join(sorted(names))}")
    return [b for b in benches.BENCHES if "all" in wanted or b.group in wanted or b.name in wanted]


def show_list(root):
    store = raw.Store(root / "docs/benchmarks")
    for bench in benches.BENCHES:
        file = store.get(bench.name)
        state = f"on record: {file['run']['date']}, {file['run']['commit']}" if file else "not taken yet"
        if file and file["run"]["loaded"]:
            state += ", loaded"
        print(f"{bench.name:32} {bench.group:7} {bench.minutes:4g} min  {bench.about} ({state})")


class Session:
    """Which benches of an unfinished run are done. The file goes when the run has finished."""

    def __init__(self, path, names, again):
        self.path, self.names, self.done = path, names, []
        if path.exists() and not again:
            kept = json.loads(path.read_text(encoding="utf-8"))
            if kept["names"] == names:
                self.done = kept["done"]
        self.continued = bool(self.done)

    def save(self):
        self.path.parent.mkdir(parents=True, exist_ok=True)
        raw.write_text(self.path, json.dumps({"names": self.names, "done": self.done}))

    def finish(self):
        self.path.unlink(missing_ok=True)


def build(root, wanted):
    targets = sorted({{"doppel": "doppel_cli", "libdoppel.so": "doppel"}.get(p, p) for b in wanted for p in b.programs})
    print(f"building {', '.join(targets)}", flush=True)
    subprocess.run(["bash", "-c", '. tools/lib.sh && build release "$@"', "build", *targets], cwd=root, check=True)


def run_benches(options, root, wanted):
    place = benches.Place(root, (options.build or root / "build/release").resolve(), (options.shared or root / "../shared").resolve(),
                          (options.work or root / "out/publish").resolve(), options.avatar and options.avatar.resolve(), options.repeats)
    session = Session(place.work / "session.json", [b.name for b in wanted], options.again)
    if not session.continued:
        for bench in wanted:  # remove figures of earlier code, so that they cannot pass for this run's
            shutil.rmtree(place.work / bench.name, ignore_errors=True)
        for old in place.work.glob("[0-9]*.glb"):
            old.unlink()
    session.save()
    failed = []
    for k, bench in enumerate(wanted):
        left = sum(b.minutes for b in wanted[k:])
        head = f"[{k + 1}/{len(wanted)}] {bench.name}"
        if bench.name in session.done:
            print(f"{head}: done before the run was cut off", flush=True)
            continue
        print(f"{head}: {bench.about}, about {bench.minutes:g} min; about {left:g} min left in all", flush=True)
        began = time.monotonic()
        try:
            run = machine.describe(place.build)
            other = machine.OtherWork()
            rows = bench.take(place)
            run.update(other.stop())
            run["loaded"] = run["loaded"] or options.loaded
            raw.write(root / "docs/benchmarks", bench.name, bench.command, run, rows)
        except benches.Skipped as why:
            print(f"  left out: {why}", flush=True)
            continue
        except benches.BenchError as why:
            print(f"  FAILED: {why}", file=sys.stderr, flush=True)
            failed.append(bench.name)
            continue
        else:
            state = f"loaded by {run['other_work_cores']} cores of other work" if run["loaded"] else "on a quiet machine"
            print(f"  {time.monotonic() - began:.0f} s, {state}", flush=True)
        session.done.append(bench.name)
        session.save()
    if not failed:
        session.finish()
    return failed


def main(arguments=None):
    options = parse(arguments)
    root = pathlib.Path(__file__).resolve().parents[3]
    if options.list:
        show_list(root)
        return 0
    try:
        failed = []
        if not options.render_only:
            wanted = chosen(options.only)
            if not options.no_build:
                build(root, wanted)
            failed = run_benches(options, root, wanted)
        written = pages.write_all(root, options.out or root / "docs")
        print(f"{len(written)} pages written; look at {os.path.relpath(written[0])}")
        if failed:
            print(f"failed: {', '.join(failed)}; their old figures stay", file=sys.stderr)
        return 1 if failed else 0
    except KeyboardInterrupt:
        print("\nstopped; the same command continues", file=sys.stderr)
        return 130
    except (benches.BenchError, subprocess.CalledProcessError) as why:
        print(f"publish: {why}", file=sys.stderr)
        return 2
