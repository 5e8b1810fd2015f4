# SPDX-License-Identifier: Apache-2.0
"""The pages about avatars made from scans: quality, the ladder, the method's reports, reconstruction."""
import statistics

from .markdown import NOTHING, barred, number, table, taken
from .sections import BACK, find, missing_of, section

DEVELOPMENT = (("quality-procedural-1", "procedural seed 1 (the demo's)"), ("quality-procedural-1-makehuman", "procedural seed 1, MakeHuman body"),
               ("quality-scan-a", "scan-a"), ("quality-scan-a-makehuman", "scan-a, MakeHuman body"), ("quality-scan-c", "scan-c"),
               ("quality-biker", "biker"), ("quality-2k", "procedural seed 1, 1080 × 1440"))
UNSEEN = tuple((f"quality-procedural-{seed}", f"procedural seed {seed}") for seed in range(4, 10))


HELD_OUT = ["scan, frames", "masked PSNR dB", "without pose fit", "alpha IoU", "without pose fit", "masked SSIM", "dB above the better floor",
            "full frame on white, PSNR dB", "SSIM"]


def held_out_rows(store, names):
    out = []
    for name, label in names:
        for row in (r for r in store.rows(name) if r["row"] == "held out"):
            out.append([f"{label}, {row['kind']}", barred(row, "psnr_db"), barred(row, "psnr_without_pose_fit_db"), barred(row, "iou", 4),
                        barred(row, "iou_without_pose_fit", 4), barred(row, "ssim", 3), barred(row, "above_floors_db"),
                        barred(row, "full_psnr_db"), barred(row, "full_ssim", 3)])
    return out


REGISTRATION = ["scan", "when", "keypoints, mean mm", "95th percentile mm", "limb directions, median °", "95th percentile °"]


def registration_rows(store, names):
    return [[label, row["after"], barred(row, "keypoints_mean_mm", 1), barred(row, "keypoints_p95_mm", 1), barred(row, "limbs_median_deg", 2),
             barred(row, "limbs_p95_deg", 1)]
            for name, label in names for row in store.rows(name) if row["row"] == "registration"]


COST = ["scan", "training", "body", "splats", "file, MB", "bytes a splat", "minutes", "peak memory, MiB", "training step, ms", "pairs a step",
        "forward, ns a pair", "backward, ns a pair"]


def cost_rows(store, names):
    out = []
    for name, label in names:
        rows = store.rows(name)
        file, training, stages = find(rows, row="file"), find(rows, row="training"), [r for r in rows if r["row"] == "stage"]
        if not file:
            continue
        seconds = sum(s["seconds"] for s in stages)
        out.append([label, file["training"], file["body"], number(file["splats"], 0), number(file["bytes"] / 1e6),
                    number(file["bytes_a_splat"], 1), number(seconds / 60, 1), number(max(s["peak_bytes"] for s in stages) / 2**20, 0),
                    barred(training, "step_ms", 1), number(training["pairs"], 0), number(training["forward_ns"], 1),
                    number(training["backward_ns"], 1)])
    return out


def spread(store, names, row_name, field, **wanted):
    """(mean, standard deviation, count) of a figure over several scans, or None."""
    values = [r[field] for name, _ in names for r in [find(store.rows(name), row=row_name, **wanted)] if r and r.get(field) is not None]
    if not values:
        return None
    return statistics.mean(values), statistics.stdev(values) if len(values) > 1 else 0.0, len(values)


def spread_text(found, digits, unit):
    return f"{number(found[0], digits)} ± {number(found[1], digits)} {unit}" if found else NOTHING


def evidence_rows(store, names):
    """Parts that were judged. Garment layers follow the labels; a gain of exactly 0 was not measured."""
    return [[label, row["part"], "yes" if row["kept"] else "no", number(row["gain_db"]), number(row["bytes"] / 1000, 0)]
            for name, label in names for row in store.rows(name) if row["row"] == "evidence" and row["gain_db"] != 0]


WALK = ["scan, walk", "garment vertices inside the body, %", "edges stretched over 2 ×, %", "longest stretch", "skin that shows through, % of the garments' pixels"]


def walk_rows(store, names):
    return [[f"{label}, {row['clip']}", barred(row, "garment_vertices_inside_body", 2, scale=100), barred(row, "edges_stretched_over_2", 3, scale=100),
             number(row["longest_stretch"], 1), barred(row, "skin_in_garment_pixels", 2, scale=100)]
            for name, label in names for row in store.rows(name) if row["row"] == "walk"]


SEEDS = (("seeds-scan-a", "scan-a"), ("seeds-scan-c", "scan-c, a skirt"), ("seeds-scan-c-motion", "scan-c-motion, a skirt at 24 pictures a second"))


def seeds(store):
    text = ("## Three training seeds\n\nHow far figures differ by chance, on held-out frames: the seed changes the training alone. Differences of "
            "one run below 2√2 σ are chance.\n\n")
    for name, label in SEEDS:
        rows = store.rows(name)
        if not rows:
            continue
        body = [[r["figure"], *(number(v, r["digits"]) for v in r["values"]), barred(r, "mean", r["digits"]), number(r["sigma"], r["digits"])]
                for r in rows]
        text += f"### {label}\n\n" + table(["figure", *(f"seed {k + 1}" for k in range(len(rows[0]["values"]))), "mean", "σ"], body) + "\n"
        text += taken(store.get(name)) + "\n"
    return text + missing_of(store, SEEDS)


def taken_all(store, names):
    return "".join(f"- {label}: {taken(store.get(name), '  ')}" for name, label in names if store.get(name))


def two_k(rows):
    """Fine print in held-out close-ups."""
    bars = [r for r in rows if r["row"] == "figure" and r["key"].startswith("bars.")]
    detail = [r for r in rows if r["row"] == "figure" and r["key"].startswith("detail.")]
    text = "Contrast that held-out close-ups keep of bars printed on the shirt; widths that the photograph itself does not show are left out.\n\n"
    text += table(["bars", "contrast kept"], [[r["name"], number(r["value"], 3)] for r in bars]) + "\n"
    return text + table(["fine detail, drawn at twice the size", "correlation"], [[r["group"].split(", ")[1] + ", " + r["name"], number(r["value"], 3)] for r in detail]) + "\n"


def quality(store):
    text = BACK + (
        "# Quality\n\nHeld-out frames, drawn by the finished avatar; nothing of them is in it. Masked figures use the picture's own alpha and take the "
        "worst of white, black and grey backgrounds. *Static* frames hold one pose; *dynamic* frames are of a moving subject. *Floors*: flat "
        "colours of the segmentation, and vertex colours on the same mesh. *Pose fit* adjusts the pose of each held-out frame to its picture; "
        "the columns without it say how good the avatar is in a pose that was not fitted to the picture.\n\n"
        "## Development set\n\nWe look at these scans while we work, and constants are tuned on them.\n\n"
        "The procedural subject is made from the built-in body, and the same body is then fitted to it, which improves its figures. The row "
        "with the MakeHuman body fits another body to the same scan.\n\n")
    rows = held_out_rows(store, DEVELOPMENT)
    text += (table(HELD_OUT, rows) + "\n" if rows else "") + missing_of(store, DEVELOPMENT)
    text += ("Distance of fitted joints to the true ones, on held-out dynamic frames. Trust the figure *after the body fit*: *after "
             "training and pose fit*, each pose was fitted to the held-out picture itself.\n\n")
    text += table(REGISTRATION, registration_rows(store, DEVELOPMENT)) + "\n"
    walks = walk_rows(store, DEVELOPMENT)
    if walks:
        text += ("Clothes in recorded walks of other people ([definition](../reference/metrics.md)), poses that the avatar was not trained in.\n\n" +
                 table(WALK, walks) + "\n")
    text += seeds(store)
    text += section(store, "quality-2k", "A scan of 1080 × 1440 pixels", two_k)
    text += "## What nobody looked at\n\nProcedural subjects that no code was tuned on, preset draft.\n\n"
    rows = held_out_rows(store, UNSEEN)
    if rows:
        text += table(HELD_OUT, rows) + "\n"
        summary = []
        for kind in ("static", "dynamic"):
            found = spread(store, UNSEEN, "held out", "psnr_db", kind=kind)
            if found:
                summary.append([f"{kind}, {found[2]} subjects", spread_text(found, 2, "dB"),
                                spread_text(spread(store, UNSEEN, "held out", "psnr_without_pose_fit_db", kind=kind), 2, "dB"),
                                spread_text(spread(store, UNSEEN, "held out", "iou", kind=kind), 4, "")])
        text += table(["mean ± standard deviation", "masked PSNR", "without pose fit", "alpha IoU"], summary) + "\n"
        text += table(REGISTRATION, registration_rows(store, UNSEEN)) + "\n"
    text += missing_of(store, UNSEEN)
    everything = DEVELOPMENT + UNSEEN
    text += ("## What the parts are worth\n\nMasked PSNR with the part, less that without it, over the frames that decide. "
             "Garments become layers where a scan has labels; that is not judged.\n\n")
    text += table(["scan", "part", "kept", "gain, dB", "kB"], evidence_rows(store, everything)) + "\n"
    return text + "## How these figures were taken\n\n" + taken_all(store, everything)


LADDERS = (("ladder-procedural-1", "procedural seed 1"), ("ladder-scan-a", "scan-a"), ("ladder-scan-c", "scan-c"))


def ladder(store):
    text = BACK + ("# The ladder\n\nMasked PSNR in dB while the truth takes the place of one stage after the other, in the runs of "
                   "[quality](quality.md); nothing is trained again. In brackets: mean distance of the avatar's vertices from where the true surface would carry them, mm. "
                   "[Definition](../reference/metrics.md).\n\n")
    for name, label in LADDERS:
        file = store.get(name)
        if not file:
            continue
        rows = file["rows"]
        groups = list(dict.fromkeys((r["kind"], r["split"], r["frames"]) for r in rows if r["rung"] == "as_is"))
        body = []
        for rung in dict.fromkeys(r["rung"] for r in rows):
            line = [find(rows, rung=rung)["what"]]
            for kind, split, _ in groups:
                cell = find(rows, rung=rung, kind=kind, split=split)
                far = f" ({number(cell['surface_mm'], 0)})" if cell and cell.get("surface_mm") is not None else ""
                line.append(number(cell["masked_psnr_db"]) + far if cell else NOTHING)
            body.append(line)
        text += f"## {label}\n\n" + table(["rung", *(f"{kind}, {split} ({count})" for kind, split, count in groups)], body) + "\n"
        text += taken(file) + "\n"
    return text + missing_of(store, LADDERS)


CORES = (4, 8, 16, 32)


def cores(rows):
    """Times on more cores, by Amdahl's law from one and two threads. What two threads do not make faster counts as serial."""
    body = []
    for row in rows:
        one, two = row["one_thread"], row["two_threads"]
        serial = min(1.0, max(0.0, 2 * two / one - 1)) if one > 0 else 1.0
        body.append([f"{row['what']}, {row['unit']}", number(one, 1), number(two, 1), f"{100 * serial:.0f} %",
                     *(number(one * (serial + (1 - serial) / n), 1) for n in CORES)])
    both = [[r[k] for r in rows if r["unit"] == "s"] for k in ("one_thread", "two_threads")]
    note = (f"All stages together took {number(sum(both[0]) / 60, 1)} minutes with one thread and {number(sum(both[1]) / 60, 1)} with two.\n")
    head = ["stage", "1 thread", "2 threads", "serial share", *(f"{n} cores" for n in CORES)]
    return ("*1 thread* and *2 threads* are measured. The columns of more cores are Amdahl's law with the serial share of the same row; "
            "memory that many cores share is not in it.\n\n" + table(head, body) + "\n" + note)


STEPS = ("The procedural subject in its true poses, every step as slow as the last ones of a run: all splats, pictures at full size. *CPU ms*: of all "
         "threads; on a busy machine it says more than *ms*, the wall time. *Alone*: CPU time of the training thread while the others rest. *MB*: what a "
         "part reads and writes at least once, by the sizes of its arrays.\n\n")


def steps(rows):
    text = ""
    for head in (r for r in rows if "part" not in r):
        text += (f"{head['case']}: {number(head['splats'], 0)} splats, {number(head['pairs'], 0)} pairs, {number(head['entries'], 0)} entries of tile "
                 f"lists, {number(head['vertices'], 0)} vertices, {number(head['threads'], 0)} threads.\n\n")
        body = [[r["part"], number(r["ms"], 2), number(r["cpu_ms"], 2), f"{100 * r['share']:.1f} %", number(r["alone_ms"], 2),
                 number(r["bytes"] / 1e6, 1) if r["bytes"] else NOTHING] for r in rows if r.get("part") and r["case"] == head["case"]]
        body.append(["**a step**", number(head["ms"], 2), number(head["cpu_ms"], 2), "100 %", number(head["alone_ms"], 2),
                     number(sum(r["bytes"] for r in rows if r.get("part") and r["case"] == head["case"]) / 1e6, 1)])
        text += table(["part", "ms", "CPU ms", "share of CPU", "alone, ms", "MB"], body) + "\n"
    return text


def training(store):
    everything = DEVELOPMENT + UNSEEN
    text = BACK + ("# Reconstruction: time, memory, file\n\n*Pairs*: pixels times the splats that touch them, in one training step. *Minutes*: "
                   "all stages together. A step is the mean over the last epoch.\n\n")
    text += table(COST, cost_rows(store, everything)) + "\n"
    stages = list(dict.fromkeys(r["name"] for name, _ in everything for r in store.rows(name) if r["row"] == "stage"))
    body = []
    for name, label in everything:
        rows = {r["name"]: r for r in store.rows(name) if r["row"] == "stage"}
        if rows:
            body.append([label] + [number(rows[s]["seconds"], 1) if s in rows else NOTHING for s in stages])
    text += "Seconds of each stage:\n\n" + table(["scan", *stages], body) + "\n"
    text += section(store, "steps", "A training step by part", lambda rows: STEPS + steps(rows))
    text += section(store, "steps-2k", "A training step by part, at 2K", steps)
    text += section(store, "cores", "On more cores", cores)
    return text + "## How these figures were taken\n\n" + taken_all(store, everything)


SHOWN_ELSEWHERE = ("registration against", "training step", "avatar file")


def reports(store):
    text = BACK + ("# Other figures of the reports\n\nOf the development set: pictures drawn at other sizes than the trained one, keypoint residuals, and pose "
                   "correctives in random poses.\n\n")
    for name, label in DEVELOPMENT:
        rows = [r for r in store.rows(name) if r["row"] == "figure" and not r["group"].startswith(SHOWN_ELSEWHERE)]
        if not rows:
            continue
        text += f"## {label}\n\n"
        for group in dict.fromkeys(r["group"] for r in rows):
            body = [[r["name"], f"{r['value']:.4g} {r['unit']}"] for r in rows if r["group"] == group]
            text += f"{group[:1].upper()}{group[1:]}:\n\n" + table(["of what", "value"], body) + "\n"
        text += taken(store.get(name)) + "\n"
    return text + missing_of(store, DEVELOPMENT)
