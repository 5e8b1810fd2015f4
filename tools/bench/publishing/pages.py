# SPDX-License-Identifier: Apache-2.0
"""One function per page. Every number comes from docs/benchmarks/*.json."""
import pathlib

from . import raw
from .markdown import NOTHING, barred, number, table
from .plot import scatter
from .quality_pages import UNSEEN, spread, spread_text, quality, ladder, training, reports
from .sections import BACK, find, missing, section

GENERATED = "<!-- Written by tools/bench/publish from docs/benchmarks/*.json. Do not edit. -->\n"
PHONE, HEADSET = "phone 945x2048", "headset 1920x1824 stereo"
RENDERERS = {"software": "CPU", "vulkan-quads": "Vulkan quads", "vulkan-tiles": "Vulkan tiles", "vulkan-plain-float": "plain float, quads",
             "vulkan-plain-tiles": "plain float, tiles"}


# ---- frames

def short(row):
    return RENDERERS.get(row["renderer"], row["renderer"])


def frame_table(rows):
    body = []
    for r in rows:
        gpu = number(r["gpu_ms_p50"]) if r["gpu_ms_p50"] else NOTHING
        body.append([r["case"], short(r), number(r["ms_p50"]), number(r["ms_p95"]), number(r["draw_ms_p50"]), gpu, number(r.get("psnr_db"), 1),
                     number(r.get("covered_psnr_db"), 1), number(r.get("max_error_levels"), 1), number(r.get("covered_flip"), 4),
                     number(r["splats_drawn"], 0), number(r["resident_bytes"] / 2**20, 1)])
    return table(["case", "renderer", "ms", "95th percentile", "dplDraw, ms", "GPU, ms", "PSNR dB", "of covered pixels", "largest error, levels",
                  "FLIP", "splats drawn", "resident, MiB"], body)


def pass_table(rows, case, digits=2):
    chosen = [r for r in rows if r.get("case") == case and r.get("pass_gpu_ms")]
    labels = list(dict.fromkeys(label for r in chosen for label in r["pass_gpu_ms"]))
    if not labels:
        return ""
    body = [[label, *(number(r["pass_gpu_ms"].get(label), digits) for r in chosen)] for label in labels]
    return f"GPU ms of each pass, {case}:\n\n" + table(["pass", *(short(r) for r in chosen)], body) + "\n"


FRAME_WORDS = (
    "*ms*: draw and read, until the pictures are in memory, median. *dplDraw*: the time that it takes of an app's drawing thread. *GPU*: the "
    "device's own clock; on lavapipe, Mesa's Vulkan on the CPU, that clock counts CPU time. PSNR, largest error and FLIP are against the double-precision referee, "
    "over mid grey; empty background raises the PSNR of the whole picture. Renderers take turns, a frame each. Warm frames of every row "
    "allocate nothing and never wait, or the bench fails.\n\n")


def devices(rows):
    names = sorted({r["device"] for r in rows if r.get("renderer") in ("software", "vulkan-quads", "vulkan-tiles")})
    return "Devices: " + "; ".join(names) + ".\n\n" if names else ""


def frame_body(rows, digits=2):
    return devices(rows) + frame_table(rows) + "\n" + pass_table(rows, PHONE, digits) + pass_table(rows, HEADSET, digits)


def frames(store):
    text = BACK + "# Frames: speed against error\n\n" + FRAME_WORDS
    text += "![Speed against error](speed-error.svg)\n\n" if store.get("speed-error") else ""
    text += section(store, "speed-error", "What users can choose", frame_body)
    return text + section(store, "frames-2k", "An avatar made from pictures of 1080 × 1440 pixels", frame_body)


def worth_cell(row, what):
    if row.get(f"{what}_worth") is None:
        return NOTHING
    return (f"{number(row[f'{what}_off_ms'])} → {number(row[f'{what}_on_ms'])}: {number(row[f'{what}_worth'])} × "
            f"({number(row[f'{what}_worth_p25'])} – {number(row[f'{what}_worth_p75'])})")


def worth_table(rows):
    body = [[r["case"], f"{RENDERERS.get(r['off'], r['off'])} → {RENDERERS.get(r['on'], r['on'])}",
             f"{number(r['drawn_off'], 0)} → {number(r['drawn_on'], 0)}", worth_cell(r, "frame"), worth_cell(r, "before_pixels"),
             worth_cell(r, "projection"), worth_cell(r, "sort")] for r in rows if "off" in r]
    return table(["case", "off → on", "splats drawn", "whole frame, ms", "before pixels are filled, GPU ms", "projection and colour, GPU ms",
                  "sort, GPU ms"], body)


def baselines(store):
    def body(rows):
        drawn = [r for r in rows if "renderer" in r]
        return devices(drawn) + frame_table(drawn) + "\n" + worth_table(rows) + "\n" + pass_table(drawn, PHONE)
    text = BACK + (
        "# Baseline: what the optimisations are worth\n\n"
        "*Plain float* is the frame before anything was made fast, frozen in `tools/bench/baseline`: records of floats, every splat projected, "
        "32-bit float keys, a frame an eye, one sample a pixel. It draws only splats that face the view and reach 1/255.\n\n"
        "Ratios are taken in each round; given are their median and quartiles. No bars are set for them on lavapipe, because code that "
        "only lavapipe gains from may be removed (ADR 0033).\n\n")
    text += section(store, "baselines", "The demo's avatar", body)
    return text + section(store, "baselines-large", "The same avatar blown up to 533,695 splats", body)


def memory(store):
    def body(rows):
        return table(["splats", "SH degree", "encoding", "file, MB", "splats, B each", "of 62 floats", "whole avatar, MB", "of 62 floats",
                      "peak of loading / kept", "load, ms", "fastest, ms"],
                     [[number(r["splats"], 0), r["sh_degree"], r["encoding"], number(r["file_bytes"] / 1e6), number(r["splat_bytes"] / r["splats"], 1),
                       barred(r, "splat_share", 1, "%", 100), number(r["avatar_bytes"] / 1e6), barred(r, "avatar_share", 1, "%", 100),
                       barred(r, "peak_ratio", 2), barred(r, "load_ms", 0), number(r["load_ms_fastest"], 0)] for r in rows])

    def drawn(rows):
        return table(["case", "renderer", "avatar, MB", "frames of the case, MB", "bytes read a splat: deciding", "decoding"],
                     [[r["case"], short(r), number(r["avatar_bytes"] / 1e6), number((r["resident_bytes"] - r["avatar_bytes"]) / 1e6, 1),
                       number(r["bytes_decided"] / r["splats"]), number(r["bytes_decoded"] / r["splats"])] for r in rows])

    def library(rows):
        return table(["part", "MB"], [["**all**" if r["part"] == "all" else r["part"], barred(r, "bytes", 2, scale=1e-6)] for r in rows])
    text = BACK + ("# Loading and memory\n\nThe avatar stays packed in memory. *62 floats* is a splat of SH degree 3 in a PLY. The file's own "
                   "bytes belong to the caller and are not counted.\n\n")
    return text + section(store, "load", "533,695 splats, CPU renderer", body) + section(store, "speed-error", "The demo's avatar, by renderer", drawn) + section(
        store, "library", "The library: stripped libdoppel.so", library)


HOST = """Doppel's calls of a frame, on the thread that makes them; medians. Stereo is one layered pass on Metal and a pass for each eye \
on Vulkan, as lavapipe needs. No command runs while a call is timed, on any thread.

| commands go to | what the figure includes |
|---|---|
| nowhere | Doppel's code alone: choosing what is drawn, writing poses and cameras, the backend and its calls, each of which does nothing. The same of both backends, so these rows compare them |
| software device, not run | on top of that, the checks of the software Metal device ([tests/metal](../../tests/metal/README.md)): a mutex, look-ups and copies in each call. It stands for no driver; it shows that the calls were right |
| lavapipe, recorded | on top of Doppel's code, what Mesa does to record and submit commands |

What Apple's driver adds is not known: no Apple device has run it. The Vulkan backend records commands anew in each frame too.

"""


def ways_table(rows):
    return table(["case", "way", "calling thread, ms", "frame, ms", "pixels over the bus, MB", "allocations a frame",
                  "to the CPU renderer, dB"],
                 [[r["case"], r["way"] + (" (multiview)" if r["multiview"] else ""), barred(r, "thread_ms", 3), number(r["frame_ms"], 1),
                   barred(r, "pixel_bytes", 1, scale=1e-6), barred(r, "allocations", 1), barred(r, "psnr_db", 1)] for r in rows])


WRITES = (
    "`dplWriteSplats` writes into memory, `dplVulkanWriteSplats` records the same for a buffer of the app's device. *Time* is CPU time of one "
    "thread, or the GPU's clock. *Pose and projection* are those of a picture of the same frame by the same clock: `dplProject` on the CPU, "
    "which also sorts; on a GPU the passes that pose, cull and project. Differences are the largest between GPU and CPU, of splats that "
    "show; of a variance relative to the splat's largest.\n\n")


def writes_table(rows):
    def small(row, key):
        return NOTHING if row[key] is None else f"{row[key]:.2g}"
    return WRITES + table(
        ["layout", "by", "calling thread, ms", "time, ms", "pose and projection, ms", "time / that", "MB a frame", "position, mm", "variance",
         "opacity", "colour or SH"],
        [[r["layout"], r["by"], number(r["thread_ms"], 3), number(r["ms"]), number(r["project_ms"]), barred(r, "ratio"),
          number(r["bytes"] / 1e6), *(small(r, key) for key in ("position_mm", "covariance", "opacity", "colour"))] for r in rows])


def apps(store):
    def host(rows):
        return HOST + table(["case", "calls", "backend", "its commands go to", "CPU, ms", "wall, ms", "allocations a frame",
                             "small picture to the CPU renderer, dB"],
                            [[r["case"], r["way"], r["backend"], r["commands_to"], barred(r, "thread_ms", 3), number(r["wall_ms"], 3),
                              barred(r, "allocations", 1), barred(r, "psnr_db", 1)] for r in rows])

    def delay(rows):
        return ("A person who swings the arms is tracked by ARKit's table at 60 Hz. The figure is the shift at which the avatar's elbow fits "
                "the person's best. Noise is 0.5° for each rotation, but for the row that says so. The delay of cameras, and of a "
                "platform's own tracking, comes on top; nobody has measured it on a device.\n\n" +
                table(["stream", "frames late", "the filter alone would be late by"],
                      [[r["stream"], number(r["frames"], 1), number(r["filter_frames"], 1)] for r in rows]))

    def load_frames(rows):
        return table(["meanwhile", "longest frame, ms", "longest, calling thread's CPU, ms", "median, ms", "95th percentile, ms",
                      "load, ms"],
                     [[r["way"], number(r["longest_ms"]), number(r["longest_cpu_ms"]), number(r["frame_ms_p50"]), number(r["frame_ms_p95"]),
                       number(r["load_ms"], 0) if r["load_ms"] else NOTHING] for r in rows])

    def steady(rows):
        return table(["part of a frame that splats do not change", "frames until its time is known", "frames until none is over the budget",
                      "frames until all splats are back"],
                     [[f"{r['fixed_percent']} %", r["latency_frames"], barred(r, "steady_frames", 0), barred(r, "back_frames", 0)]
                      for r in rows])
    text = BACK + ("# Inside an app's frames\n\n*Calling thread* is what Doppel's calls of a frame compute on the thread that makes them; the time of the "
                   "GPU is in *frame*. Reading back counts the picture twice: down to the CPU, and up into the app's image.\n\n")
    return text + section(store, "ways", "Ways into an app's image", ways_table) + section(
        store, "writes", "Posed splats in an app's buffer", writes_table) + section(
        store, "host", "What a frame costs before the GPU gets it: Metal against Vulkan", host) + section(
        store, "delay", "How late a tracked person is shown", delay) + section(
        store, "load-frames", "Calls of a frame, 90 times a second, while 500,000 splats load", load_frames) + section(
        store, "steady", "Frame budget: the load trebles for 90 frames (simulated devices)", steady)


def detail(store):
    def body(rows):
        text = ""
        for splats in sorted({r["splats"] for r in rows}):
            chosen = [r for r in rows if r["splats"] == splats]
            text += f"{number(splats, 0)} splats, {chosen[0]['device']}:\n\n"
            text += table(["tall, px", "full: ms", "splats drawn", "MB read", "dB", "alpha, %", "reduced: ms", "allowed", "drawn", "MB read", "dB",
                           "alpha, %", "face, full: dB", "reduced", "hands, full: dB", "reduced"],
                          [[number(r["tall_px"], 0), number(r["full_ms"], 1), number(r["full_drawn"], 0), number(r["full_bytes_read"] / 1e6),
                            number(r["full_db"]), f"{r['full_alpha_percent']:+.2f}", number(r["reduced_ms"], 1), number(r["reduced_allowed"], 0),
                            number(r["reduced_drawn"], 0), number(r["reduced_bytes_read"] / 1e6), number(r["reduced_db"]),
                            f"{r['reduced_alpha_percent']:+.2f}", number(r.get("face_full_db")), number(r.get("face_reduced_db")),
                            number(r.get("hands_full_db")), number(r.get("hands_reduced_db"))] for r in chosen]) + "\n"
        return text
    text = BACK + (
        "# Level of detail\n\nThe avatar walks away from the camera, 512×768 px, `DPL_DETAIL_USUAL`. Truth is the full avatar drawn at four times "
        "the size and averaged. *Alpha* is the sum of alpha above the truth's: a swollen outline is above 0. Small avatars are drawn with four samples a "
        "pixel ([coverage samples](../reference/coverage.md)).\n\n")
    return text + section(store, "detail", "Full and reduced against distance", body)


def scaling_body(rows, field="ms_p50"):
    text = ""
    for case in dict.fromkeys(r["case"] for r in rows):
        chosen = [r for r in rows if r["case"] == case]
        names = list(dict.fromkeys(r["renderer"] for r in chosen))
        lines = []
        for splats in sorted({r["splats"] for r in chosen}):
            by = {r["renderer"]: r[field] for r in chosen if r["splats"] == splats}
            cells = [f"{number(by[n], 1)} ms, {number(by[n] * 1e6 / splats, 0)} ns" if n in by else NOTHING for n in names]
            lines.append([number(splats, 0), *cells])
        text += f"{case}, ms a frame and ns a splat:\n\n" + table(["splats", *(RENDERERS[n] for n in names)], lines) + "\n"
    return text


def scaling(store):
    text = BACK + ("# Time against the number of splats\n\nThe demo's avatar blown up, SH degree 1, medians of five. Where nanoseconds a splat "
                   "fall down a column, the time grows more slowly than the number of splats.\n\n")
    return text + section(store, "scaling", "Frames", scaling_body)


def floor(store):
    def body(rows):
        return table(["step", "floor program, ms", "Doppel, ms", "Doppel / floor"],
                     [[r["step"], number(r["floor_ms"], 1), number(r["doppel_ms"], 1), barred(r, "ratio")] for r in rows])
    text = BACK + ("# The CPU renderer against a floor\n\nThe floor program is the fastest CPU rasteriser that our research found. It has no formats, "
                   "poses or level of detail. 533,695 general splats of SH degree 3, 2048×945, alternating rounds of 15 frames, medians.\n\n")
    return text + section(store, "floor", "General splats", body)


def gpu(store):
    text = BACK + (
        "# On a GPU\n\n" + FRAME_WORDS + "A data-centre GPU is no phone: it has many more compute units, and few units that rasterise, "
        "so quads look slower beside tiles than they are on a GPU that is made for drawing. Its clock was left to itself.\n\n")
    return text + section(store, "gpu-frames", "What users can choose", lambda rows: frame_body(rows, 3)) + section(
        store, "gpu-scaling", "Against the number of splats, by the GPU's clock", lambda rows: scaling_body(rows, "gpu_ms_p50")) + section(
        store, "gpu-ways", "Ways into an app's image", ways_table) + section(
        store, "gpu-writes", "Posed splats in an app's buffer", writes_table)


# ---- the front page

def best_vulkan(rows, case, field="ms_p50"):
    chosen = [r for r in rows if r.get("case") == case and r.get("renderer", "").startswith("vulkan")]
    return min(chosen, key=lambda r: r[field]) if chosen else None


def loaded_mark(store, *names):
    return " (loaded)" if any(store.get(n) and store.get(n)["run"]["loaded"] for n in names) else ""


def headline(store):
    """Ten rows: what, figure, what it means, where the table is."""
    def held(name, kind, field="psnr_db", digits=2, unit="dB"):
        row = find(store.rows(name), row="held out", kind=kind)
        return barred(row, field, digits, unit) if row else NOTHING
    speed = store.rows("speed-error")
    cpu = {case: find(speed, case=case, renderer="software") for case in (PHONE, HEADSET)}
    vulkan = {case: best_vulkan(speed, case) for case in (PHONE, HEADSET)}
    real = {case: best_vulkan(store.rows("gpu-frames"), case, "gpu_ms_p50") for case in (PHONE, HEADSET)}
    name = real[PHONE]["device"].removeprefix("vulkan: ").split(" (")[0] if real[PHONE] else "a GPU"

    def ms(row, field="ms_p50", digits=1):
        return f"{number(row[field], digits)} ms, {number(row['covered_psnr_db'], 1)} dB" if row else NOTHING
    load = store.rows("load")
    first = load[0] if load else {}
    registration = find(store.rows("quality-scan-a"), row="registration", after="after the body fit")
    unseen = spread(store, UNSEEN, "registration", "keypoints_mean_mm", after="after the body fit")
    steps = find(store.rows("quality-scan-a"), row="training")
    file = find(store.rows("quality-scan-a"), row="file") or find(store.rows("quality-procedural-1"), row="file")
    timed = loaded_mark(store, "speed-error")
    biker = find(store.rows("quality-biker"), row="held out", kind="static")
    rows = [
        ["scan-a, held-out frames, static / dynamic", f"{held('quality-scan-a', 'static')} / {held('quality-scan-a', 'dynamic')}",
         "how near the avatar's pictures are to those of the scan that it was not made from", "[quality](benchmarks/quality.md)"],
        ["a real man, one pose, without pose fit", f"{barred(biker, 'psnr_without_pose_fit_db', 2, 'dB')}, IoU {barred(biker, 'iou_without_pose_fit', 4)}"
         if biker else NOTHING, "the same for a real scan with keypoints by a network", "[quality](benchmarks/quality.md)"],
        ["procedural seeds 4 to 9, static / dynamic",
         f"{spread_text(spread(store, UNSEEN, 'held out', 'psnr_db', kind='static'), 2, 'dB')} / "
         f"{spread_text(spread(store, UNSEEN, 'held out', 'psnr_db', kind='dynamic'), 2, 'dB')}", "the same for subjects that nobody tuned on, preset draft",
         "[quality](benchmarks/quality.md)"],
        ["keypoints after the body fit, scan-a / seeds 4 to 9",
         f"{barred(registration, 'keypoints_mean_mm', 1, 'mm') if registration else NOTHING} / {spread_text(unseen, 1, 'mm')}",
         "how far the joints of a pose are from the true ones", "[quality](benchmarks/quality.md)"],
        ["avatar file", f"{number(file['bytes'] / 1e6)} MB, {number(file['bytes_a_splat'], 1)} bytes a splat" if file else NOTHING,
         "what an app downloads", "[reconstruction](benchmarks/training.md)"],
        ["training step, scan-a", (barred(steps, "step_ms", 1, "ms") if steps else NOTHING) + loaded_mark(store, "quality-scan-a"),
         "10,000 of these make an avatar of preset standard", "[reconstruction](benchmarks/training.md)"],
        ["phone frame 945×2048, CPU / Vulkan on the CPU", f"{ms(cpu[PHONE])} / {ms(vulkan[PHONE])}{timed}",
         "time of a frame, and its error against the double-precision referee", "[frames](benchmarks/frames.md)"],
        ["headset 1920×1824 in stereo, CPU / Vulkan on the CPU", f"{ms(cpu[HEADSET])} / {ms(vulkan[HEADSET])}{timed}",
         "both eyes of a headset", "[frames](benchmarks/frames.md)"],
        [f"the same two on {name}, by its clock", f"{ms(real[PHONE], 'gpu_ms_p50', 2)} / {ms(real[HEADSET], 'gpu_ms_p50', 2)}",
         "with the copy to the CPU, which an app leaves out", "[on a GPU](benchmarks/gpu.md)"],
        ["loading 533,695 splats", (barred(first, "load_ms", 0, "ms") if first else NOTHING) + loaded_mark(store, "load"),
         "from bytes in memory to ready to draw", "[memory](benchmarks/memory.md)"],
        ["memory of these, of 62 floats a splat", barred(first, "avatar_share", 1, "%", 100) if first else NOTHING,
         "splats stay packed; mesh, weights and correctives included", "[memory](benchmarks/memory.md)"],
    ]
    return table(["what", "figure", "what it means", "all of it"], rows)


def web(store):
    def body(rows):
        pictures, frame, growth = [r for r in rows if r["row"] == "picture"], find(rows, row="frame"), find(rows, row="growth")
        text = table(["of a frame", "figure"], [
            ["picture, splats", f"{frame['size']}, {number(frame['splats'], 0)}"],
            ["pose, cull, project and sort in WebAssembly, ms", number(frame["project_ms"], 1)],
            ["the same by the native library on one thread, ms", number(frame["native_project_ms"], 1)],
            ["times the native library", barred(frame, "times_native")],
            ["upload and draw calls, ms", number(frame["submit_ms"], 1)],
            ["until the pixels are there, all together, blending by SwiftShader on the CPU, ms", number(frame["whole_ms"], 0)],
            ["uploaded, bytes", number(frame["uploaded_bytes"], 0)],
            [f"memory of the module after {number(growth['frames'], 0)} frames: growth, bytes", barred(growth, "module_bytes", 0)],
            ["memory of JavaScript in the second half of them: growth, bytes", number(growth["second_half_bytes"], 0)],
            ["garbage a frame, of the browser's bindings and the test, bytes", number(growth["garbage_bytes_a_frame"], 0)],
        ])
        parts = [r for r in rows if r["row"] == "part"]
        if parts:
            def cells(r, part):
                module, native = r[f"{part}_ms"], r[f"native_{part}_ms"]
                return [number(module, 1), number(native, 1), number(module / native)]
            text += "\n" + table(["splats drawn", "posed mesh, ms", "native", "times", "cull, project and sort, ms", "native", "times"],
                                 [[number(r["splats"], 0), *cells(r, "mesh"), *cells(r, "rest")] for r in parts])
        sizes, page, first = [r for r in rows if r["row"] == "size"], find(rows, row="page"), find(rows, row="first")
        if sizes and page and first:
            text += "\n" + table(["what a page loads", "bytes", "gzip −9", "brotli 11"], [
                [r["what"], number(r["bytes"], 0), number(r["gzip"], 0), barred(r, "brotli", 0)] for r in sizes])
            text += "\n" + table(["a page with somebody", "figure"], [
                [f"first picture of an avatar of {number(first['avatar_bytes'], 0)} bytes from a local server, after the page was asked for, ms",
                 barred(first, "first_ms", 0) + f"; at most {number(first['most_ms'], 0)}"],
                ["`doppel share`, bytes beyond 4/3 of the avatar", barred(page, "beyond_bytes", 0)]])
        return text + "\n" + table(["picture", "to the CPU renderer, dB", "largest difference, levels"], [
            [r["picture"], "equal bytes" if r["psnr_db"] is None else barred(r, "psnr_db", 1), r["levels"]] for r in pictures])
    text = BACK + (
        "# In a browser\n\nHeadless Chromium draws a sample person and the conformance kit by WebGL2, with the module of `platform/web`. There is no "
        "GPU here: SwiftShader blends on the CPU, so the time until the pixels are there says nothing about any device. No phone has been measured. "
        "*RGBA8*: what devices without float targets draw. All cases of the kit are here.\n\n")
    return text + section(store, "web", "WebGL2 against the CPU renderer", body) + "\n" + web_three(store) + "\n" + viewers(store) + "\n" + viewers_live(store)


VIEWERS = {"blender": "Blender, Cycles", "three": "three.js, GLTFLoader", "three-vrm": "three-vrm", "three-splats": "three.js, its own splats", "spark": "Spark", "playcanvas": "PlayCanvas engine",
           "babylon": "Babylon.js"}


def viewers(store):
    def cells(row):
        start = [f"{VIEWERS[row['viewer']]} {row['version']}", f"`{row['file']}`"]
        if "cannot" in row:
            return [*start, f"cannot: {row['cannot']}", *[NOTHING] * 5]
        start += [row["stands"], f"{100 * row['height']:.1f} %"]
        if row["kind"] == "vrm":  # in its T-pose
            return [*start, *[NOTHING] * 4]
        return [*start, f"{barred(row, 'sides_db', 1)} · {number(row['sides_covered_db'], 1)}",
                barred(row, "sides_patch", 0), f"{number(row['near_db'], 1)} · {number(row['near_covered_db'], 1)}", number(row["near_patch"], 0)]

    def body(rows):
        return ("One person at rest, 480 × 640 pixels over white, against `dplRender`: from eight sides (three.js' own splats and Spark from two: on SwiftShader they take longest), and the face from 0.7 m. dB of all pixels · "
                "of those that either picture covers. *Worst patch*: the mean difference in the worst square of 16 pixels, levels. A viewer has no gate, "
                "draws with a low-pass of its own, and smooths the edges of meshes as it likes. The VRM stands in its T-pose, so only its height is compared.\n\n" + table(
                    ["viewer", "file", "stands", "height", "eight sides, dB", "worst patch", "0.7 m, dB", "worst patch"],
                    [cells(r) for r in rows])) + faces([r for r in rows if "faces" in r])

    def faces(rows):
        if not rows:
            return ""
        return ("\nExpressions of the exported meshes from 0.7 m, where they move the face: dB against `dplRender` with that expression · against the face at rest.\n\n" + table(
            ["viewer", "file", *[face["name"] for face in rows[0]["faces"]]],
            [[f"{VIEWERS[r['viewer']]} {r['version']}", f"`{r['file']}`", *[f"{number(face['db'], 1)} · {number(face['rest_db'], 1)}" for face in r["faces"]]] for r in rows]))
    return section(store, "viewers", "Exported files in other people's viewers", body)


def viewers_live(store):
    def body(rows):
        return ("Thirty poses of a clip from two sides, 480 × 640 pixels over white, against `dplRender`: a live person, handed to the engine's own splats for the eye that looks; and six of these poses as exported files, which know no eye. "
                "*Below its file*: the worst of the six; below 0 it is nearer to `dplRender`. *Write*: position and covariance of all splats by the module's one thread.\n\n" + table(
                    ["engine", "live, dB", "least", "six of them, live", "as files", "worst below its file, dB", "write, ms"],
                    [[f"{VIEWERS[r['viewer']]} {r['version']}", number(r["live_db"], 1), number(r["least_live_db"], 1), number(r["files_live_db"], 1), number(r["file_db"], 1),
                      barred(r, "worst_below_db", 1), number(r["write_ms"], 1)] for r in rows]))
    return section(store, "viewers-live", "Live persons among other engines' splats", body)


PEERS = {"doppel": "Doppel: pose, cull, project, sort and draw, `DoppelGroup`", "spark": "Spark: sort in a worker and draw",
         "playcanvas": "PlayCanvas engine: sort in a worker and draw"}


def web_three(store):
    def body(rows):
        peers = table(["one person, the same camera in each frame", "version", "ms a frame, median", "least"], [
            [PEERS[r["peer"]], r["version"], number(r["ms_p50"], 0), number(r["ms_least"], 0)] for r in rows if r["row"] == "peer"])
        about = next(r for r in rows if r["row"] == "peer")
        return (table(["scene", "to the CPU renderer, dB", "largest difference, levels"], [
            [r["picture"], "equal bytes" if r["psnr_db"] is None else barred(r, "psnr_db", 1), r["levels"]] for r in rows if r["row"] == "three"])
            + f"\nOther renderers draw what `doppel export` wrote of one pose: {number(about['splats'], 0)} splats, {about['size']} pixels, "
            f"{about['frames']} frames of each, one after the other on one page, until a pixel is there. Blending is on the CPU, so this compares work, not "
            "what a graphics device makes of it. Theirs wait for no sort; ours poses anew in every frame. "
            "**Spark's time is not understood and not its speed**: on another day Spark drew 60,000 splats on SwiftShader in 1.2 to 1.8 s. "
            "Something on this page or in SwiftShader holds it up; do not quote it.\n\n" + peers)
    return section(store, "web-three", "In scenes of three.js, and beside other renderers", body)


def machines(store):
    """One line for each kind of machine that figures were taken on."""
    seen = {}
    for name, file in store.files.items():
        run = file["run"]
        cpu = run["processor"]
        key = f"{cpu['name']}, {cpu['cores']} cores, {cpu['vectors']}; {run['driver']}; {run['compiler']}"
        seen.setdefault(key, []).append(f"{name} ({run['date']}, `{run['commit']}`{', loaded' if run['loaded'] else ''})")
    return "".join(f"- {key}: {', '.join(names)}.\n" for key, names in seen.items())


def front(store):
    template = (pathlib.Path(__file__).parent / "front_page.txt").read_text(encoding="utf-8")
    parts = {"headline": headline(store), "machines": machines(store),
             "plot": "![Speed against error](benchmarks/speed-error.svg)\n" if store.get("speed-error") else missing("speed-error")}
    for name, text in parts.items():
        template = template.replace("{{" + name + "}}\n", text)
    return template


def speed_plot(store):
    series = {}
    for r in store.rows("speed-error"):
        if r.get("covered_psnr_db") is not None:
            series.setdefault(short(r), []).append((r["ms_p50"], r["covered_psnr_db"], r["case"].split(" ")[0]))
    return scatter("Speed against error: left is faster, up is nearer to the referee", "ms a frame, median", "PSNR of covered pixels, dB",
                   list(series.items()))


PAGES = {"quality": quality, "ladder": ladder, "reports": reports, "training": training, "frames": frames, "baselines": baselines, "memory": memory,
         "apps": apps, "detail": detail, "scaling": scaling, "floor": floor, "gpu": gpu, "web": web}


def write_all(root, out):
    """Writes every page below `out`, from the raw figures of docs/benchmarks. Gives their paths."""
    store = raw.Store(root / "docs/benchmarks")
    folder = out / "benchmarks"
    folder.mkdir(parents=True, exist_ok=True)
    written = {out / "benchmarks.md": GENERATED + front(store)}
    for name, page in PAGES.items():
        written[folder / f"{name}.md"] = GENERATED + page(store)
    if store.get("speed-error"):
        written[folder / "speed-error.svg"] = speed_plot(store)
    for path, text in written.items():
        raw.write_text(path, text.rstrip("\n") + "\n")
    return list(written)
