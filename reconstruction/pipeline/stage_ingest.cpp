// SPDX-License-Identifier: Apache-2.0
// ingest, observe, cameras: is the scan good enough, and what does each frame show?
#include <fstream>

#include "reconstruction/capture/observations.h"
#include "reconstruction/capture/scan_check.h"
#include "reconstruction/pipeline/subject_data.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

using nlohmann::json;

Result<std::string> fileHash(const std::filesystem::path& path) {
    if (path.empty()) return std::string("none");
    return hashFile(path);
}

json cameraJson(const Camerad& camera) {
    json out = {camera.widthPx, camera.heightPx, camera.fx, camera.fy, camera.cx, camera.cy};
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) out.push_back(camera.viewFromWorldRotation[column][row]);
    for (int row = 0; row < 3; ++row) out.push_back(camera.viewFromWorldTranslation[row]);
    return out;
}

/** Everything a frame brings, as hashes; unreadable files count by their sentence, so that a repaired file runs ingest again. */
json frameInputs(const ScanFrame& frame) {
    json out = {{"name", frame.name},
                {"kind", int(frame.kind)},
                {"split", int(frame.split)},
                {"time", frame.timeS},
                {"camera", cameraJson(frame.camera)}};
    for (const std::filesystem::path* path : {&frame.imagePath, &frame.maskPath, &frame.labelsPath, &frame.keypointsPath}) {
        auto hash = fileHash(*path);
        out["files"].push_back(hash ? *hash : hash.error().message);
    }
    return out;
}

json scanInputs(const Scan& scan) {
    json out = json::array();
    for (const ScanFrame& frame : scan.frames) out.push_back(frameInputs(frame));
    return out;
}

std::string readText(const std::filesystem::path& path) {
    auto bytes = readFile(path, 64 << 20);
    return bytes ? std::string(bytes->begin(), bytes->end()) : std::string();
}

/** Networks fill in what the scan lacks, into OUT/stages/…-observe. */
Status runObserve(SubjectData& subject) {
    if (subject.options.models.empty()) {
        bool anyKeypoints = false;
        for (const ScanFrame& frame : subject.scan.frames) anyKeypoints |= !frame.keypointsPath.empty();
        if (!anyKeypoints)
            return fail(Code::InvalidArgument,
                        "{} brings no keypoints: point --models at a folder with blazepose_full.onnx, or add keypoints files "
                        "(docs/formats/scan.md)",
                        subject.options.scan.string());
        return {};
    }
    json models = json::array();
    for (const char* name : {"blazepose_full.onnx", "blazepose_lite.onnx", "skin_clothes_hair_pan.onnx"})
        if (auto hash = hashFile(subject.options.models / name)) models.push_back(*hash);
    auto folder =
        subject.chain.run("observe", 1, {{"scan", scanInputs(subject.scan)}, {"models", models}}, [&](StageContext& context) -> Status {
            ObserveOptions options;
            options.models = subject.options.models;
            options.output = context.folder;
            options.progress = [&](size_t done, size_t count) {
                context.progress.update(double(done) / double(count), formatText("frame {} of {}", done, count));
            };
            Scan observed = subject.scan;
            return observeScan(observed, options, subject.jobs);
        });
    if (!folder) return folder.error();
    // Sets the paths of what the finished folder holds. The networks look again to do so (the same bytes).
    ObserveOptions options;
    options.models = subject.options.models;
    options.output = *folder;
    return observeScan(subject.scan, options, subject.jobs);
}

}  // namespace

Result<std::string> trainingDataHash(const SubjectData& subject) {
    json inputs = json::array();
    for (size_t f = 0; f < subject.scan.frames.size(); ++f)
        if (subject.scan.frames[f].split == Split::Train && subject.usable[f]) inputs.push_back(frameInputs(subject.scan.frames[f]));
    const std::string text = inputs.dump();
    return hashBytes({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

Status runIngest(SubjectData& subject) {
    DPL_TRY(subject.scan, readScan(subject.options.scan));
    DPL_CHECK_OK(runObserve(subject));
    auto folder = subject.chain.run("ingest", 1, {{"frames", scanInputs(subject.scan)}}, [&](StageContext& context) -> Status {
        DPL_TRY(ScanCheck check, checkScan(subject.scan, subject.jobs));
        json usable = json::array();
        for (const FrameCheck& frame : check.frames) usable.push_back(frame.usable);
        DPL_CHECK_OK(writeFileAtomically(context.folder / "check.json", scanCheckJson(subject.scan, check)));
        DPL_CHECK_OK(writeFileAtomically(context.folder / "verdict.txt", describeScanCheck(subject.scan, check)));
        DPL_CHECK_OK(writeFileAtomically(context.folder / "usable.json",
                                         json{{"usable", usable}, {"refused", check.verdict == ScanVerdict::Refuse}}.dump()));
        return {};
    });
    if (!folder) return folder.error();
    subject.verdict = readText(*folder / "verdict.txt");
    const json usable = json::parse(readText(*folder / "usable.json"), nullptr, false);
    if (!usable.is_object() || !usable.contains("usable") || usable["usable"].size() != subject.scan.frames.size())
        return fail(Code::CorruptData, "{} is damaged; delete it and run again", (*folder / "usable.json").string());
    subject.usable = usable["usable"].get<std::vector<bool>>();
    if (usable.value("refused", false)) return fail(Code::InvalidArgument, "the scan is refused:\n{}", subject.verdict);
    return {};
}

}  // namespace dpl
