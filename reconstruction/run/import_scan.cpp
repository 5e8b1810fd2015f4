// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/import_scan.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/input/import/import.h"
#include "reconstruction/input/import/layout.h"
#include "sdk/core/files.h"

namespace dpl {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/** Path, size and time of files. Contents are not read: videos are large, and a change of them changes their time. */
json stateOf(const std::vector<fs::path>& paths) {
    json files = json::array();
    for (const fs::path& path : paths) {
        std::error_code ignored;
        files.push_back({path.string(), fs::file_size(path, ignored), fs::last_write_time(path, ignored).time_since_epoch().count()});
    }
    std::sort(files.begin(), files.end());
    return files;
}

/** What the import of these files depends on. */
std::string keyOf(const ImportOptions& options, const std::vector<fs::path>& source) {
    json key = {{"version", 2}, {"long_side", options.longSidePx}, {"height", options.heightM}};
    if (!options.source.empty()) key["source"] = stateOf(source);
    for (const auto& [name, list] :
         {std::pair{"static", &options.videos.still}, {"closeup", &options.videos.closeup}, {"motion", &options.videos.moving}})
        for (const fs::path& path : *list) key[name].push_back(stateOf({path}));
    return key.dump();
}

/** The path without links, as far as it exists. */
fs::path plainPath(const fs::path& path) {
    std::error_code error;
    return fs::weakly_canonical(fs::absolute(path, error), error);
}

/** Refuses files that are missing, or that lie where the import would move them away. */
Status checkFiles(const std::vector<fs::path>& files, const fs::path& scan) {
    std::error_code error;
    const fs::path folder = plainPath(scan);
    for (const fs::path& file : files) {
        if (!fs::is_regular_file(file, error)) return fail(Code::NotFound, "{}: no such file", file.string());
        const fs::path plain = plainPath(file);
        if (std::mismatch(folder.begin(), folder.end(), plain.begin(), plain.end()).first == folder.end())
            return fail(Code::InvalidArgument, "{} lies in {}, where the import writes its scan; move it, or choose another output with -o",
                        file.string(), scan.string());
    }
    return {};
}

/** Makes room for an import at `scan`. An earlier import is renamed and kept, because people add masks to it. `ours`: there was one. */
Status makeRoom(const fs::path& scan, bool ours, Progress& progress) {
    std::error_code error;
    if (!fs::exists(scan, error) || (fs::is_directory(scan, error) && fs::is_empty(scan, error))) return {};
    if (!ours)
        return fail(Code::InvalidArgument,
                    "{} would be written by the import, but something else is there; move it away, or choose another "
                    "output with -o",
                    scan.string());
    fs::path kept = scan;
    kept += ".replaced";
    for (int i = 2; fs::exists(kept, error); ++i) kept = formatText("{}.replaced-{}", scan.string(), i);
    fs::rename(scan, kept, error);
    if (error) return fail(Code::Io, "cannot rename {}: {}", scan.string(), error.message());
    progress.note(formatText("the earlier import is kept as {}; remove it if you added nothing to it", kept.string()));
    return {};
}

}  // namespace

Result<fs::path> scanToReconstruct(const ReconstructOptions& options, Progress& progress) {
    ImportOptions import;
    import.source = options.scan;
    import.videos = options.videos;
    import.out = options.out / "scan";
    std::vector<fs::path> files;
    if (!options.scan.empty()) {
        DPL_TRY(const CaptureLayout layout, recogniseCapture(options.scan));
        if (isReadableScan(layout)) {
            for (const std::string& note : layout.notes) progress.note(note);
            return layout.foundIn.empty() ? options.scan : layout.root;
        }
        files = filesOf(layout);
    }
    for (const auto* videos : {&import.videos.still, &import.videos.closeup, &import.videos.moving})
        DPL_RETURN_IF_ERROR(checkFiles(*videos, import.out));
    DPL_RETURN_IF_ERROR(checkFiles(files, import.out));
    const fs::path keyFile = options.out / "scan.import.json";
    const std::string key = keyOf(import, files);
    const auto before = readFile(keyFile, 64 << 20);
    if (before && std::string(before->begin(), before->end()) == key) {
        const auto scan = readScan(import.out, ScanCameras::MayLack);
        if (scan) {
            progress.note(formatText("{} was imported by an earlier run", import.out.string()));
            return import.out;
        }
        progress.note(formatText("imported again: {}", scan.error().message));
    }
    DPL_RETURN_IF_ERROR(makeRoom(import.out, bool(before), progress));
    DPL_RETURN_IF_ERROR(writeFileAtomically(keyFile, "\"importing\""));  // says that OUT/scan is an import's, whole or not
    progress.beginStage("import");
    DPL_TRY(const ImportReport report, importCapture(import, &progress.cancelFlag(), [&](double share, const std::string& what) {
                progress.update(share, what);
                return !progress.cancelled();
            }));
    progress.endStage("done");
    progress.note(report.summary);  // the next command is this one
    DPL_RETURN_IF_ERROR(writeFileAtomically(keyFile, key));
    return import.out;
}

}  // namespace dpl
