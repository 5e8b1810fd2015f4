// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "apps/doppel/commands.h"
#include "apps/doppel/talk.h"
#include "apps/shared/checks.h"
#include "reconstruction/output/package/pack.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

struct PackOptions {
    std::filesystem::path avatar, out;
    double maxMb = 0, maxLossDb = 0;  // 0 if not given
    uint32_t pictures = 16, threadCount = 0;
    uint64_t seed = 1;
};

constexpr double kDefaultLossDb = 42;

/** A point as JSON; infinite PSNR (equal pictures) is null. */
nlohmann::json pointJson(const PackPoint& p) {
    const auto finite = [](double db) { return std::isfinite(db) ? nlohmann::json(db) : nlohmann::json(); };
    return {{"change", p.move},
            {"bytes", p.bytes},
            {"psnrDb", finite(p.psnrDb)},
            {"wholePsnrDb", finite(p.wholePsnrDb)},
            {"splats", p.splats},
            {"shDegree", p.shDegree},
            {"modes", p.modes}};
}

/** --verbose also lists what was tried. */
class PackTask : public ShownTask {
public:
    explicit PackTask(Progress& progress) : ShownTask(progress), progress_(progress) {}
    void hear(double share, std::string_view doing) override {
        ShownTask::hear(share, doing);
        progress_.detail(doing);
    }

private:
    Progress& progress_;
};

Result<PackResult> pack(const PackOptions& options, const Talk& talk) {
    PackLimits limits;
    if (options.maxMb > 0) limits.maxBytes = uint64_t(options.maxMb * 1e6);
    if (options.maxLossDb > 0)
        limits.minPsnrDb = options.maxLossDb;
    else if (!limits.maxBytes)
        limits.minPsnrDb = kDefaultLossDb;
    Jobs jobs(options.threadCount);
    Progress progress(talk.style());
    progress.beginStage("pack");
    PackTask task(progress);
    const TaskScope scope(&task);
    DPL_TRY(PackResult packed, packFile(options.avatar, limits, {.seed = options.seed, .pictures = options.pictures}, jobs));
    DPL_RETURN_IF_ERROR(writeFileAtomically(options.out, packed.file));
    progress.endStage(formatText("{} bytes", packed.file.size()));
    return packed;
}

}  // namespace

void addPackCommand(CLI::App& app, CommandRun& run) {
    auto options = std::make_shared<PackOptions>();
    CLI::App* command = app.add_subcommand("pack", "Make an avatar's file smaller, and print its measured rate-distortion curve");
    command->add_option("avatar", options->avatar, "Avatar file (.glb)")->required();
    command->add_option("-o,--out", options->out, "The packed avatar (.glb)")->required()->check(isOutputFile({".glb"}));
    command->add_option("--max-mb", options->maxMb, "Largest size of the file, 10^6 bytes")->check(inRange(1e-6, 1e6));
    command
        ->add_option("--max-loss", options->maxLossDb,
                     "Lowest PSNR, dB, of the packed avatar's pictures against the original's, over covered pixels; without --max-mb the "
                     "default is 42")
        ->check(inRange(1.0, 200.0));
    command->add_option("--pictures", options->pictures, "Number of random views and poses that are drawn to measure the error")
        ->check(inRange(1, 1000))
        ->capture_default_str();
    command->add_option("--seed", options->seed, "Seed of views and poses; same seed, same bytes")
        ->check(isWholeNumber())
        ->capture_default_str();
    command->add_option("--threads", options->threadCount, "CPU threads; 0: one for each core. The result is the same for any number")
        ->check(inRange(0, 256));
    const auto talk = addTalkOptions(*command);
    command->footer(
        "Examples:\n"
        "  doppel pack ada/avatar.glb -o ada-small.glb                          as small as 42 dB allow\n"
        "  doppel pack ada/avatar.glb -o ada-1mb.glb --max-mb 1                 as good as 1 MB allow\n"
        "  doppel pack ada/avatar.glb -o ada-1mb.glb --max-mb 1 --max-loss 38   both, or an error that names the nearest point of the "
        "curve\n"
        "Packing first compresses the file without loss. Then each step makes the change that saves the most bytes for its error:\n"
        "it leaves out splats that few pixels see, replaces SH coefficients by a palette, leaves out modes of the pose correctives,\n"
        "or stores a splat's place, angle, size, opacity or colour with fewer bits.");
    command->callback([options, talk, &run] {
        refuseInputAsOutput(options->out, {options->avatar});
        run = [options, talk] {
            const auto packed = pack(*options, *talk);
            if (!packed) return talk->fail(packed.error());
            nlohmann::json curve = nlohmann::json::array();
            for (const PackPoint& p : packed->curve) curve.push_back(pointJson(p));
            return talk->succeed(formatText("{}\n{}: {} bytes", curveAsText(packed->curve), options->out.string(), packed->file.size()),
                                 {{"file", options->out.string()}, {"bytes", packed->file.size()}, {"curve", curve}});
        };
    });
}

}  // namespace dpl
