// SPDX-License-Identifier: Apache-2.0
// For measurements only: reconstructs a `doppel sample` scan with the true shape and poses instead of the body fit, to measure the error
// that the fit adds. All other stages are those of `doppel reconstruct`.
//   bench_true_body SCAN OUT [--preset draft|standard|high] [--steps N] [--seed N] [--threads N]
#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>

#include "reconstruction/run/run_request.h"
#include "reconstruction/run/stage_body_fit.h"
#include "reconstruction/run/stage_ingest.h"
#include "reconstruction/subject/body/body_tools.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

constexpr uint64_t kMaxTruthBytes = uint64_t(256) << 20;

Result<nlohmann::json> readJson(const std::filesystem::path& path) {
    DPL_TRY(const auto bytes, readFile(path, kMaxTruthBytes));
    nlohmann::json value = nlohmann::json::parse(bytes.begin(), bytes.end(), nullptr, false);
    if (!value.is_object()) return fail(Code::CorruptData, "{}: not a JSON object", path.string());
    return value;
}

/** Three numbers of a z-up file in the y-up world. */
Vec3d upright(const nlohmann::json& p) {
    return {p.at(0).get<double>(), p.at(2).get<double>(), -p.at(1).get<double>()};
}

/** Shape and poses of every frame as truth.json gives them. NotFound when it does not give those of `body`. */
Result<BodyFit> fitFromTruth(const Scan& scan, const BodyModel& body) {
    const std::filesystem::path path = scan.root / "truth.json";
    DPL_TRY(const nlohmann::json truth, readJson(path));
    DPL_TRY(const nlohmann::json manifest, readJson(scan.root / "scan.json"));
    const auto unfit = [&] {
        return fail(Code::NotFound,
                    "{} does not give the shape and poses of body '{}'; only a `doppel sample` scan with the built-in body does",
                    path.string(), body.name);
    };
    BodyFit fit;
    fit.shape.assign(body.morphs.size(), 0.0);
    fit.poses.assign(scan.frames.size(), Pose::rest(body.joints.size()));
    fit.fitted.assign(scan.frames.size(), true);
    try {
        size_t known = 0;
        for (size_t m = 0; m < body.morphs.size(); ++m)
            if (const auto& values = truth.at("shape").at("morphs"); values.contains(body.morphs[m].name))
                fit.shape[m] = values[body.morphs[m].name].get<double>(), ++known;
        if (known == 0 || known != truth["shape"]["morphs"].size() || truth["shape"].at("body") != body.name) return unfit();
        // The scan's rest skeleton stands on the floor; the body's may stand some millimetres above or below it.
        const Vec3d shift =
            upright(manifest.at("skeleton").at("rest_positions").at(0)) - Vec3d(shapedBody(body, fit.shape).joints[0].restPosition);
        std::map<std::string, const nlohmann::json*> byName;
        for (const auto& frame : truth["frames"]) byName[frame.at("name").get<std::string>()] = &frame;
        for (size_t f = 0; f < scan.frames.size(); ++f) {
            const auto found = byName.find(scan.frames[f].name);
            if (found == byName.end() || found->second->at("rotations").size() != body.joints.size()) return unfit();
            for (size_t j = 0; j < body.joints.size(); ++j) {
                const Vec3d turn = upright(found->second->at("rotations")[j]);
                const double angle = glm::length(turn);
                if (angle > 0) fit.poses[f].localRotations[j] = Quatf(glm::angleAxis(angle, turn / angle));
            }
            fit.poses[f].rootTranslation = Vec3f(shift + upright(found->second->at("translation")));
            if (Status good = checkPose(body.joints, fit.poses[f]); !good)
                return fail(Code::CorruptData, "{}: frame '{}': {}", path.string(), scan.frames[f].name, good.error().message);
            if (scan.frames[f].kind == FrameKind::StaticFull && fit.staticPose.localRotations.empty()) fit.staticPose = fit.poses[f];
        }
    } catch (const nlohmann::json::exception&) {
        return unfit();
    }
    if (fit.staticPose.localRotations.empty()) fit.staticPose = Pose::rest(body.joints.size());
    return fit;
}

Result<ReconstructResult> reconstructWithTruth(const ReconstructOptions& options, Progress& progress) {
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error) return fail(Code::Io, "cannot create {}: {}", options.out.string(), error.message());
    Jobs jobs(options.threadCount);
    StageChain chain(options.out, progress);
    Run run(chain, jobs, progress);
    run.put(RunRequest{options.scan, options}, "request");
    DPL_TRY(const FrameTable* table, run.get<FrameTable>());
    DPL_TRY(const ChosenBody* chosen, run.get<ChosenBody>());
    DPL_TRY(const std::string truth, hashFile(table->scan.root / "truth.json"));
    DPL_TRY(BodyFit fit, fitFromTruth(table->scan, chosen->body));
    BodyModel body = chosen->body;
    body.name += " (shape and poses from truth.json)";
    run.put(fittedBody(body, std::move(fit)), hashText(truth + table->trainingHash + chosen->hash));
    return completeRun(run);
}

}  // namespace
}  // namespace dpl

int main(int argc, char** argv) {
    using namespace dpl;
    CLI::App app("Reconstructs a sample scan with its true shape and poses in place of the body fit (measuring only)");
    ReconstructOptions options;
    app.add_option("scan", options.scan, "Scan folder made by `doppel sample`")->required();
    app.add_option("out", options.out, "Output folder")->required();
    std::string preset = options.preset.name;
    app.add_option("--preset", preset, "draft, standard, high, or a file")->check([](const std::string& name) {
        const auto found = findPreset(name);
        return found ? std::string() : found.error().message;
    });
    app.add_option("--steps", options.steps, "Training steps instead of the preset's");
    app.add_option("--seed", options.seed, "Seed of every random choice");
    app.add_option("--threads", options.threadCount, "CPU threads; 0: one for each core");
    CLI11_PARSE(app, argc, argv);
    options.preset = *findPreset(preset);
    installSignalHandlers();
    Progress progress;
    const auto result = reconstructWithTruth(options, progress);
    if (!result) {
        std::fprintf(stderr, "bench_true_body: %s\n", result.error().message.c_str());
        return 1;
    }
    std::printf("%s\n", result->summary.c_str());
    return 0;
}
