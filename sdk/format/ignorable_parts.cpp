// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/ignorable_parts.h"

#include "sdk/format/capture_map.h"
#include "sdk/format/correctives.h"
#include "sdk/format/expressions.h"
#include "sdk/format/face_nodes.h"

namespace dpl {
namespace {

struct KnownPart {
    const nlohmann::json* fields = nullptr;  // null: it is not there, or of an encoding that we do not know
    uint64_t encoding = 0;
};

/** A part of encoding 1 to `newest`. */
Result<KnownPart> knownPart(const ExtensionFields& root, const char* name, uint64_t newest) {
    if (!root.has(name)) return KnownPart();
    DPL_TRY(const nlohmann::json* object, root.object(name));
    DPL_TRY(const uint64_t encoding, ExtensionFields(*object, name).number("encoding", 0xffffffffu));
    if (encoding == 0) return fail(Code::CorruptData, "{} encoding 0 does not exist", name);
    return encoding <= newest ? KnownPart{object, encoding} : KnownPart();
}

/** The shapes that we know, by their names. */
Result<std::vector<uint8_t>> shapesOf(const nlohmann::json& part) {
    const auto names = part.find("shapes");
    if (names == part.end() || !names->is_array() || names->size() > kExpressionCount)
        return fail(Code::CorruptData, "expressions: 'shapes' is not an array of at most {} names", kExpressionCount);
    std::vector<uint8_t> shapes;
    for (const nlohmann::json& name : *names) {
        const auto shape = name.is_string() ? expressionOf(name.get<std::string>()) : std::nullopt;
        if (!shape || name.get<std::string>() != kExpressionNames[*shape])
            return fail(Code::CorruptData, "expressions: shape {} is none of the {} names", shapes.size(), kExpressionCount);
        shapes.push_back(uint8_t(*shape));
    }
    return shapes;
}

/** Expressions with nodes of their own. Returns the bytes of their streams. */
Result<uint64_t> readFace(const ExtensionFields& fields, const nlohmann::json& streams, StreamReader stream, std::vector<uint8_t> shapes,
                          AvatarData& avatar) {
    FaceStreams<std::span<const uint8_t>> in;
    uint64_t bytes = 0;
    for (const auto& [name, to] : {std::pair("counts", &in.counts),
                                   {"ranges", &in.ranges},
                                   {"nodes", &in.nodes},
                                   {"offsets", &in.offsets},
                                   {"alone", &in.alone},
                                   {"aloneNodes", &in.aloneNodes},
                                   {"vertices", &in.vertices},
                                   {"nodeIndices", &in.nodeIndices},
                                   {"nodeWeights", &in.nodeWeights}}) {
        DPL_TRY(*to, stream(streams, name));
        bytes += to->size();
    }
    DPL_TRY(const uint64_t nodes, fields.number("nodeCount", kMaxCorrectiveNodes));
    DPL_RETURN_IF_ERROR(decodeFace(in, std::move(shapes), uint32_t(nodes), avatar));
    return bytes;
}

}  // namespace

Result<uint64_t> readExpressions(const ExtensionFields& root, StreamReader stream, AvatarData& avatar) {
    DPL_TRY(const KnownPart part, knownPart(root, "expressions", 2));
    if (part.fields == nullptr) return uint64_t(0);
    const ExtensionFields fields(*part.fields, "expressions");
    DPL_TRY(std::vector<uint8_t> shapes, shapesOf(*part.fields));
    if (shapes.empty()) return fail(Code::CorruptData, "expressions without shapes");
    DPL_TRY(const nlohmann::json* streams, fields.object("streams"));
    if (part.encoding == 2) return readFace(fields, *streams, stream, std::move(shapes), avatar);
    ExpressionStreams<std::span<const uint8_t>> in;
    DPL_TRY(in.counts, stream(*streams, "counts"));
    DPL_TRY(in.ranges, stream(*streams, "ranges"));
    DPL_TRY(in.nodes, stream(*streams, "nodes"));
    DPL_TRY(in.offsets, stream(*streams, "offsets"));
    DPL_TRY(in.vertices, stream(*streams, "vertices"));
    DPL_TRY(in.nodeIndices, stream(*streams, "nodeIndices"));
    DPL_TRY(in.nodeWeights, stream(*streams, "nodeWeights"));
    DPL_TRY(avatar.expressions, decodeExpressions(in, std::move(shapes)));
    if (avatar.correctives.empty()) {
        DPL_TRY(const uint64_t nodes, fields.number("nodeCount", kMaxCorrectiveNodes));
        if (nodes == 0) return fail(Code::CorruptData, "expressions without control nodes");
        DPL_TRY(avatar.correctives, decodeExpressionNodes(in, uint32_t(nodes), avatar.mesh.restPositions.size()));
    } else if (fields.has("nodeCount") || in.vertices.size() + in.nodeIndices.size() + in.nodeWeights.size() > 0) {
        return fail(Code::CorruptData, "expressions with control nodes of their own beside those of pose correctives");
    }
    return in.counts.size() + in.ranges.size() + in.nodes.size() + in.offsets.size() + in.vertices.size() + in.nodeIndices.size() +
           in.nodeWeights.size();
}

Result<uint64_t> readCaptureMap(const ExtensionFields& root, StreamReader stream, AvatarData& avatar) {
    DPL_TRY(const KnownPart part, knownPart(root, "captureMap", 1));
    if (part.fields == nullptr) return uint64_t(0);
    DPL_TRY(const nlohmann::json* streams, ExtensionFields(*part.fields, "captureMap").object("streams"));
    DPL_TRY(const auto sides, stream(*streams, "sides"));
    DPL_TRY(avatar.captureMap, decodeCaptureMap(sides, avatar.joints.size()));
    return sides.size();
}

}  // namespace dpl
