// doppel bench: time, error and bytes of every renderer on an avatar, side by side. Renderers take turns, so that a busy machine is busy for all.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "apps/doppel/commands.h"
#include "apps/doppel/pictures.h"
#include "reconstruction/pipeline/progress.h"
#include "reconstruction/report/sdk_camera.h"
#include "reconstruction/report/svg_plot.h"
#include "sdk/core/files.h"
#include "sdk/core/percentile.h"
#include "tests/reference/reference_file.h"

namespace dpl {
namespace {

struct BenchOptions {
    std::filesystem::path avatar, jsonFile, plotFile;
    std::vector<std::string> renderers = {"software", "vulkan-quads", "vulkan-tiles", "vulkan-without-culling", "vulkan-float-keys", "vulkan-two-frames"};
    std::string fill = "auto";
    std::string clip;
    double timeS = 0;
    uint32_t repeats = 11, threadCount = 0;
    std::string axes = "y-up";
    bool withoutReference = false;
};

struct BenchCase {
    const char* name;
    uint32_t widthPx, heightPx, viewCount;
    bool portrait = false;   // head and shoulders only
};

constexpr BenchCase kCases[] = {{"scan 378x504", 378, 504, 1}, {"phone 945x2048", 945, 2048, 1}, {"portrait 945x945", 945, 945, 1, true}, {"headset 1920x1824 stereo", 1920, 1824, 2}};
constexpr uint32_t kWarmUp = 2;  // rounds that are not timed

/** Times of one pass, in milliseconds, a sample a frame; rounds of the sort are summed. */
struct PassSamples {
    std::string label;
    std::vector<double> milliseconds;
};

/** What was switched off to be measured. */
struct SwitchedOff {
    const char* renderer;   // of --renderers
    uint32_t flag;
    const char* label;      // behind the renderer's name
    bool stereoOnly;
};
constexpr SwitchedOff kSwitches[] = {{"vulkan-without-culling", DPL_CONTEXT_WITHOUT_CULLING, "no culling", false},
                                     {"vulkan-float-keys", DPL_CONTEXT_WITHOUT_DEPTH_QUANTISATION, "32-bit keys", false},
                                     {"vulkan-two-frames", DPL_CONTEXT_WITHOUT_SHARED_STEREO, "a frame an eye", true}};

struct Contestant {
    std::string name;
    const SwitchedOff* without;
    doppel::Context context;
    doppel::Avatar avatar;
    std::vector<std::vector<uint8_t>> pixels;  // premultiplied RGBA8, one a view
    std::vector<DplImage> images;
    double loadMilliseconds = 0;
    std::vector<double> milliseconds, drawMilliseconds, gpuMilliseconds;
    std::vector<PassSamples> passes;
    DplFrameStats stats{};
    PictureError error;
    double flip = 0;   // of covered pixels, mean of the views
};

double millisecondsSince(std::chrono::steady_clock::time_point start) { return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count(); }

std::string decibelText(double db) { return std::isfinite(db) ? formatText("{} dB", std::round(db * 10) / 10) : "equal"; }
double finiteDb(double db) { return std::isfinite(db) ? db : 999; }

/** A context of its own for each case, so that its bytes are those of the case. Left out with a sentence: renderers that the machine does not
 *  have, and those whose device cannot hold the avatar. */
Result<std::vector<Contestant>> contestants(const BenchOptions& options, std::span<const uint8_t> bytes, const BenchCase& test) {
    std::vector<Contestant> list;
    Error why{Code::Unsupported, "no renderer could be started"};
    for (const std::string& name : options.renderers) {
        const auto found = std::find_if(std::begin(kSwitches), std::end(kSwitches), [&](const SwitchedOff& s) { return name == s.renderer; });
        const SwitchedOff* without = found == std::end(kSwitches) ? nullptr : found;
        if (without && without->stereoOnly && test.viewCount == 1) continue;
        const DplFill fill = name == "vulkan-quads" || (without && options.fill == "auto") ? DPL_FILL_QUADS : name == "vulkan-tiles" ? DPL_FILL_TILES : fillOf(options.fill);
        auto context = doppel::Context::create(name == "software" ? DPL_RENDERER_SOFTWARE : DPL_RENDERER_VULKAN, options.threadCount, without ? without->flag : 0, fill);
        if (!context) {
            std::fprintf(stderr, "doppel: %s is left out: %s\n", name.c_str(), context.error().message.c_str());
            continue;
        }
        const auto loadStart = std::chrono::steady_clock::now();
        auto avatar = context->loadAvatar(bytes);
        const double loadMilliseconds = millisecondsSince(loadStart);
        if (!avatar) {
            why = fail(fromSdk(avatar.error()).code, "{}: {}", options.avatar.string(), avatar.error().message);
            if (why.code != Code::Unsupported) return why;
            std::fprintf(stderr, "doppel: %s is left out: %s\n", name.c_str(), avatar.error().message.c_str());
            continue;
        }
        if (!options.clip.empty()) {
            DPL_TRY(const uint32_t clip, chooseClip(*avatar, options.clip));
            if (auto set = avatar->setPoseFromClip(clip, options.timeS, true); !set) return fromSdk(set.error());
        }
        Contestant c{context->rendererName() + (without ? formatText(", {}", without->label) : ""), without, std::move(*context), std::move(*avatar), {}, {}, loadMilliseconds, {}, {}, {}, {}, {}, {}};
        c.pixels.assign(test.viewCount, std::vector<uint8_t>(size_t(test.widthPx) * test.heightPx * 4));
        for (std::vector<uint8_t>& pixels : c.pixels) {
            DplImage image{};
            image.structSize = sizeof image;
            image.rgba = pixels.data();
            image.rgbaBytes = pixels.size();
            c.images.push_back(image);
        }
        list.push_back(std::move(c));
    }
    if (list.empty()) return why;
    return list;
}

std::vector<Cameraf> casesViews(const BenchCase& test, const DplAvatarInfo& info, const std::string& axes) {
    constexpr float kZoom = 4, kHeadAbove = 0.36f;  // of the picture's height, before zooming
    Cameraf centre = frameAvatar(info, test.widthPx, test.heightPx, 0.4, uprightFromFile(axes));
    if (test.portrait) centre.fx *= kZoom, centre.fy *= kZoom, centre.cy += kZoom * kHeadAbove * float(test.heightPx);
    if (test.viewCount == 1) return {centre};
    return {shiftedSideways(centre, -kEyeDistanceM / 2), shiftedSideways(centre, kEyeDistanceM / 2)};
}

/** GPU times of the frame that was drawn last. */
Status samplePasses(Contestant& c) {
    auto stats = c.avatar.frameStats();
    if (!stats) return fromSdk(stats.error());
    c.stats = *stats;
    c.gpuMilliseconds.push_back(stats->gpuMs);
    for (PassSamples& pass : c.passes) pass.milliseconds.push_back(0);
    for (uint32_t p = 0; p < stats->passCount; ++p) {
        auto time = c.avatar.passTime(p);
        if (!time) return fromSdk(time.error());
        auto pass = std::find_if(c.passes.begin(), c.passes.end(), [&](const PassSamples& known) { return known.label == time->label; });
        if (pass == c.passes.end()) pass = c.passes.insert(pass, {time->label, {0}});
        pass->milliseconds.back() += time->milliseconds;
    }
    return {};
}

Status timeFrames(std::vector<Contestant>& list, std::span<const Cameraf> views, const BenchOptions& options, const std::function<Status(double)>& progress) {
    std::vector<DplCamera> cameras;
    for (const Cameraf& view : views) cameras.push_back(sdkCamera(view));
    const uint32_t rounds = options.repeats + kWarmUp;
    for (uint32_t round = 0; round < rounds; ++round)
        for (Contestant& c : list) {
            const auto start = std::chrono::steady_clock::now();
            const auto drawn = c.avatar.draw(cameras);
            const double drawMilliseconds = millisecondsSince(start);
            const auto read = drawn ? c.avatar.readImages(c.images) : drawn;
            const double milliseconds = millisecondsSince(start);
            if (!read) return fail(fromSdk(read.error()).code, "{}: {}", c.name, read.error().message);
            if (round >= kWarmUp) {
                c.milliseconds.push_back(milliseconds);
                c.drawMilliseconds.push_back(drawMilliseconds);
                DPL_CHECK_OK(samplePasses(c));
            }
            DPL_CHECK_OK(progress((round + 1.0) / rounds));
        }
    return {};
}

/** The referee draws each view once; every renderer's last picture is compared with it. */
Status measureErrors(std::vector<Contestant>& list, std::span<const Cameraf> views, const ReferenceFile& referee, const std::function<Status(double)>& progress) {
    auto info = list[0].avatar.info();
    if (!info) return fromSdk(info.error());
    std::vector<float> rotations(size_t(info->jointCount) * 4);
    Vec3f root(0);
    if (info->jointCount > 0 && dplGetPose(list[0].avatar.handle(), rotations.data(), info->jointCount, &root.x) != DPL_OK) return fail(Code::Internal, "{}", dplGetLastError());
    for (size_t v = 0; v < views.size(); ++v) {
        const ReferencePicture want = referee.draw(rotations, root, views[v]);
        for (Contestant& c : list) c.error += compareWith(want, c.pixels[v]), c.flip += coveredFlip(want, c.pixels[v]) / double(views.size());
        DPL_CHECK_OK(progress(double(v + 1) / double(views.size())));
    }
    return {};
}

std::string frameRow(const BenchCase& test, const Contestant& c, uint32_t splatCount, bool compared) {
    char row[400];
    const double gpu = percentile(c.gpuMilliseconds, 0.5);
    std::snprintf(row, sizeof row, "| %s | %s | %.2f | %.2f | %.2f | %s | %s | %s | %s | %s | %s%u | %s | %.1f |\n", test.name, c.name.c_str(), percentile(c.milliseconds, 0.5),
                  percentile(c.milliseconds, 0.95), percentile(c.drawMilliseconds, 0.5), gpu > 0 ? formatText("{}", std::round(gpu * 100) / 100).c_str() : "–", compared ? decibelText(c.error.psnrDb()).c_str() : "–",
                  compared ? decibelText(c.error.coveredPsnrDb()).c_str() : "–", compared ? formatText("{}", std::round(c.error.maxLevels * 10) / 10).c_str() : "–",
                  compared ? formatText("{}", std::round(c.flip * 1e5) / 1e5).c_str() : "–", c.stats.splatsInView > 0 ? formatText("{} → {} → {} → ", splatCount, c.stats.splatsInView, c.stats.splatsFacing).c_str() : formatText("{} → ", splatCount).c_str(),
                  c.stats.splatsDrawn, c.stats.chunkCount > 0 ? formatText("{} of {}", c.stats.chunksProjected, c.stats.chunkCount).c_str() : "–", double(c.stats.residentBytes) / (1 << 20));
    return row;
}

std::string jsonLines(const BenchCase& test, const Contestant& c, uint32_t splatCount, bool compared) {
    char line[900];
    std::string out;
    std::snprintf(line, sizeof line, "{\"case\":\"%s\",\"views\":%u,\"width_px\":%u,\"height_px\":%u,\"device\":\"%s\",\"ms_p50\":%.3f,\"ms_p95\":%.3f,\"draw_ms_p50\":%.3f,\"splats\":%u,\"splats_in_view\":%u,\"splats_facing\":%u,\"splats_drawn\":%u,\"chunks\":%u,\"chunks_projected\":%u,\"resident_bytes\":%llu,\"avatar_bytes\":%llu,\"splat_bytes\":%llu,\"bytes_decided\":%llu,\"bytes_decoded\":%llu,\"load_ms\":%.2f,\"tile_entries\":%u,\"tiles_overflowed\":%u",
                  test.name, test.viewCount, test.widthPx, test.heightPx, c.name.c_str(), percentile(c.milliseconds, 0.5), percentile(c.milliseconds, 0.95),
                  percentile(c.drawMilliseconds, 0.5), splatCount, c.stats.splatsInView, c.stats.splatsFacing, c.stats.splatsDrawn, c.stats.chunkCount, c.stats.chunksProjected, static_cast<unsigned long long>(c.stats.residentBytes),
                  static_cast<unsigned long long>(c.stats.avatarBytes), static_cast<unsigned long long>(c.stats.splatBytes), static_cast<unsigned long long>(c.stats.bytesDecided),
                  static_cast<unsigned long long>(c.stats.bytesDecoded), c.loadMilliseconds, c.stats.tileEntries, c.stats.tilesOverflowed);
    out += line;
    if (compared) {
        std::snprintf(line, sizeof line, ",\"psnr_db\":%.2f,\"covered_psnr_db\":%.2f,\"max_error_levels\":%.2f,\"covered_flip\":%.6f", finiteDb(c.error.psnrDb()), finiteDb(c.error.coveredPsnrDb()), c.error.maxLevels, c.flip);
        out += line;
    }
    out += "}\n";
    for (const PassSamples& pass : c.passes) {
        std::snprintf(line, sizeof line, "{\"case\":\"%s\",\"views\":%u,\"device\":\"%s\",\"pass\":\"%s\",\"gpu_ms_p50\":%.4f,\"gpu_ms_p95\":%.4f}\n", test.name, test.viewCount, c.name.c_str(),
                      pass.label.c_str(), percentile(pass.milliseconds, 0.5), percentile(pass.milliseconds, 0.95));
        out += line;
    }
    return out;
}

/** Summed GPU time of the passes before any pixel is filled, milliseconds. */
double beforePixelsMs(const Contestant& c) {
    double sum = 0;
    for (const PassSamples& pass : c.passes)
        if (!pass.label.starts_with("draw") && !pass.label.starts_with("tiles.fill") && pass.label != "counts" && pass.label != "readback") sum += percentile(pass.milliseconds, 0.5);
    return sum;
}

/** What each switch is worth and what it costs: the same renderer and fill with it on, in the same turns. */
std::string worthRows(const BenchCase& test, const std::vector<Contestant>& list, bool compared) {
    std::string out;
    for (const Contestant& off : list) {
        if (!off.without) continue;
        const std::string whole = off.context.rendererName();
        const auto on = std::find_if(list.begin(), list.end(), [&](const Contestant& c) { return !c.without && c.context.rendererName() == whole; });
        if (on == list.end()) continue;
        const double frameOn = percentile(on->milliseconds, 0.5), frameOff = percentile(off.milliseconds, 0.5), beforeOn = beforePixelsMs(*on), beforeOff = beforePixelsMs(off);
        const std::string error = compared ? formatText("{} → {} | {} → {}", decibelText(off.error.coveredPsnrDb()), decibelText(on->error.coveredPsnrDb()), std::round(off.error.maxLevels * 10) / 10,
                                                        std::round(on->error.maxLevels * 10) / 10)
                                           : "– | –";
        char row[400];
        std::snprintf(row, sizeof row, "| %s | %s | %.2f → %.2f | %.2f × | %.2f → %.2f | %.2f × | %s |\n", test.name, off.name.c_str(), frameOff, frameOn, frameOff / frameOn, beforeOff, beforeOn,
                      beforeOn > 0 ? beforeOff / beforeOn : 0.0, error.c_str());
        out += row;
    }
    return out;
}

constexpr double kPlyBytes = 62 * 4;   // a splat of degree 3 as 32-bit floats: what memory is compared with

/** What stays in memory, what a frame adds, what it reads of the splats, and how long loading took. */
std::string memoryRow(const BenchCase& test, const Contestant& c, uint32_t splatCount) {
    const double ply = kPlyBytes * std::max(1u, splatCount), n = std::max(1u, splatCount);
    const auto share = [&](uint64_t bytes) { return 100 * double(bytes) / ply; };
    const uint64_t working = c.stats.residentBytes - std::min(c.stats.residentBytes, c.stats.avatarBytes);
    char row[400];
    std::snprintf(row, sizeof row, "| %s | %s | %.1f | %.1f B, %.1f %% | %.2f MB, %.1f %% | %.1f MB, %.1f %% | %.2f | %.2f |\n", test.name, c.name.c_str(), c.loadMilliseconds, double(c.stats.splatBytes) / n,
                  share(c.stats.splatBytes), double(c.stats.avatarBytes) / 1e6, share(c.stats.avatarBytes), double(working) / 1e6, share(working), double(c.stats.bytesDecided) / n, double(c.stats.bytesDecoded) / n);
    return row;
}

/** One row a pass, one column a case that was run: median / 95th percentile. */
struct PassTable {
    std::string device;
    std::string cases;
    size_t caseCount = 0;
    std::vector<std::string> labels, rows;

    void add(const Contestant& c, const BenchCase& test) {
        cases += formatText(" {} |", test.name), ++caseCount;
        for (const PassSamples& pass : c.passes) {
            size_t row = size_t(std::find(labels.begin(), labels.end(), pass.label) - labels.begin());
            if (row == labels.size()) labels.push_back(pass.label), rows.push_back("| " + pass.label + " |");
            char cell[80];
            std::snprintf(cell, sizeof cell, " %.3f / %.3f |", percentile(pass.milliseconds, 0.5), percentile(pass.milliseconds, 0.95));
            rows[row] += cell;
        }
    }
    std::string text() const {
        std::string out = "\n| GPU ms, " + device + " |" + cases + "\n|---|";
        for (size_t k = 0; k < caseCount; ++k) out += "---|";
        out += "\n";
        for (const std::string& row : rows) out += row + "\n";
        return out;
    }
};

Status bench(const BenchOptions& options) {
    DPL_TRY(const auto bytes, readFile(options.avatar));
    DPL_TRY(const ReferenceFile referee, ReferenceFile::read(bytes));
    Progress progress;
    std::string frames, memory, worth, json;
    std::vector<PlotSeries> plot;   // a colour a renderer, a point a case
    std::vector<PassTable> passes;
    uint32_t splatCount = 0;
    for (const BenchCase& test : kCases) {
        DPL_TRY(std::vector<Contestant> list, contestants(options, bytes, test));
        auto info = list[0].avatar.info();
        if (!info) return fromSdk(info.error());
        splatCount = info->splatCount;
        const std::vector<Cameraf> views = casesViews(test, *info, options.axes);
        const auto report = [&](const char* what) {
            return [&progress, what, &test](double share) -> Status {
                progress.update(share, formatText("{}, {}", test.name, what));
                return progress.cancelled() ? Status(fail(Code::Cancelled, "stopped")) : Status();
            };
        };
        progress.beginStage("frames");
        DPL_CHECK_OK(timeFrames(list, views, options, report("timing")));
        progress.endStage(test.name);
        if (!options.withoutReference) {
            progress.beginStage("reference");
            DPL_CHECK_OK(measureErrors(list, views, referee, report("drawing in double precision")));
            progress.endStage(test.name);
        }
        for (const Contestant& c : list) {
            frames += frameRow(test, c, splatCount, !options.withoutReference);
            memory += memoryRow(test, c, splatCount);
            auto table = std::find_if(passes.begin(), passes.end(), [&](const PassTable& t) { return t.device == c.name; });
            if (table == passes.end() && !c.passes.empty()) table = passes.insert(table, {c.name, {}, 0, {}, {}});
            if (table != passes.end()) table->add(c, test);
            json += jsonLines(test, c, splatCount, !options.withoutReference);
            auto points = std::find_if(plot.begin(), plot.end(), [&](const PlotSeries& s) { return s.name == c.name; });
            if (points == plot.end()) points = plot.insert(points, {c.name, {}, {}});
            points->x.push_back(percentile(c.milliseconds, 0.5)), points->y.push_back(finiteDb(c.error.coveredPsnrDb()));
            points->pointNames.push_back(std::string(test.name).substr(0, std::string_view(test.name).find(' ')));
        }
        worth += worthRows(test, list, !options.withoutReference);
    }
    std::printf("%s: %u splats, %zu bytes in the file\n\n"
                "| case | renderer | ms | p95 | dplDraw ms | GPU ms | PSNR | covered pixels | max error, levels | FLIP | splats → in view → facing → drawn | chunks projected | resident MiB |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n%s",
                options.avatar.c_str(), splatCount, bytes.size(), frames.c_str());
    for (const PassTable& table : passes) std::printf("%s", table.text().c_str());
    if (!worth.empty())
        std::printf("\n| case | switched off | frame, ms: off → on | worth | before pixels are filled, GPU ms: off → on | worth | covered pixels: off → on | max error, levels: off → on |\n|---|---|---|---|---|---|---|---|\n%s", worth.c_str());
    std::printf("\n| case | renderer | load ms | splats: bytes each, of PLY | avatar, of PLY | working set, of PLY | phase 1: bytes read a splat | phase 2 |\n|---|---|---|---|---|---|---|---|\n%s"
                "\nPLY: 62 floats a splat. Splats: codes, parents, SH entries. Avatar: with mesh, weights and pose correctives, CPU and GPU together. Working set: what the frames of this case add. Bytes read, of the splats'\n"
                "codes, over all splats and views: to tell which may show, and of those; counted on the CPU, from survivors and layout on a GPU.\n", memory.c_str());
    std::printf("\nms: dplDraw and dplReadImages together, pictures in memory; median and 95th percentile of %u. dplDraw ms: what an app's thread pays. GPU ms: the frame's passes by the device's clock. PSNR and max error: against the\n"
                "double-precision reference, colour over mid grey; of all pixels, and of those that something covers. FLIP: mean over covered pixels, 0 to 1.\n", options.repeats);
    const bool raced = std::any_of(options.renderers.begin(), options.renderers.end(), [](const std::string& name) { return name != "software"; });
    if (auto chosen = raced ? doppel::Context::create(DPL_RENDERER_VULKAN) : doppel::Error{}) std::printf("What --fill auto chooses on this device: %s\n", chosen->rendererName().c_str());
    if (!options.plotFile.empty()) {
        const PlotOptions axes{"Speed against error: left is faster, up is nearer to the reference", "ms a frame, median", "PSNR of covered pixels, dB", true, false, 900, 460, true};
        DPL_CHECK_OK(writeFileAtomically(options.plotFile, svgFile(svgPlot(plot, axes))));
    }
    if (options.jsonFile.empty()) return {};
    return writeFileAtomically(options.jsonFile, json);
}

}  // namespace

void addBenchCommand(CLI::App& app, CommandRun& run) {
    auto options = std::make_shared<BenchOptions>();
    CLI::App* command = app.add_subcommand("bench", "Time an avatar on every renderer and measure its pictures against the double-precision reference");
    command->add_option("avatar", options->avatar, "Avatar file (.glb), or general splats (.ply, compressed .ply, .spz, .glb with KHR_gaussian_splatting)")->required();
    command->add_option("--renderers", options->renderers, "Which to race")->check(CLI::IsMember({"software", "vulkan", "vulkan-quads", "vulkan-tiles", "vulkan-without-culling", "vulkan-float-keys", "vulkan-two-frames"}))->capture_default_str();
    command->add_option("--fill", options->fill, "How vulkan and what has something switched off fill pixels; auto: a self-test finds the faster one, quads for the latter")->check(CLI::IsMember(kFillNames))->capture_default_str();
    command->add_option("--clip", options->clip, "Pose: a clip of the avatar by name, or a BVH or glTF file (default: the rest pose)");
    command->add_option("--time", options->timeS, "Pose: time in the clip, seconds")->check(CLI::Range(0.0, 1e6));
    command->add_option("--repeats", options->repeats, "Timed frames a case")->check(CLI::Range(1, 1000))->capture_default_str();
    command->add_option("--threads", options->threadCount, "CPU threads, 0: one a core")->check(CLI::Range(0, 256));
    command->add_option("--axes", options->axes, "How the file stands; many 3D Gaussian splatting PLYs are y-down")->check(CLI::IsMember(kAxesNames))->capture_default_str();
    command->add_option("--json", options->jsonFile, "Write the figures to this file as JSON lines too");
    CLI::Option* withoutReference = command->add_flag("--no-reference", options->withoutReference, "Only time: the reference takes seconds a picture");
    command->add_option("--plot", options->plotFile, "Draw speed against error into this SVG file")->excludes(withoutReference);
    command->footer("Examples:\n  doppel bench ada/avatar.glb\n  doppel bench ada/avatar.glb --clip walk.bvh --time 1.5 --json ada.jsonl\n  doppel bench guitar.compressed.ply --axes y-down");
    command->callback([options, &run] {
        run = [options] {
            Status done = bench(*options);
            return done ? int(kExitOk) : reportError(done.error());
        };
    });
}

}  // namespace dpl
