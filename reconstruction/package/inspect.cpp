#include "reconstruction/package/inspect.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"

namespace dpl {
namespace {

Result<AvatarInfo> inspectFile(const std::filesystem::path& path) {
    DPL_TRY(auto bytes, readFile(path));
    auto info = inspectAvatar(bytes);
    if (!info) return fail(info.error().code, "{}: {}", path.string(), info.error().message);
    return info;
}

std::vector<std::pair<const char*, uint64_t>> parts(const AvatarInfo& info) {
    return {{"mesh", info.meshBytes}, {"splats", info.splatBytes}, {"spherical harmonics", info.shBytes}, {"pose correctives", info.correctiveBytes},
            {"clips", info.clipBytes}, {"skin", info.skinBytes}, {"json", info.jsonBytes}, {"headers, padding", info.otherBytes}};
}

}  // namespace

Result<std::string> inspectAsText(const std::filesystem::path& path) {
    DPL_TRY(AvatarInfo info, inspectFile(path));
    std::string out = formatText("{}  \"{}\"\nformat version {}, by {}\n", path.string(), info.name, info.version, info.generator);
    out += formatText("content hash {} {}\n", info.contentHash, info.hashMatches ? "(matches)" : "(DOES NOT MATCH: the file was changed)");
    out += formatText("{} splats in {} chunks, SH degree {}\n{} vertices, {} triangles, {} layers, {} joints, {} clips\n\n", info.splats, info.chunks, info.shDegree,
                      info.vertices, info.triangles, info.layers, info.joints, info.clips);
    if (info.correctiveNodes) out.insert(out.size() - 1, formatText("pose correctives: {} nodes, {} modes\n", info.correctiveNodes, info.correctiveModes));
    char line[160];
    for (const auto& [name, bytes] : parts(info)) {
        std::snprintf(line, sizeof line, "  %-22s %10llu bytes  %5.1f %%\n", name, static_cast<unsigned long long>(bytes), 100.0 * double(bytes) / double(info.fileBytes));
        out += line;
    }
    const double perSplat = info.splats ? double(info.splatBytes + info.shBytes) / info.splats : 0;
    std::snprintf(line, sizeof line, "  %-22s %10llu bytes  (%.1f a splat with SH)\n", "file", static_cast<unsigned long long>(info.fileBytes), perSplat);
    out += line;
    if (!info.evidence.empty()) out += "\n  part                            kept   gain    reason\n";
    for (const EvidenceData& e : info.evidence) {
        std::snprintf(line, sizeof line, "  %-30s  %-4s  %5.2f dB  ", e.part.c_str(), e.kept ? "yes" : "no", e.gainDb);
        out += line + e.reason + "\n";
    }
    return out;
}

Result<std::string> inspectAsJson(const std::filesystem::path& path) {
    DPL_TRY(AvatarInfo info, inspectFile(path));
    nlohmann::ordered_json out = {{"file", path.string()},        {"name", info.name},         {"version", info.version},       {"generator", info.generator},
                                  {"content_hash", info.contentHash}, {"hash_matches", info.hashMatches}, {"splats", info.splats}, {"chunks", info.chunks},
                                  {"sh_degree", info.shDegree},   {"vertices", info.vertices}, {"triangles", info.triangles},   {"layers", info.layers},
                                  {"joints", info.joints},        {"clips", info.clips},       {"corrective_nodes", info.correctiveNodes}, {"corrective_modes", info.correctiveModes}};
    for (const auto& [name, bytes] : parts(info)) out["bytes"][name] = bytes;
    out["bytes"]["file"] = info.fileBytes;
    for (const EvidenceData& e : info.evidence)
        out["evidence"].push_back({{"part", e.part}, {"kept", e.kept}, {"gain_db", e.gainDb}, {"bytes", e.bytes}, {"reason", e.reason}});
    return out.dump(1);
}

}  // namespace dpl
