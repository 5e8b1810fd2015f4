# SPDX-License-Identifier: Apache-2.0
"""Every bench: the programs it needs, how it is run, and the rows that are kept of it."""
import dataclasses
import json
import pathlib
import re
import shutil
import statistics
import subprocess

from . import machine


class BenchError(Exception):
    """One sentence for a person."""


class Skipped(Exception):
    """The bench cannot run here; says what is missing."""


def at_most(value):
    return {"value": value, "kind": "at most"}


def at_least(value):
    return {"value": value, "kind": "at least"}


def program_folder(target):
    """The folder of a program, in the source tree and in a build tree alike."""
    return {"doppel": "apps/doppel", "libdoppel.so": "sdk/api", "bench_frames": "tools/bench/frames", "bench_ways": "tests/unit/interop",
            "bench_writes": "tests/unit/interop", "visibility_governor_test": "tests/unit/visibility", "bench_host": "tests/metal",
            "motion_tracker_test": "tests/unit/motion"}.get(target, "tools/bench")


@dataclasses.dataclass
class Place:
    """Where things lie, and what was asked for."""

    root: pathlib.Path
    build: pathlib.Path
    shared: pathlib.Path
    work: pathlib.Path
    given_avatar: pathlib.Path | None = None
    repeats: int = 9

    def program(self, target):
        folder = self.build / program_folder(target)
        if not (folder / target).exists():
            raise BenchError(f"{folder / target} is not built: build it, or leave out --no-build")
        return folder / target

    def avatar(self):
        """The procedural subject of seed 1 at draft quality: what tools/demo makes."""
        if self.given_avatar:
            return self.given_avatar
        made = self.work / "quality-procedural-1/avatar.glb"
        if not made.exists():
            reconstruct(self, "quality-procedural-1", sample(self, 1), ["--preset", "draft"])
        return made

    def run(self, log, command):
        """Runs a program, its output into a log. Gives its standard output."""
        self.work.mkdir(parents=True, exist_ok=True)
        path = self.work / f"{log}.log"
        with open(path, "w", encoding="utf-8") as errors:
            done = subprocess.run([str(c) for c in command], cwd=self.root, stdout=subprocess.PIPE, stderr=errors, text=True)
        if done.returncode != 0:
            last = [line for line in path.read_text(errors="replace").replace("\r", "\n").splitlines() if line.strip()][-1:]
            raise BenchError(f"{pathlib.Path(command[0]).name} failed with code {done.returncode}: {' '.join(last)} (log: {path})")
        return done.stdout

    def json_lines(self, log, command):
        """Runs a bench program with --json FILE behind its arguments and reads that file."""
        path = self.work / f"{log}.jsonl"
        path.unlink(missing_ok=True)
        self.run(log, [*command, "--json", path])
        return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


@dataclasses.dataclass
class Bench:
    name: str
    group: str  # quick, long, gpu, unseen or browser
    minutes: float  # duration on two idle cores
    about: str
    command: str  # as a person would type it, for the page
    programs: tuple
    take: object  # function from Place to rows


# ---- frames

def with_passes(lines):
    """The bench prints a line a renderer and a line a pass; here the passes lie in their renderer's row."""
    rows, by_device = [], {}
    for line in lines:
        key = line.get("case"), line.get("device")
        if "pass" in line:
            by_device[key].setdefault("pass_gpu_ms", {})[line["pass"]] = line["gpu_ms_p50"]
        else:
            rows.append(line)
            by_device[key] = line
    return rows


def take_speed_error(place):
    return with_passes(place.json_lines("speed-error", [place.program("doppel"), "bench", place.avatar(), "--repeats", place.repeats]))


def take_baselines(place):
    return with_passes(place.json_lines("baselines", [place.program("bench_frames"), place.avatar(), "--repeats", place.repeats]))


def blown_up(place, splats):
    big = place.work / f"{splats}.glb"
    if not big.exists():
        place.run(f"blow-up-{splats}", [place.program("bench_load"), place.avatar(), splats, 1, big])
    return big


def take_baselines_large(place):
    command = [place.program("bench_frames"), blown_up(place, 533695), "--no-reference", "--repeats", place.repeats]
    return with_passes(place.json_lines("baselines-large", command))


SCALING = (60000, 133000, 267000, 533695, 1000000, 2000000)


def scaling(place, name, sizes, options):
    rows = []
    for splats in sizes:
        big = blown_up(place, splats)
        command = [place.program("doppel"), "bench", big, "--no-reference", *options]
        rows += [row for row in place.json_lines(f"{name}-{splats}", command) if "pass" not in row]
        if splats != 533695:
            big.unlink()
    return rows


def take_scaling(place):
    return scaling(place, "scaling", SCALING, ["--repeats", 5])


# ---- the same on a GPU

def needs_gpu(place):
    """Skips on machines whose only Vulkan device is a driver on the CPU."""
    command = [place.program("doppel"), "bench", place.avatar(), "--no-reference", "--renderers", "vulkan-tiles", "--repeats", 1]
    rows = place.json_lines("gpu-device", command)
    device = rows[0]["device"] if rows else "no Vulkan device"
    if not rows or machine.is_software(device):
        raise Skipped(f"needs a GPU; here is {device}")


def take_gpu_frames(place):
    needs_gpu(place)
    return with_passes(place.json_lines("gpu-frames", [place.program("doppel"), "bench", place.avatar(), "--repeats", 101]))


def take_gpu_scaling(place):
    needs_gpu(place)
    return scaling(place, "gpu-scaling", (60000, 533695, 2000000), ["--renderers", "vulkan-quads", "vulkan-tiles", "--repeats", 21])


def take_gpu_writes(place):
    needs_gpu(place)
    return take_writes(place)


def take_gpu_ways(place):
    needs_gpu(place)
    return take_ways(place)


# ---- loading, memory, level of detail

LOAD_BARS = {"load_ms": at_most(500), "peak_ratio": at_most(1.2), "splat_share": at_most(0.08), "avatar_share": at_most(0.14)}


def take_load(place):
    rows = []
    for degree, encoding in ((1, ""), (3, ""), (1, "compact")):
        command = [place.program("bench_load"), place.avatar(), 533695, degree, "-", *([encoding] if encoding else [])]
        for row in place.json_lines(f"load-{degree}{encoding}", command):
            rows.append({**row, "bars": LOAD_BARS})
    return rows


LIBRARY_PARTS = (("code", (".text", ".plt", ".init", ".fini")), ("tables to unwind the stack", (".eh_frame", ".gcc_except_table")),
                 ("other constants", (".rodata",)), ("variables and relocations", (".data", ".rela", ".got", ".bss")))


def take_library(place):
    """The stripped shared library and the sizes of its parts. The shader pack is the symbol kPack in .rodata."""
    built, stripped = place.program("libdoppel.so"), place.work / "libdoppel-stripped.so"
    place.run("strip", ["strip", "-o", stripped, built])
    total = stripped.stat().st_size
    parts = dict.fromkeys((name for name, _ in LIBRARY_PARTS), 0)
    for line in place.run("readelf", ["readelf", "-SW", stripped]).splitlines():
        words = line.replace("[ ", "[").split()
        if len(words) < 6 or not words[0].startswith("[") or words[2] == "NOBITS":
            continue
        for name, starts in LIBRARY_PARTS:
            if words[1].startswith(starts):
                parts[name] += int(words[5], 16)
                break
    symbols = place.run("nm", ["nm", "-S", "--defined-only", built]).splitlines()
    shaders = sum(int(line.split()[1], 16) for line in symbols if "kPack" in line)
    parts["other constants"] -= shaders
    parts["shaders, compressed"] = shaders
    parts["names and the rest"] = total - sum(parts.values())
    rows = [{"part": "all", "bytes": total, "bars": {"bytes": at_most(3e6)}}]
    return rows + [{"part": name, "bytes": size, "bars": {}} for name, size in sorted(parts.items(), key=lambda item: -item[1])]


INSIDE_BARS = {"thread_ms": at_most(0.2), "allocations": at_most(0), "pixel_bytes": at_most(0), "psnr_db": at_least(50)}


def take_ways(place):
    rows = place.json_lines("ways", [place.program("bench_ways"), place.avatar(), 60])
    return [{**row, "bars": INSIDE_BARS if row["pixel_bytes"] == 0 else {}} for row in rows]


def take_writes(place):
    """The bar is the CPU's: with one colour as much as pose and projection of the same frame, with SH twice as much."""
    rows = place.json_lines("writes", [place.program("bench_writes"), place.avatar(), 60])
    return [{**row, "bars": {"ratio": at_most(2 if row["layout"].startswith("SH") else 1)} if row["by"] == "dplWriteSplats" else {}}
            for row in rows]


HOST_BARS = {"thread_ms": at_most(0.2), "allocations": at_most(0)}


def take_host(place):
    """Commands that go nowhere leave Doppel's own code alone, which the bars are for."""
    rows = place.json_lines("host", [place.program("bench_host"), place.avatar(), 40])
    return [{**row, "bars": {**(HOST_BARS if row["commands_to"] == "nowhere" else {}),
                             **({"psnr_db": at_least(50)} if row["psnr_db"] is not None else {})}} for row in rows]


DELAY = re.compile(r"elbow at 60 Hz, (.+?) +lags by +(-?[\d.]+) frames; group delay of the filter ([\d.]+) frames")


def take_delay(place):
    """How late the elbow of a tracked person is shown; the test prints it, and fails where a figure leaves its range."""
    out = place.run("delay", [place.program("motion_tracker_test"), "--gtest_filter=*delayOfTheFilter*"])
    rows = [{"stream": stream, "frames": float(frames), "filter_frames": float(of_filter), "bars": {}}
            for stream, frames, of_filter in DELAY.findall(out)]
    if not rows:
        raise BenchError("motion_tracker_test printed no line that begins with 'elbow at 60 Hz'")
    return rows


def take_web(place):
    if not shutil.which("node"):
        raise Skipped("node is not installed")
    return place.json_lines("web", ["tools/prove-web", "--webgl"])


def take_web_three(place):
    if not shutil.which("npm"):
        raise Skipped("npm is not installed")
    return place.json_lines("web-three", ["tools/prove-web", "--three"])


def take_viewers(place):
    if not shutil.which("npm"):
        raise Skipped("npm is not installed")
    return [{**row, "bars": viewer_bars(row)} for row in place.json_lines("viewers", ["tools/prove-viewers", place.avatar()])]


def take_viewers_live(place):
    if not shutil.which("npm"):
        raise Skipped("npm is not installed")
    return [{**row, "bars": {"worst_below_db": at_most(0.5)}} for row in place.json_lines("viewers-live", ["tools/prove-viewers", place.avatar(), "--live"])]


def viewer_bars(row):
    """Exported splats in viewers that draw them by the same rules but for the low-pass and the gate."""
    least = {"playcanvas": 40, "babylon": 40, "spark": 36}.get(row["viewer"])
    if "cannot" in row or row["kind"] != "splats" or row["stands"] != "upright" or least is None:
        return {}
    return {"sides_db": at_least(least), "sides_patch": at_most(8)}


def take_load_frames(place):
    rows = place.json_lines("load-frames", [place.program("bench_load_frames"), 500000])
    return [{**row, "bars": {}} for row in rows]


STEADY = re.compile(r"load x3, (\d+) % of a frame fixed, time known after (\d+) frames: steady after (\d+) frames, "
                    r"all splats back (\d+) frames")
STEADY_FIELDS = "fixed_percent", "latency_frames", "steady_frames", "back_frames"


def take_steady(place):
    """The governor of the frame budget on simulated devices whose load trebles for 90 frames; its test prints the figures."""
    out = place.run("steady", [place.program("visibility_governor_test"), "--gtest_filter=*TreblesForASecond*"])
    rows = [dict(zip(STEADY_FIELDS, map(int, found))) for found in STEADY.findall(out)]
    if not rows:
        raise BenchError("visibility_governor_test printed no line that begins with [ STEADY   ]")
    return [{**row, "bars": {"steady_frames": at_most(30), "back_frames": at_most(160)}} for row in rows]


def take_detail(place):
    rows = []
    for subject, fill in ((place.avatar(), "software"), (blown_up(place, 533695), "tiles")):
        rows += place.json_lines(f"detail-{fill}", [place.program("bench_detail"), subject, 12, 5, fill])
    return rows


def take_floor(place):
    proto = place.shared / "research/proto-splat"
    if not (proto / "floor.cpp").exists():
        raise Skipped(f"{proto}/floor.cpp is not there")
    script = ["env", f"DOPPEL_FLOOR_DIR={place.work / 'floor'}", "DOPPEL_FLOOR_BAR=100", place.root / "tools/bench/floor_compare.sh"]
    rows = place.json_lines("floor", [*script, place.program("bench_splat"), proto, 5])
    return [{**row, "bars": {"ratio": at_most(1.2)} if row["step"] == "total-median" else {}} for row in rows]


# ---- quality

REGISTRATION = {"keypoints_mean_mm": "keypoints_mean", "keypoints_p95_mm": "keypoints_p95",
                "limbs_median_deg": "limbs_median", "limbs_p95_deg": "limbs_p95"}


def sample(place, seed):
    folder = place.work / f"scan-{seed}"
    if not (folder / "scan.json").exists():
        shutil.rmtree(folder, ignore_errors=True)
        place.run(f"scan-{seed}", [place.program("doppel"), "sample", "-o", folder, "--seed", seed])
    return folder


def data(place, name):
    folder = place.shared / "data" / name
    if not folder.exists():
        raise Skipped(f"{folder} is not there")
    return folder


def makehuman(place):
    body = place.work / "makehuman.glb"
    if not body.exists():
        place.run("makehuman", [place.program("doppel"), "body", "import", data(place, "body-makehuman"), "-o", body])
    return body


def reconstruct(place, name, scan, options):
    """Continues where a run that was cut off stopped: the stages that are done are not run again."""
    place.run(name, [place.program("doppel"), "reconstruct", scan, "-o", place.work / name, *options])
    return json.loads((place.work / name / "report.json").read_text(encoding="utf-8"))


def reported(report, key):
    """The figure of a report with this key, or None."""
    return next((f for f in report["figures"] if f["key"] == key), None)


def figure(report, key):
    found = reported(report, key)
    return found["value"] if found else None


def bars_of(figures):
    """The bars that a report states, by field. `figures`: the report's figure of each field."""
    return {field: at_least(f["bar"]["at_least"]) if "at_least" in f["bar"] else at_most(f["bar"]["at_most"])
            for field, f in figures.items() if "bar" in f}


def quality_rows(report, bars):
    """Of a report: means of the held-out frames, registration, training, file, stages, evidence and every held-out frame."""
    rows = []
    for kind, means in report["means"].items():
        fit, plain = means["with_pose_fit"], means["without_pose_fit"]
        labels, colours = means["floor_flat_labels"]["masked_psnr_db"], means["floor_vertex_colours"]["masked_psnr_db"]
        above = next(f for f in report["above_floors"] if f["key"] == f"above_floor.{kind}")
        row = {"row": "held out", "kind": kind, "psnr_db": fit["masked_psnr_db"], "psnr_without_pose_fit_db": plain["masked_psnr_db"],
               "iou": fit["alpha_iou"], "iou_without_pose_fit": plain["alpha_iou"], "ssim": fit["masked_ssim"],
               "floor_labels_db": labels, "floor_vertex_colours_db": colours, "above_floors_db": above["value"],
               "full_psnr_db": fit["full_psnr_db"], "full_ssim": fit["full_ssim"]}
        rows.append({**row, "bars": {**bars.get(kind, {}), **bars_of({"above_floors_db": above})}})
    for stage, after in (("body_fit", "after the body fit"), ("pose_fit", "after training and pose fit")):
        found = {field: reported(report, f"truth.{stage}.{part}") for field, part in REGISTRATION.items()}
        if all(found.values()):
            rows.append({"row": "registration", "after": after, **{field: f["value"] for field, f in found.items()}, "bars": bars_of(found)})
    rows.append({"row": "training", "step_ms": figure(report, "training_step.ms"), "pairs": figure(report, "training_step.pairs"),
                 "forward_ns": figure(report, "training_step.forward_ns"), "backward_ns": figure(report, "training_step.backward_ns"),
                 "bars": bars.get("training", {})})
    rows.append({"row": "file", "splats": int(report["facts"]["splats"]), "bytes": figure(report, "file.bytes"),
                 "bytes_a_splat": figure(report, "file.bytes_a_splat"), "body": report["facts"]["body"],
                 "training": report["facts"]["training"], "scan": report["facts"]["scan"]})
    rows += [{"row": "stage", **{key: s[key] for key in ("name", "seconds", "peak_bytes", "reused")}} for s in report["stages"]]
    rows += [{"row": "evidence", **{key: e[key] for key in ("part", "kept", "gain_db", "bytes")}} for e in report["evidence"]]
    rows += [{"row": "figure", **f} for f in report["figures"]]
    rows += [{"row": "frame", "name": f["name"], "kind": f["kind"], "psnr_db": f["with_pose_fit"]["masked_psnr_db"],
              "psnr_without_pose_fit_db": f["without_pose_fit"]["masked_psnr_db"], "iou": f["with_pose_fit"]["alpha_iou"]}
             for f in report["frames"]]
    return rows


def ladder_rows(report):
    """The ladder of a report: a row a rung and group of frames."""
    return [{"row": "ladder", "rung": r["rung"], "what": r["what"], "kind": kind, "split": split, **cell}
            for r in report["ladder"] for kind in ("static", "dynamic") for split, cell in r.get(kind, {}).items()]


def ladder(name, scan, options):
    """`name`: the bench whose run it is; it is made where it was not."""
    def take(place):
        return ladder_rows(reconstruct(place, name, scan(place), options))
    return take


# Of a report: figure, how to find it, digits, name of its bar.
SEED_FIGURES = (
    ("still, with pose fit, dB", lambda r: r["means"]["static"]["with_pose_fit"]["masked_psnr_db"], 2, "still"),
    ("still, without, dB", lambda r: r["means"]["static"]["without_pose_fit"]["masked_psnr_db"], 2, None),
    ("moving, with pose fit, dB", lambda r: r["means"]["dynamic"]["with_pose_fit"]["masked_psnr_db"], 2, "moving"),
    ("moving, without, dB", lambda r: r["means"]["dynamic"]["without_pose_fit"]["masked_psnr_db"], 2, "moving_unfitted"),
    ("moving, over the union of mask and alpha, dB", lambda r: r["means"]["dynamic"]["with_pose_fit"]["union_psnr_db"], 2, None),
    ("moving, over the union, without, dB", lambda r: r["means"]["dynamic"]["without_pose_fit"]["union_psnr_db"], 2, None),
    ("moving, uncovered mask, %", lambda r: 100 * r["means"]["dynamic"]["with_pose_fit"]["uncovered"], 2, "uncovered"),
    ("moving, drawn outside the mask, %", lambda r: 100 * r["means"]["dynamic"]["with_pose_fit"]["drawn_outside"], 2, "outside"),
    ("true poses, points of the top over plain skinning", lambda r: figure(r, "garment.top.point_distance_ratio"), 3, "top"),
    ("true poses, points of the bottom over plain skinning", lambda r: figure(r, "garment.bottom.point_distance_ratio"), 3, "bottom"),
)


def seed_rows(reports, bars):
    """A row a figure, with its value in the report of each seed, their mean and standard deviation."""
    rows = []
    for what, value_in, digits, bar in SEED_FIGURES:
        values = [value_in(r) for r in reports]
        if None not in values:
            rows.append({"row": "seeds", "figure": what, "digits": digits, "values": values, "mean": statistics.mean(values),
                         "sigma": statistics.stdev(values), "bars": {"mean": bars[bar]} if bar in bars else {}})
    return rows


def seeds(name, folder, options, bars):
    """Training seeds 1, 2 and 3. `name`: the bench whose run seed 1 is. Stages before training hear no seed, so the others take them over."""
    def take(place):
        scan, reports = data(place, folder), []
        for seed in (1, 2, 3):
            run = name if seed == 1 else f"{name}-seed-{seed}"
            out = place.work / run
            if seed > 1 and not (out / "stages").exists():
                out.mkdir(parents=True, exist_ok=True)
                shutil.copytree(place.work / name / "stages", out / "stages.partial", dirs_exist_ok=True)
                (out / "stages.partial").rename(out / "stages")
            reports.append(reconstruct(place, run, scan, [*options, "--seed", seed]))
        return seed_rows(reports, bars)
    return take


def bars_on_scan(static, dynamic, dynamic_unfitted):
    return {"static": {"psnr_db": at_least(static)}, "training": {"step_ms": at_most(40)},
            "dynamic": {"psnr_db": at_least(dynamic), "psnr_without_pose_fit_db": at_least(dynamic_unfitted)}}


SCAN_A_BARS, SCAN_C_BARS = bars_on_scan(26.5, 24, 22), bars_on_scan(24.5, 19, 17)
SEED_BARS_A = {"still": at_least(26.7), "moving": at_least(23), "moving_unfitted": at_least(20.8), "top": at_most(0.7), "bottom": at_most(0.65)}
SEED_BARS_C = {"still": at_least(25.0), "moving": at_least(18), "moving_unfitted": at_least(16), "uncovered": at_most(2), "outside": at_most(1.5),
               "bottom": at_most(0.85)}
SEED_BARS_MOTION = {"moving_unfitted": at_least(17), "bottom": at_most(0.5)}
BIKER_BARS = {"static": {"psnr_without_pose_fit_db": at_least(22), "iou_without_pose_fit": at_least(0.95)}}


def procedural(seed, name, body=None):
    def take(place):
        options = ["--preset", "draft"] + (["--body", body(place)] if body else [])
        return quality_rows(reconstruct(place, name, sample(place, seed), options), {})
    return take


WALKS = ("02_01", "05_01", "07_01", "scaled_131_01")
WALK_BARS = {"garment_vertices_inside_body": at_most(0.01), "edges_stretched_over_2": at_most(0), "skin_in_garment_pixels": at_most(0.005)}


def walk_rows(place, name):
    """How the clothes of a finished avatar fare in recorded walks."""
    rows = []
    for walk in WALKS:
        clip = data(place, "mocap-cmu") / f"{walk}.bvh"
        printed = place.run(f"{name}-{walk}", [place.program("doppel"), "inspect", place.work / name / "avatar.glb", "--clip", clip, "--json"])
        found = json.loads(printed)
        rows.append({"row": "walk", **found, "clip": walk, "bars": WALK_BARS})
    return rows


def real(name, folder, bars, options=lambda place: [], walks=False):
    def take(place):
        rows = quality_rows(reconstruct(place, name, data(place, folder), options(place)), bars)
        return rows + walk_rows(place, name) if walks else rows
    return take


def take_2k(place):
    """A scan with as many pixels as a phone's video, and a test chart on its shirt, by `high` within 75 minutes."""
    scan = place.work / "scan-2k"
    if not (scan / "scan.json").exists():
        shutil.rmtree(scan, ignore_errors=True)
        place.run("scan-2k", [place.program("doppel"), "sample", "-o", scan, "--size", "1080x1440", "--chart"])
    return quality_rows(reconstruct(place, "quality-2k", scan, ["--preset", "high", "--time-budget", 75]), {})


def take_frames_2k(place):
    avatar = place.work / "quality-2k/avatar.glb"
    if not avatar.exists():
        raise Skipped(f"needs {avatar}, which the bench quality-2k makes")
    return with_passes(place.json_lines("frames-2k", [place.program("doppel"), "bench", avatar, "--repeats", place.repeats]))


def take_cores(place):
    """The same run with one thread and with two: seconds of each stage, milliseconds of a training step."""
    scan, found = sample(place, 1), {}
    for threads in (1, 2):
        report = reconstruct(place, f"cores-{threads}", scan, ["--preset", "draft", "--threads", threads])
        for stage in report["stages"]:
            if stage["reused"]:
                raise BenchError(f"the stage {stage['name']} was not run anew: use --again")
            found.setdefault((stage["name"], "s"), []).append(stage["seconds"])
        found.setdefault(("a training step", "ms"), []).append(figure(report, "training step", "step"))
    return [{"what": what, "unit": unit, "one_thread": times[0], "two_threads": times[1]} for (what, unit), times in found.items()]


def take_steps(place):
    return place.json_lines("steps", [place.program("doppel"), "bench", "training", "--warm-up", 24, "--steps", 24])


def take_steps_2k(place):
    return place.json_lines("steps-2k", [place.program("doppel"), "bench", "training", "--size", "1080x1440", "--splats", 300000, "--warm-up", 6,
                                         "--steps", 12])


DOPPEL = ("doppel",)
SEEDS = "doppel reconstruct ../shared/data/{0} -o OUT --preset {1} --seed N"
DRAFT = "doppel sample -o scan --seed {0} && doppel reconstruct scan -o OUT --preset draft"

BENCHES = [
    Bench("quality-procedural-1", "quick", 7, "the procedural subject of seed 1, the demo's", DRAFT.format(1), DOPPEL,
          procedural(1, "quality-procedural-1")),
    Bench("quality-procedural-1-makehuman", "quick", 6, "the same scan with the MakeHuman body",
          "doppel body import ../shared/data/body-makehuman -o makehuman.glb && doppel reconstruct scan -o OUT --preset draft --body makehuman.glb",
          DOPPEL, procedural(1, "quality-procedural-1-makehuman", makehuman)),
    Bench("speed-error", "quick", 0.5, "frames of what users can choose, against the double-precision referee",
          "doppel bench demo/avatar/avatar.glb --repeats 9", DOPPEL, take_speed_error),
    Bench("baselines", "quick", 2, "today's frames beside the frozen plain frame",
          "build/release/tools/bench/frames/bench_frames demo/avatar/avatar.glb --repeats 9", ("bench_frames",), take_baselines),
    Bench("baselines-large", "quick", 4, "the same with 533,695 splats, without the referee",
          "build/release/tools/bench/frames/bench_frames big.glb --no-reference --repeats 9", ("bench_frames", "bench_load"), take_baselines_large),
    Bench("steps", "quick", 0.5, "training steps by part, on the procedural subject", "doppel bench training --warm-up 24 --steps 24", DOPPEL,
          take_steps),
    Bench("steps-2k", "quick", 1, "the same in pictures of 1080 x 1440 with 300,000 splats",
          "doppel bench training --size 1080x1440 --splats 300000 --warm-up 6 --steps 12", DOPPEL, take_steps_2k),
    Bench("load", "quick", 0.5, "loading and memory of 533,695 splats",
          "build/release/tools/bench/bench_load demo/avatar/avatar.glb 533695 1", ("bench_load",), take_load),
    Bench("library", "quick", 0.1, "size of the stripped libdoppel.so and of its parts", "strip -o stripped.so build/release/sdk/api/libdoppel.so",
          ("libdoppel.so",), take_library),
    Bench("ways", "quick", 1, "what each way into a Vulkan program's image costs",
          "build/release/tests/unit/interop/bench_ways demo/avatar/avatar.glb 60", ("bench_ways",), take_ways),
    Bench("writes", "quick", 0.5, "what it costs to write posed splats into a program's buffer, on the CPU and on its GPU",
          "build/release/tests/unit/interop/bench_writes demo/avatar/avatar.glb 60", ("bench_writes",), take_writes),
    Bench("host", "quick", 3, "what a frame costs the calling thread before the GPU gets it, through Metal and Vulkan",
          "build/release/tests/metal/bench_host demo/avatar/avatar.glb 40", ("bench_host",), take_host),
    Bench("delay", "quick", 0.1, "how late a tracked person is shown",
          "build/release/tests/unit/motion/motion_tracker_test --gtest_filter='*delayOfTheFilter*'", ("motion_tracker_test",), take_delay),
    Bench("web", "browser", 6, "WebGL2 in headless Chromium, by SwiftShader", "tools/prove-web --webgl", (), take_web),
    Bench("web-three", "browser", 6, "scenes of three.js, and other renderers of splats, in headless Chromium", "tools/prove-web --three", (),
          take_web_three),
    Bench("viewers", "browser", 10, "exported files in other people's viewers, in headless Chromium", "tools/prove-viewers demo/avatar/avatar.glb", (), take_viewers),
    Bench("viewers-live", "browser", 12, "live persons among the splats of other engines, in headless Chromium", "tools/prove-viewers demo/avatar/avatar.glb --live", (),
          take_viewers_live),
    Bench("load-frames", "quick", 0.5, "the longest frame while 500,000 splats load", "build/release/tools/bench/bench_load_frames 500000",
          ("bench_load_frames",), take_load_frames),
    Bench("steady", "quick", 0.1, "frames until a frame budget holds, on simulated devices",
          "build/release/tests/unit/visibility/visibility_governor_test --gtest_filter='*TreblesForASecond*'",
          ("visibility_governor_test",), take_steady),
    Bench("detail", "quick", 1.5, "level of detail against distance",
          "build/release/tools/bench/bench_detail demo/avatar/avatar.glb 12 5 software", ("bench_detail", "bench_load"), take_detail),
    Bench("scaling", "quick", 3, "frame time against the number of splats", "doppel bench BIG.glb --no-reference --repeats 5",
          ("doppel", "bench_load"), take_scaling),
    Bench("floor", "quick", 1, "the CPU renderer against the research floor program",
          "tools/bench/floor_compare.sh build/release/tools/bench/bench_splat", ("bench_splat",), take_floor),
    Bench("quality-scan-a", "long", 8, "scan-a, preset standard", "doppel reconstruct ../shared/data/scan-a -o OUT", DOPPEL,
          real("quality-scan-a", "scan-a", SCAN_A_BARS, walks=True)),
    Bench("quality-scan-a-makehuman", "long", 8, "scan-a with the MakeHuman body",
          "doppel reconstruct ../shared/data/scan-a -o OUT --body makehuman.glb", DOPPEL,
          real("quality-scan-a-makehuman", "scan-a", SCAN_A_BARS, lambda place: ["--body", makehuman(place)])),
    Bench("quality-2k", "long", 75, "1080 x 1440, a test chart on the shirt, preset high within 75 minutes",
          "doppel sample -o SCAN --size 1080x1440 --chart && doppel reconstruct SCAN -o OUT --preset high --time-budget 75", DOPPEL, take_2k),
    Bench("frames-2k", "long", 5, "the avatar of quality-2k in the pictures of a phone and a headset", "doppel bench AVATAR", DOPPEL, take_frames_2k),
    Bench("quality-scan-c", "long", 8, "scan-c, preset standard", "doppel reconstruct ../shared/data/scan-c -o OUT", DOPPEL,
          real("quality-scan-c", "scan-c", SCAN_C_BARS, walks=True)),
    Bench("cores", "long", 7, "reconstruction with one thread and with two",
          "doppel sample -o scan --seed 1 && doppel reconstruct scan -o OUT --preset draft --threads 1", DOPPEL, take_cores),
    Bench("quality-biker", "long", 8, "a real man holding a helmet, one pose, keypoints by the networks",
          "doppel reconstruct ../shared/data/real-orbit-biker -o OUT --models ../shared/data/models", DOPPEL,
          real("quality-biker", "real-orbit-biker", BIKER_BARS, lambda place: ["--models", data(place, "models")])),
    Bench("ladder-procedural-1", "long", 0.1, "what the truth in place of a stage gains: the run of quality-procedural-1", DRAFT.format(1), DOPPEL,
          ladder("quality-procedural-1", lambda place: sample(place, 1), ["--preset", "draft"])),
    Bench("ladder-scan-a", "long", 0.1, "the same for the run of quality-scan-a", "doppel reconstruct ../shared/data/scan-a -o OUT", DOPPEL,
          ladder("quality-scan-a", lambda place: data(place, "scan-a"), [])),
    Bench("ladder-scan-c", "long", 0.1, "the same for the run of quality-scan-c", "doppel reconstruct ../shared/data/scan-c -o OUT", DOPPEL,
          ladder("quality-scan-c", lambda place: data(place, "scan-c"), [])),
    Bench("seeds-scan-a", "long", 25, "scan-a with three training seeds", SEEDS.format("scan-a", "standard"), DOPPEL,
          seeds("quality-scan-a", "scan-a", [], SEED_BARS_A)),
    Bench("seeds-scan-c", "long", 25, "scan-c with three training seeds", SEEDS.format("scan-c", "standard"), DOPPEL,
          seeds("quality-scan-c", "scan-c", [], SEED_BARS_C)),
    Bench("seeds-scan-c-motion", "long", 20, "scan-c-motion, 24 pictures a second, with three training seeds", SEEDS.format("scan-c-motion", "draft"),
          DOPPEL, seeds("seeds-scan-c-motion", "scan-c-motion", ["--preset", "draft"], SEED_BARS_MOTION)),
    Bench("gpu-frames", "gpu", 1, "frames on a GPU, every renderer in turn, against the double-precision referee",
          "doppel bench demo/avatar/avatar.glb --repeats 101", DOPPEL, take_gpu_frames),
    Bench("gpu-scaling", "gpu", 0.7, "frame time on a GPU against the number of splats",
          "doppel bench BIG.glb --no-reference --renderers vulkan-quads vulkan-tiles --repeats 21", ("doppel", "bench_load"),
          take_gpu_scaling),
    Bench("gpu-ways", "gpu", 0.3, "what each way into a Vulkan program's image costs on a GPU",
          "build/release/tests/unit/interop/bench_ways demo/avatar/avatar.glb 60", ("bench_ways",), take_gpu_ways),
    Bench("gpu-writes", "gpu", 0.2, "what it costs to write posed splats into a program's buffer on a GPU",
          "build/release/tests/unit/interop/bench_writes demo/avatar/avatar.glb 60", ("bench_writes",), take_gpu_writes),
] + [
    Bench(f"quality-procedural-{seed}", "unseen", 7, f"the procedural subject of seed {seed}, which nobody looked at", DRAFT.format(seed),
          DOPPEL, procedural(seed, f"quality-procedural-{seed}"))
    for seed in range(4, 10)
]
