// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/output_claim.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "reconstruction/input/import/layout.h"
#include "reconstruction/run/scan_inputs.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr uint64_t kMaxBytes = uint64_t(16) << 20;

/** Where the scan lies: its folder, or its videos. */
std::vector<std::string> sourcesOf(const ReconstructOptions& options) {
    std::vector<std::string> sources;
    std::error_code error;
    const auto add = [&](const fs::path& path) { sources.push_back(fs::weakly_canonical(fs::absolute(path, error), error).string()); };
    if (!options.scan.empty()) add(options.scan);
    for (const auto* videos : {&options.videos.still, &options.videos.closeup, &options.videos.moving})
        for (const fs::path& video : *videos) add(video);
    std::sort(sources.begin(), sources.end());
    return sources;
}

std::set<std::string> pictureHashes(const std::vector<FrameHashes>& frames) {
    std::set<std::string> hashes;
    for (const FrameHashes& frame : frames) hashes.insert(frame.image);
    return hashes;
}

/** The pictures of a source that needs no import. */
std::set<std::string> picturesBeforeImport(const ReconstructOptions& options) {
    if (options.scan.empty()) return {};
    const auto layout = recogniseCapture(options.scan);
    if (!layout || !isReadableScan(*layout)) return {};
    const auto scan = readScan(layout->foundIn.empty() ? options.scan : layout->root, ScanCameras::MayLack);
    return scan ? pictureHashes(hashFrames(*scan)) : std::set<std::string>();
}

}  // namespace

Status checkOutputIsFree(const ReconstructOptions& options) {
    std::error_code missing;
    if (options.replace || (!options.scan.empty() && !std::filesystem::exists(options.scan, missing))) return {};
    const auto bytes = readFile(options.out / "run.json", kMaxBytes);
    if (!bytes) return {};  // no run yet, or one of an earlier version
    const json claim = json::parse(bytes->begin(), bytes->end(), nullptr, /*allow_exceptions=*/false);
    if (!claim.is_object() || claim.value("source", json()) == json(sourcesOf(options))) return {};
    const json pictures = claim.value("pictures", json::array());
    const std::set<std::string> ours = picturesBeforeImport(options);
    if (std::any_of(pictures.begin(), pictures.end(),
                    [&](const json& hash) { return hash.is_string() && ours.contains(hash.get<std::string>()); }))
        return {};
    const json source = claim.value("source", json::array());
    return fail(Code::InvalidArgument,
                "{} holds the run of another scan ({}); choose another output with -o, or add --replace to give the folder to this scan",
                options.out.string(), source.is_array() && !source.empty() && source[0].is_string() ? source[0].get<std::string>() : "");
}

Status claimOutput(const ReconstructOptions& options, const Scan& scan, const std::vector<FrameHashes>& hashes) {
    const json claim = {{"format", "doppel-run"},
                        {"version", 1},
                        {"source", sourcesOf(options)},
                        {"scan", hashOfScan(scan, hashes)},
                        {"pictures", pictureHashes(hashes)}};
    return writeFileAtomically(options.out / "run.json", claim.dump(1));
}

}  // namespace dpl
