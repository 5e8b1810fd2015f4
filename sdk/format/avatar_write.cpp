// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "sdk/format/avatar_check.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/capture_map.h"
#include "sdk/format/content_hash.h"
#include "sdk/format/correctives.h"
#include "sdk/format/correctives_compact.h"
#include "sdk/format/expressions.h"
#include "sdk/format/face_nodes.h"
#include "sdk/format/glb_builder.h"
#include "sdk/format/motion_modes.h"
#include "sdk/format/skinned_mesh_write.h"
#include "sdk/format/splat_codec.h"

namespace dpl {
namespace {

Json motionModes(GlbBuilder& glb, const MotionModeData& m) {
    const auto streams = encodeMotionModes(m);
    Json out = {{"encoding", 1}, {"joints", m.joints}, {"movedFrom", m.movedFromRad}, {"movedTo", m.movedToRad}, {"holds", m.holdsS}};
    if (!m.lagsS.empty()) out["lags"] = m.lagsS;
    out["streams"] = {{"groups", glb.addView(streams.groups)},
                      {"still", glb.addView(streams.still)},
                      {"ranges", glb.addView(streams.ranges)},
                      {"modes", glb.addView(streams.modes)}};
    return out;
}

/** The lowest version that can hold the avatar. Readers of a lower one would ignore a part and draw a wrong surface. */
uint32_t versionOf(const AvatarData& a) {
    if (!a.light.empty() || !a.correctives.motion.empty()) return 3;
    return a.correctives.followsPose() ? 2 : 1;
}

Json poseCorrectives(GlbBuilder& glb, const PoseCorrectiveData& c, bool compact) {
    auto streams = encodeCorrectives(c);
    std::vector<uint8_t> coded;
    if (compact) coded = compactCorrectives(streams, c.nodeCount);
    if (coded.size() >= streams.nodes.size() + streams.nodeIndices.size() + streams.nodeWeights.size()) coded.clear();
    if (!coded.empty()) streams.nodes.clear(), streams.nodeIndices.clear(), streams.nodeWeights.clear();
    Json out = {{"encoding", coded.empty() ? 1 : 2},
                {"modeCount", c.modeCount},
                {"nodeCount", c.nodeCount},
                {"joints", c.joints},
                {"reach", c.reach}};
    if (c.reachOffModes < PoseCorrectiveData().reachOffModes) out["reachOffModes"] = c.reachOffModes;
    auto stream = [&](const char* name, const std::vector<uint8_t>& bytes) {
        if (!bytes.empty()) out["streams"][name] = glb.addView(bytes);
    };
    stream("mean", streams.mean), stream("modes", streams.modes), stream("ranges", streams.ranges), stream("nodes", streams.nodes);
    stream("nodeIndices", streams.nodeIndices), stream("nodeWeights", streams.nodeWeights), stream("coded", coded);
    if (!c.motion.empty()) out["motion"] = motionModes(glb, c.motion);
    return out;
}

Json expressionsOf(GlbBuilder& glb, const AvatarData& a) {
    const ExpressionData& x = a.expressions;
    const bool own = x.firstNode > 0;  // nodes
    Json out = {{"encoding", own ? 2 : 1}, {"shapes", Json::array()}};
    for (const uint8_t shape : x.shapes) out["shapes"].push_back(kExpressionNames[shape]);
    if (own)
        out["nodeCount"] = a.correctives.nodeCount - x.firstNode;
    else if (!a.correctives.followsPose())
        out["nodeCount"] = a.correctives.nodeCount;
    auto stream = [&](const char* name, const std::vector<uint8_t>& bytes) {
        if (!bytes.empty()) out["streams"][name] = glb.addView(bytes);
    };
    const auto put = [&](const auto& streams) {
        stream("counts", streams.counts), stream("ranges", streams.ranges), stream("nodes", streams.nodes);
        stream("offsets", streams.offsets), stream("vertices", streams.vertices), stream("nodeIndices", streams.nodeIndices);
        stream("nodeWeights", streams.nodeWeights);
    };
    if (!own) {
        put(encodeExpressions(x, a.correctives));
        return out;
    }
    const auto streams = encodeFace(x, a.correctives);
    put(streams);
    stream("alone", streams.alone), stream("aloneNodes", streams.aloneNodes);
    return out;
}

Json splatsOf(GlbBuilder& glb, const AvatarData& a, const CodedSplats& coded, bool compact) {
    const auto streams = writeSplatStreams(coded, a.mesh.triangles.size(), compact);
    const bool palette = !coded.shIndex.empty();
    Json splats = {{"encoding", !streams.coded.empty() ? 3
                                : palette              ? 2
                                                       : 1},
                   {"count", coded.count()},
                   {"chunkSize", kSplatChunkSize},
                   {"shDegree", coded.shDegree},
                   {"shBasis", "3dgs-real"}};
    if (palette) splats["shPaletteSize"] = coded.sh.size() / shEntryBytes(coded.shDegree);
    if (!streams.coded.empty()) {
        const SplatBits bits = neededBits(coded);
        splats["bits"] = {{"uv", bits.uv}, {"phi", bits.phi}, {"scale", bits.scale}, {"opacity", bits.opacity}, {"colour", bits.colour}};
    }
    auto stream = [&](const char* name, const std::vector<uint8_t>& bytes) {
        if (!bytes.empty()) splats["streams"][name] = glb.addView(bytes);
    };
    splats["streams"] = Json::object();
    stream("triangleCounts", streams.triangleCounts), stream("chunks", streams.chunks), stream("place", streams.place);
    stream("size", streams.size), stream("colour", streams.colour), stream("shIndex", streams.shIndex);
    stream("ranges", streams.ranges), stream("coded", streams.coded), stream("sh", streams.sh);
    return splats;
}

Json avatarExtension(GlbBuilder& glb, const AvatarData& a, const CodedSplats& coded, bool compact) {
    Json ours = {{"version", versionOf(a)},
                 {"name", a.name},
                 {"contentHash", "xxh3:0000000000000000"},
                 {"units", "metre"},
                 {"handedness", "right"},
                 {"up", "+Y"},
                 {"front", "+Z"},
                 {"colourSpace", "srgb-display"},
                 {"kappaPx2", a.kappaPx2},
                 {"compensated", a.compensated},
                 {"skin", 0},
                 {"layers", Json::array()},
                 {"humanoidBones", Json::array()},
                 {"evidence", Json::array()}};
    if (a.trainedPixelM > 0) ours["trainedPixelM"] = a.trainedPixelM;
    for (size_t l = 0; l < a.mesh.layers.size(); ++l) ours["layers"].push_back({{"mesh", l}, {"role", a.mesh.layers[l].role}});
    for (size_t j = 0; j < a.joints.size(); ++j)
        if (!a.joints[j].humanoidBone.empty()) ours["humanoidBones"].push_back({{"bone", a.joints[j].humanoidBone}, {"joint", j}});
    for (const EvidenceData& e : a.evidence)
        ours["evidence"].push_back({{"part", e.part}, {"kept", e.kept}, {"gainDb", e.gainDb}, {"bytes", e.bytes}, {"reason", e.reason}});

    ours["splats"] = splatsOf(glb, a, coded, compact);
    if (a.correctives.followsPose())
        ours["poseCorrectives"] = poseCorrectives(glb, withoutFaceNodes(a.correctives, a.expressions), compact);
    if (!a.expressions.empty()) ours["expressions"] = expressionsOf(glb, a);
    if (!a.light.empty()) ours["light"] = {{"encoding", 1}, {"irradiance", a.light.irradiance}};
    if (!a.captureMap.empty())
        ours["captureMap"] = {{"encoding", 1}, {"streams", {{"sides", glb.addView(encodeCaptureMap(a.captureMap))}}}};
    return ours;
}

void writeHash(std::string& json, std::span<const uint8_t> bin) {
    const size_t at = findHashDigits(json);
    const std::string digits = contentHash(json, at, bin);
    std::copy(digits.begin(), digits.end(), json.begin() + ptrdiff_t(at));
}

}  // namespace

Result<std::vector<uint8_t>> writeAvatar(const AvatarData& avatar, const WriteOptions& options) try {
    DPL_RETURN_IF_ERROR(checkAvatar(avatar));
    AvatarData a = avatar;
    snapAvatar(a);
    DPL_TRY(CodedSplats coded, codeSplats(a.mesh, a.splats, options.shPalette));
    coarsenSplats(coded, options.bits);
    GlbBuilder glb;
    glb.root["asset"] = {{"version", "2.0"}, {"generator", a.generator}};
    glb.root["extensionsUsed"] = {"DPL_gaussian_avatar"};
    DPL_RETURN_IF_ERROR(addLayers(glb, a, {.draco = options.draco}));
    glb.root["extensions"]["DPL_gaussian_avatar"] = avatarExtension(glb, a, coded, options.compact);
    addSkeletonAndClips(glb, a);
    DPL_RETURN_IF_ERROR(checkGlbSize(glb));
    return glb.finish(writeHash);
} catch (const std::bad_alloc&) {
    return outOfMemory("write an avatar");
} catch (const std::exception& e) {
    return fail(Code::Internal, "the avatar could not be written: {}", e.what());
}

}  // namespace dpl
