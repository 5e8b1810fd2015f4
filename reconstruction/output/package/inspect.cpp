// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/inspect.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "reconstruction/output/package/avatar_bytes.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/expression_names.h"
#include "sdk/format/splat_file.h"

namespace dpl {
namespace {

/** Properties of a file of general splats. */
struct SplatSummary {
    SplatFile file;
    SplatBox box;
    float smallestM = 0, medianM = 0, largestM = 0;  // over the standard deviations of all axes
    uint64_t fileBytes = 0;
};

Result<SplatSummary> summarise(const std::filesystem::path& path, std::span<const uint8_t> bytes) {
    SplatSummary out;
    auto file = readSplats(bytes);
    if (!file) return fail(file.error().code, "{}: {}", path.string(), file.error().message);
    out.file = std::move(*file), out.box = boxOf(out.file.splats), out.fileBytes = bytes.size();
    std::vector<float> scales;
    for (const Vec3f& s : out.file.splats.scaleM) scales.insert(scales.end(), {s.x, s.y, s.z});
    if (scales.empty()) return out;
    std::sort(scales.begin(), scales.end());
    out.smallestM = scales.front(), out.medianM = scales[scales.size() / 2], out.largestM = scales.back();
    return out;
}

std::string formatName(const SplatFile& file) {
    return file.version ? formatText("{} version {}", nameOf(file.format), file.version) : nameOf(file.format);
}

std::string asText(const std::filesystem::path& path, const SplatSummary& s) {
    const StaticSplatData& splats = s.file.splats;
    const SplatRemarks& remarks = s.file.remarks;
    const auto place = [](const Vec3f& p) { return formatText("({}, {}, {})", p.x, p.y, p.z); };
    std::string out =
        formatText("{}  general splats, {}\n{} splats, SH degree {}{}{}\n", path.string(), formatName(s.file), splats.count(),
                   remarks.shDegree, remarks.shDegree > splats.shDegree ? formatText(" (drawn up to {})", splats.shDegree) : "",
                   splats.compensated ? ", trained antialiased" : "");
    out += remarks.axes.stated.empty() ? std::string(kNoUpAxis) + "\n" : formatText("axes: {}\n", remarks.axes.stated);
    for (const std::string& note : remarks.notes) out += "note: " + note + "\n";
    out += formatText("middle 98 % of the centres from {} to {} m\nstandard deviations {} to {} m, median {} m\n", place(s.box.low),
                      place(s.box.high), s.smallestM, s.largestM, s.medianM);
    return out + formatText("{} bytes, {} a splat\n", s.fileBytes, splats.count() ? double(s.fileBytes) / splats.count() : 0.0);
}

std::string asJson(const std::filesystem::path& path, const SplatSummary& s) {
    const StaticSplatData& splats = s.file.splats;
    const auto place = [](const Vec3f& p) { return nlohmann::ordered_json{p.x, p.y, p.z}; };
    nlohmann::ordered_json out = {{"file", path.string()}, {"format", nameOf(s.file.format)}};
    if (s.file.version) out["version"] = s.file.version;
    out.update({{"splats", splats.count()},
                {"sh_degree", s.file.remarks.shDegree},
                {"antialiased", splats.compensated},
                {"axes", s.file.remarks.axes.stated},
                {"dropped", s.file.remarks.dropped},
                {"notes", s.file.remarks.notes},
                {"box_low_m", place(s.box.low)},
                {"box_high_m", place(s.box.high)},
                {"smallest_scale_m", s.smallestM},
                {"median_scale_m", s.medianM},
                {"largest_scale_m", s.largestM}});
    out["bytes"]["file"] = s.fileBytes;
    return out.dump(1);
}

Result<AvatarInfo> inspectFile(const std::filesystem::path& path, std::span<const uint8_t> bytes) {
    auto info = inspectAvatar(bytes);
    if (!info) return fail(info.error().code, "{}: {}", path.string(), info.error().message);
    return info;
}

/** Describes splat encoding 3; empty for other encodings. */
std::string entropyCoded(const AvatarInfo& info) {
    if (info.splatEncoding != 3) return {};
    const SplatBits& b = info.bits;
    return formatText(", entropy-coded with {}, {}, {}, {} and {} bits of place, angle, size, opacity and colour", int(b.uv), int(b.phi),
                      int(b.scale), int(b.opacity), int(b.colour));
}

std::vector<std::pair<const char*, uint64_t>> parts(const AvatarInfo& info) {
    return {{"mesh", info.meshBytes},
            {"splats", info.splatBytes},
            {"spherical harmonics", info.shBytes},
            {"pose correctives", info.correctiveBytes},
            {"expressions", info.expressionBytes},
            {"capture map", info.captureMapBytes},
            {"clips", info.clipBytes},
            {"skin", info.skinBytes},
            {"json", info.jsonBytes},
            {"headers, padding", info.otherBytes}};
}

}  // namespace

Result<Inspection> inspectAsText(const std::filesystem::path& path) {
    DPL_TRY(const auto bytes, readAvatarBytes(path));
    if (splatFormatOf(bytes) != SplatFormat::None) {
        DPL_TRY(const SplatSummary splats, summarise(path, bytes));
        return Inspection{asText(path, splats)};
    }
    DPL_TRY(AvatarInfo info, inspectFile(path, bytes));
    std::string out = formatText("{}  \"{}\"\nformat version {}, by {}\n", path.string(), info.name, info.version, info.generator);
    out += formatText("content hash {} {}\n", info.contentHash, info.hashMatches ? "(matches)" : "(DOES NOT MATCH: the file was changed)");
    out += formatText("{} splats in {} chunks, SH degree {}{}\n{} vertices, {} triangles, {} layers, {} joints, {} clips\n\n", info.splats,
                      info.chunks, info.shDegree,
                      (info.shPaletteSize ? formatText(" from a palette of {}", info.shPaletteSize) : std::string()) + entropyCoded(info),
                      info.vertices, info.triangles, info.layers, info.joints, info.clips);
    if (info.correctiveNodes)
        out.insert(out.size() - 1, formatText("pose correctives: {} nodes, {} modes, {} motion modes\n", info.correctiveNodes,
                                              info.correctiveModes, info.motionModes));
    if (info.expressions) out.insert(out.size() - 1, formatText("expressions: {} of {}\n", info.expressions, kExpressionCount));
    if (info.light) out.insert(out.size() - 1, "light of the scene: stays while the subject turns\n");
    std::string layers;
    for (const LayerInfo& layer : info.layerList)
        layers += formatText("{}{} ({}, {} triangles, {} splats)", layers.empty() ? "layers: " : ", ", layer.name, layer.role,
                             layer.triangles, layer.splats);
    out.insert(out.size() - 1, layers + "\n");
    char line[160];
    std::string clips;
    for (const ClipInfo& clip : info.clipList) {
        std::snprintf(line, sizeof line, " (%.1f s)", clip.durationS);
        clips += (clips.empty() ? "clips: " : ", ") + clip.name + line;
    }
    if (!clips.empty()) out.insert(out.size() - 1, clips + "\n");
    if (info.trainedPixelM > 0) {
        std::snprintf(line, sizeof line, "trained at pixels of %.2f mm\n", 1e3 * double(info.trainedPixelM));
        out.insert(out.size() - 1, line);
    }
    for (const auto& [name, bytes] : parts(info)) {
        std::snprintf(line, sizeof line, "  %-22s %10llu bytes  %5.1f %%\n", name, static_cast<unsigned long long>(bytes),
                      100.0 * double(bytes) / double(info.fileBytes));
        out += line;
    }
    const double perSplat = info.splats ? double(info.splatBytes + info.shBytes) / info.splats : 0;
    std::snprintf(line, sizeof line, "  %-22s %10llu bytes  (%.1f a splat with SH)\n", "file",
                  static_cast<unsigned long long>(info.fileBytes), perSplat);
    out += line;
    if (!info.evidence.empty()) out += "\n  part                            kept   gain    reason\n";
    for (const EvidenceData& e : info.evidence) {
        char gain[32] = "      –  ";  // not measured
        if (e.gainDb != 0) std::snprintf(gain, sizeof gain, "%5.2f dB ", e.gainDb);
        std::snprintf(line, sizeof line, "  %-30s  %-4s  %s ", e.part.c_str(), e.kept ? "yes" : "no", gain);
        out += line + e.reason + "\n";
    }
    return Inspection{std::move(out), info.hashMatches};
}

Result<Inspection> inspectAsJson(const std::filesystem::path& path) {
    DPL_TRY(const auto bytes, readAvatarBytes(path));
    if (splatFormatOf(bytes) != SplatFormat::None) {
        DPL_TRY(const SplatSummary splats, summarise(path, bytes));
        return Inspection{asJson(path, splats)};
    }
    DPL_TRY(AvatarInfo info, inspectFile(path, bytes));
    nlohmann::ordered_json out = {{"file", path.string()},
                                  {"name", info.name},
                                  {"version", info.version},
                                  {"generator", info.generator},
                                  {"content_hash", info.contentHash},
                                  {"hash_matches", info.hashMatches},
                                  {"splats", info.splats},
                                  {"chunks", info.chunks},
                                  {"sh_degree", info.shDegree},
                                  {"sh_palette", info.shPaletteSize},
                                  {"splat_encoding", info.splatEncoding},
                                  {"vertices", info.vertices},
                                  {"triangles", info.triangles},
                                  {"layers", info.layers},
                                  {"joints", info.joints},
                                  {"clips", info.clips},
                                  {"corrective_nodes", info.correctiveNodes},
                                  {"corrective_modes", info.correctiveModes},
                                  {"motion_modes", info.motionModes},
                                  {"light", info.light}};
    for (const LayerInfo& layer : info.layerList)
        out["layer_list"].push_back({{"name", layer.name}, {"role", layer.role}, {"triangles", layer.triangles}, {"splats", layer.splats}});
    for (const ClipInfo& clip : info.clipList) out["clip_list"].push_back({{"name", clip.name}, {"duration_s", clip.durationS}});
    out["joint_names"] = info.jointNames;
    if (info.trainedPixelM > 0) out["trained_pixel_m"] = info.trainedPixelM;
    for (const auto& [name, bytes] : parts(info)) out["bytes"][name] = bytes;
    out["bytes"]["file"] = info.fileBytes;
    for (const EvidenceData& e : info.evidence)
        out["evidence"].push_back({{"part", e.part}, {"kept", e.kept}, {"gain_db", e.gainDb}, {"bytes", e.bytes}, {"reason", e.reason}});
    return Inspection{out.dump(1), info.hashMatches};
}

}  // namespace dpl
