// doppel bench: time, agreement and bytes of every renderer on an avatar, one table, alternating runs.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "apps/doppel/commands.h"
#include "apps/doppel/pictures.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

struct BenchOptions {
    std::filesystem::path avatar;
    std::vector<std::string> renderers = {"software", "vulkan"};
    uint32_t repeats = 11, threadCount = 0;
    std::string axes = "y-up";
    bool json = false;
};

struct BenchCase {
    const char* name;
    uint32_t widthPx, heightPx, viewCount;
};

constexpr BenchCase kCases[] = {{"scan 378x504", 378, 504, 1}, {"phone 945x2048", 945, 2048, 1}, {"headset 1920x1824 stereo", 1920, 1824, 2}};

struct Contestant {
    std::string name;
    doppel::Context context;
    doppel::Avatar avatar;
    std::vector<double> milliseconds;
    std::vector<std::vector<uint8_t>> pixels;
};

double percentile(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values[std::min(values.size() - 1, size_t(share * double(values.size())))];
}

/** PSNR of straight-alpha pictures composited over grey, dB; 100 for equal ones. */
double psnrDb(const std::vector<std::vector<uint8_t>>& a, const std::vector<std::vector<uint8_t>>& b) {
    double squares = 0, count = 0;
    for (size_t v = 0; v < a.size(); ++v)
        for (size_t i = 0; i < a[v].size(); i += 4)
            for (int c = 0; c < 3; ++c, ++count) {
                const double x = a[v][i + c] * a[v][i + 3] / 65025.0 + 0.5 * (1 - a[v][i + 3] / 255.0), y = b[v][i + c] * b[v][i + 3] / 65025.0 + 0.5 * (1 - b[v][i + 3] / 255.0);
                squares += (x - y) * (x - y);
            }
    return squares > 0 ? std::min(100.0, -10 * std::log10(squares / count)) : 100;
}

Status bench(const BenchOptions& options) {
    DPL_TRY(auto bytes, readFile(options.avatar));
    std::vector<Contestant> contestants;
    for (const std::string& name : options.renderers) {
        auto context = doppel::Context::create(name == "vulkan" ? DPL_RENDERER_VULKAN : DPL_RENDERER_SOFTWARE, options.threadCount);
        if (!context) {
            std::fprintf(stderr, "doppel: %s is left out: %s\n", name.c_str(), context.error().message.c_str());
            continue;
        }
        auto avatar = context->loadAvatar(bytes);
        if (!avatar) return fail(fromSdk(avatar.error()).code, "{}: {}", options.avatar.string(), avatar.error().message);
        const std::string full = context->rendererName();
        contestants.push_back({full, std::move(*context), std::move(*avatar), {}, {}});
    }
    if (contestants.empty()) return fail(Code::Unsupported, "no renderer could be started");
    auto info = contestants[0].avatar.info();
    if (!info) return fromSdk(info.error());
    if (!options.json)
        std::printf("%s: %u splats, %u triangles, %zu bytes in the file\n\n| case | renderer | median ms | p95 ms | PSNR to %s |\n|---|---|---|---|---|\n", options.avatar.c_str(),
                    info->splatCount, info->triangleCount, bytes.size(), contestants[0].name.c_str());
    for (const BenchCase& test : kCases) {
        const Cameraf centre = frameAvatar(*info, test.widthPx, test.heightPx, 0.4, uprightFromFile(options.axes));
        std::vector<Cameraf> views = {centre};
        if (test.viewCount == 2) views = {shiftedSideways(centre, -kEyeDistanceM / 2), shiftedSideways(centre, kEyeDistanceM / 2)};
        for (Contestant& c : contestants) c.milliseconds.clear();
        for (uint32_t repeat = 0; repeat < options.repeats + 2; ++repeat)  // two warm-up rounds; rounds alternate between renderers
            for (Contestant& c : contestants) {
                const auto start = std::chrono::steady_clock::now();
                DPL_TRY(c.pixels, drawViews(c.avatar, views));
                if (repeat >= 2) c.milliseconds.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
            }
        for (const Contestant& c : contestants) {
            const double median = percentile(c.milliseconds, 0.5), p95 = percentile(c.milliseconds, 0.95), agreement = psnrDb(c.pixels, contestants[0].pixels);
            if (options.json)
                std::printf("{\"case\":\"%s\",\"renderer\":\"%s\",\"ms_p50\":%.3f,\"ms_p95\":%.3f,\"psnr_to_first_db\":%.2f,\"splats\":%u}\n", test.name, c.name.c_str(), median, p95,
                            agreement, info->splatCount);
            else
                std::printf("| %s | %s | %.2f | %.2f | %s |\n", test.name, c.name.c_str(), median, p95, &c == &contestants[0] ? "–" : formatText("{} dB", std::round(agreement * 10) / 10).c_str());
        }
    }
    if (!options.json) std::printf("\nTimes are whole API calls, read-back of the pictures included. Error against the double-precision reference is held by tests/reference and tests/unit/render.\n");
    return {};
}

}  // namespace

void addBenchCommand(CLI::App& app, CommandRun& run) {
    auto options = std::make_shared<BenchOptions>();
    CLI::App* command = app.add_subcommand("bench", "Time an avatar on every renderer and compare the pictures");
    command->add_option("avatar", options->avatar, "Avatar file (.glb), or general splats (.ply, compressed .ply, .spz, .glb with KHR_gaussian_splatting)")->required();
    command->add_option("--renderers", options->renderers, "Which to race")->check(CLI::IsMember({"software", "vulkan"}))->capture_default_str();
    command->add_option("--repeats", options->repeats, "Timed frames a case")->check(CLI::Range(1, 1000))->capture_default_str();
    command->add_option("--threads", options->threadCount, "CPU threads, 0: one a core")->check(CLI::Range(0, 256));
    command->add_option("--axes", options->axes, "How the file stands; many 3D Gaussian splatting PLYs are y-down")->check(CLI::IsMember(kAxesNames))->capture_default_str();
    command->add_flag("--json", options->json, "JSON lines instead of a table");
    command->footer("Examples:\n  doppel bench ada/avatar.glb\n  doppel bench ada/avatar.glb --renderers software --json\n  doppel bench guitar.compressed.ply --axes y-down");
    command->callback([options, &run] {
        run = [options] {
            Status done = bench(*options);
            return done ? int(kExitOk) : reportError(done.error());
        };
    });
}

}  // namespace dpl
