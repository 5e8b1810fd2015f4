// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/pipeline/import_scan.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "reconstruction/import/import.h"
#include "sdk/core/files.h"

namespace dpl {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr size_t kMaxFiles = 100000;

/** Path, size and time of every file of a source. Contents are not read: videos are large, and a change of them changes their time. */
json stateOf(const fs::path& source) {
    json files = json::array();
    std::error_code error;
    const auto add = [&](const fs::path& path) {
        std::error_code ignored;
        files.push_back({path.string(), fs::file_size(path, ignored), fs::last_write_time(path, ignored).time_since_epoch().count()});
    };
    // A calibration is one file, and its videos lie beside it.
    const fs::path folder = fs::is_directory(source, error) ? source : fs::absolute(source, error).parent_path();
    if (fs::is_regular_file(source, error)) add(source);
    for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end && files.size() < kMaxFiles; at.increment(error))
        if (at->is_regular_file(error) && (folder == source || at.depth() == 0)) add(at->path());
    std::sort(files.begin(), files.end());
    return files;
}

json keyOf(const ImportOptions& options) {
    json key = {{"version", 1}, {"long_side", options.longSidePx}, {"height", options.heightM}};
    if (!options.source.empty()) key["source"] = stateOf(options.source);
    for (const auto& [name, list] :
         {std::pair{"static", &options.videos.still}, {"closeup", &options.videos.closeup}, {"motion", &options.videos.moving}})
        for (const fs::path& path : *list) key[name].push_back(stateOf(path));
    return key;
}

}  // namespace

Result<fs::path> scanToReconstruct(const ReconstructOptions& options, Progress& progress) {
    ImportOptions import;
    import.source = options.scan;
    import.videos = options.videos;
    import.out = options.out / "scan";
    if (!options.scan.empty() && isReadableScan(options.scan)) return options.scan;
    const fs::path keyFile = options.out / "scan.import.json";
    const std::string key = keyOf(import).dump();
    std::error_code error;
    if (const auto before = readFile(keyFile, 64 << 20);
        before && std::string(before->begin(), before->end()) == key && fs::exists(import.out / "scan.json", error)) {
        progress.note(formatText("{} was imported by an earlier run", import.out.string()));
        return import.out;
    }
    fs::remove(keyFile, error);
    fs::remove_all(import.out, error);
    progress.beginStage("import");
    DPL_TRY(const std::string summary, importCapture(import, &progress.cancelFlag(), [&](double share, const std::string& what) {
                progress.update(share, what);
                return !progress.cancelled();
            }));
    progress.endStage("done");
    progress.note(summary.substr(0, summary.rfind('\n')));  // the last line names the next command, which this one is
    DPL_CHECK_OK(writeFileAtomically(keyFile, key));
    return import.out;
}

}  // namespace dpl
