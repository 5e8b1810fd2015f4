// SPDX-License-Identifier: Apache-2.0
#include "apps/bench/training.h"

#include <algorithm>
#include <cstdio>

#include "apps/bench/json_row.h"
#include "apps/shared/checks.h"
#include "reconstruction/run/progress.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

constexpr const char* kPartMeanings =
    "\nms: wall time, mean of the measured steps. CPU ms: of all threads; on a busy machine it says more than the wall. Threads busy: CPU\n"
    "time by wall time. Alone ms: CPU time of the training thread while no other thread computes, (T · own − all) / (T − 1) with T "
    "threads.\n"
    "Bytes: what the part reads and writes at least once, by the sizes of its arrays; not counted.\n";

/** Bytes of the arrays that a part reads and writes. */
double bytesOf(StepPart part, const ProfiledTraining& t) {
    const StepProfile& p = t.profile;
    constexpr double kFloat = 4, kFrame = sizeof(TriangleFrame<float>), kRecord = sizeof(ForwardRecord<float>),
                     kDrawn = sizeof(ProjectedSplat), kSums = sizeof(EntrySums), kRest = sizeof(RestTriangle<float>), kNode = 16;
    const double n = t.splats, row = kFloat * t.rowFloats, linear = kFloat * (7 + t.shFloats) + 1, v = t.vertices, f = t.triangles;
    switch (part) {
        case StepPart::Pose:
            return v * (12 * 3 + 24 + 4 + 12) + f * (12 + kRest + kFrame);
        case StepPart::Project:
            return n * (linear + kDrawn + 8) + p.visible * (kRecord + 8) + f * kFrame;
        case StepPart::Tiles:
            return p.visible * (2 * 2 * 8 + 3 * 8) + p.entries * 4;
        case StepPart::Blend:
            return p.entries * (4 + kDrawn) + p.pixels * kFloat * 7;
        case StepPart::Loss:
            return p.pixels * (kFloat * (4 + 3 * 3 + 2 * 7) + 5);
        case StepPart::Pixels:
            return p.entries * (2 * 4 + kDrawn + 2 * kSums) + n * kSums + p.pixels * kFloat * 13;
        case StepPart::Splats:
            return n * (kSums + row) + p.visible * (kDrawn + kRecord + linear) + f * (kFrame + 36 + 12);
        case StepPart::Mesh:
            return f * (36 + 12) + v * (12 * 3 + 4 + 24) + t.nodes * kNode;
        case StepPart::Adam:
            return p.visible * (row * 7 + 2 * linear);
        default:
            return 0;
    }
}

std::string shown(double value, const char* format) {
    char text[40];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

/** Of the training thread while the others rest. */
double aloneMs(const PartTime& t, double threads) {
    return threads > 1 ? std::clamp((threads * t.caller - t.cpu) / (threads - 1), 0.0, t.caller) : t.caller;
}

}  // namespace

Status runTrainingBench(const TrainingBenchOptions& options) {
    Progress progress;
    const PictureSize size = parsePictureSize(options.size).value_or(PictureSize{378, 504});
    DPL_TRY(const ProfiledTraining made, profileTraining(options.reconstruct, size.widthPx, size.heightPx, options.steps, progress));
    const StepProfile& p = made.profile;
    const double threads = Jobs(options.reconstruct.threadCount).threadCount();
    const std::string name = options.reconstruct.scan.empty() ? "procedural " + options.size : options.reconstruct.scan.filename().string();
    PartTime sum;
    double alone = 0;
    for (const PartTime& t : p.parts) sum.wall += t.wall, sum.cpu += t.cpu, sum.caller += t.caller, alone += aloneMs(t, threads);
    std::printf("%s: %u splats, %.0f drawn in a step, %.0f entries of tile lists, %.0f pairs, %.0f pixels; %u vertices, %u triangles\n",
                name.c_str(), made.splats, p.visible, p.entries, p.pairs, p.pixels, made.vertices, made.triangles);
    std::printf("%u steps over %u frames after %u; %.0f threads; loss at the end %.8g\n\n", p.steps, made.frames, options.steps.warmUp,
                threads, made.loss);
    std::printf("| part | ms | share | CPU ms | threads busy | alone ms | MB |\n|---|---|---|---|---|---|---|\n");
    std::string json = JsonRow()
                           .add("case", name)
                           .add("threads", uint32_t(threads))
                           .add("steps", p.steps)
                           .add("ms", p.stepMs)
                           .add("cpu_ms", sum.cpu)
                           .add("alone_ms", alone)
                           .add("splats", made.splats)
                           .add("drawn", p.visible)
                           .add("entries", p.entries)
                           .add("pairs", p.pairs)
                           .add("pixels", p.pixels)
                           .add("vertices", made.vertices)
                           .add("triangles", made.triangles)
                           .add("crossed_bytes", made.crossedBytes)
                           .add("loss", made.loss)
                           .line();
    const auto print = [](const std::string& part, double ms, double share, const PartTime& t, double own, double bytes) {
        std::printf("| %s | %.2f | %.1f %% | %.2f | %.2f | %.2f | %s |\n", part.c_str(), ms, 100 * share, t.cpu,
                    t.wall > 0 ? t.cpu / t.wall : 0, own, bytes > 0 ? shown(bytes / 1e6, "%.1f").c_str() : "–");
    };
    double bytes = 0;
    for (size_t k = 0; k < kStepParts; ++k) {
        const PartTime& t = p.parts[k];
        if (t.wall == 0) continue;  // of another engine
        const auto part = StepPart(k);
        const double share = sum.cpu > 0 ? t.cpu / sum.cpu : 0;
        bytes += bytesOf(part, made);
        print(nameOf(part), t.wall, share, t, aloneMs(t, threads), bytesOf(part, made));
        json += JsonRow()
                    .add("case", name)
                    .add("part", nameOf(part))
                    .add("ms", t.wall)
                    .add("share", share)
                    .add("cpu_ms", t.cpu)
                    .add("threads_busy", t.wall > 0 ? t.cpu / t.wall : 0)
                    .add("alone_ms", aloneMs(t, threads))
                    .add("bytes", bytesOf(part, made))
                    .line();
    }
    print("a step", p.stepMs, 1, sum, alone, bytes);
    std::printf("%s", kPartMeanings);
    if (made.crossedBytes > 0) std::printf("\nBetween host and GPU, a step: %.2f MB\n", made.crossedBytes / 1e6);
    if (!made.passes.empty()) std::printf("\nPasses of the last step on the GPU, ms:\n");
    for (const PassTime& pass : made.passes) {
        std::printf("  %-24s %.3f\n", pass.label.c_str(), pass.milliseconds);
        json += JsonRow().add("case", name).add("pass", pass.label).add("gpu_ms", pass.milliseconds).line();
    }
    return options.jsonFile.empty() ? Status() : writeFileAtomically(options.jsonFile, json);
}

}  // namespace dpl
