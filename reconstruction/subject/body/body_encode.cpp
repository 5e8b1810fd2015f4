// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "reconstruction/subject/body/body_io.h"
#include "reconstruction/subject/body/body_tools.h"
#include "sdk/core/files.h"
#include "sdk/core/writer.h"
#include "sdk/format/expression_names.h"

namespace dpl {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr int kByte = 5121, kShort = 5123, kInt = 5125, kFloat = 5126;
constexpr int kArrayBuffer = 34962, kElementBuffer = 34963;

/** Appends arrays to the binary chunk and describes them in bufferViews and accessors. */
class Accessors {
public:
    template <class T>
    int add(std::span<const T> values, int componentType, const char* type, bool normalised, int target) {
        binary_.alignTo(4);
        OrderedJson view = {{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", values.size_bytes()}};
        if (target) view["target"] = target;
        views.push_back(view);
        binary_.append({reinterpret_cast<const uint8_t*>(values.data()), values.size_bytes()});
        OrderedJson accessor = {
            {"bufferView", views.size() - 1}, {"componentType", componentType}, {"count", values.size()}, {"type", type}};
        if (normalised) accessor["normalized"] = true;
        accessors.push_back(accessor);
        return int(accessors.size()) - 1;
    }
    /** glTF requires min and max for positions and morph offsets. */
    int addVec3(std::span<const Vec3f> values) {
        const int index = add(values, kFloat, "VEC3", false, kArrayBuffer);
        Vec3f low(std::numeric_limits<float>::infinity()), high = -low;
        for (const Vec3f& v : values) low = glm::min(low, v), high = glm::max(high, v);
        accessors.back()["min"] = {low.x, low.y, low.z};
        accessors.back()["max"] = {high.x, high.y, high.z};
        return index;
    }
    std::vector<uint8_t> finish() {
        binary_.alignTo(4);
        return binary_.finish();
    }
    OrderedJson views = OrderedJson::array(), accessors = OrderedJson::array();

private:
    Writer binary_;
};

OrderedJson weightList(const std::vector<std::pair<uint32_t, float>>& weights) {
    OrderedJson list = OrderedJson::array();
    for (const auto& [index, weight] : weights) list.push_back({index, weight});
    return list;
}

OrderedJson bodyExtras(const BodyModel& body) {
    OrderedJson morphs = OrderedJson::array(), keypoints = OrderedJson::array(), layers = OrderedJson::array(),
                humanoid = OrderedJson::array();
    for (const ShapeMorph& m : body.morphs) {
        OrderedJson offsets = OrderedJson::array();
        for (const Vec3f& o : m.jointOffsets) offsets.push_back({o.x, o.y, o.z});
        morphs.push_back({{"name", m.name}, {"min", m.minValue}, {"max", m.maxValue}, {"jointOffsets", std::move(offsets)}});
    }
    for (const BodyKeypoint& k : body.keypoints)
        keypoints.push_back({{"name", k.name}, {"vertices", weightList(k.vertices)}, {"joints", weightList(k.joints)}});
    for (const LayerData& l : body.mesh.layers)
        layers.push_back({{"name", l.name},
                          {"role", l.role},
                          {"firstVertex", l.firstVertex},
                          {"vertexCount", l.vertexCount},
                          {"firstTriangle", l.firstTriangle},
                          {"triangleCount", l.triangleCount}});
    OrderedJson positions = OrderedJson::array();  // exact values: node translations are differences and would round
    for (const JointData& j : body.joints) {
        humanoid.push_back(j.humanoidBone);
        positions.push_back({j.restPosition.x, j.restPosition.y, j.restPosition.z});
    }
    return {{"version", 1},     {"name", body.name},      {"humanoidBones", humanoid}, {"jointPositions", positions},
            {"morphs", morphs}, {"keypoints", keypoints}, {"layers", layers}};
}

}  // namespace

Result<std::vector<uint8_t>> encodeBody(const BodyModel& body) {
    DPL_RETURN_IF_ERROR(checkBody(body));
    const MeshData& mesh = body.mesh;
    Accessors data;
    OrderedJson attributes;
    attributes["POSITION"] = data.addVec3(mesh.restPositions);
    if (mesh.colours.size() == mesh.restPositions.size())
        attributes["COLOR_0"] = data.add<glm::u8vec4>(mesh.colours, kByte, "VEC4", true, kArrayBuffer);
    attributes["JOINTS_0"] = data.add<glm::u16vec4>(mesh.jointIndices, kShort, "VEC4", false, kArrayBuffer);
    attributes["WEIGHTS_0"] = data.add<glm::u8vec4>(mesh.jointWeights, kByte, "VEC4", true, kArrayBuffer);
    const int indices = data.add<uint32_t>({reinterpret_cast<const uint32_t*>(mesh.triangles.data()), mesh.triangles.size() * 3}, kInt,
                                           "SCALAR", false, kElementBuffer);
    OrderedJson targets = OrderedJson::array(), targetNames = OrderedJson::array(), weights = OrderedJson::array();
    for (const ShapeMorph& m : body.morphs) {
        targets.push_back({{"POSITION", data.addVec3(m.vertexOffsets)}});
        targetNames.push_back(m.name);
        weights.push_back(0);
    }
    for (const ExpressionShape& shape : body.expressions) {
        targets.push_back({{"POSITION", data.addVec3(shape.offsetsM)}});
        targetNames.push_back(kExpressionNames[shape.expression]);
        weights.push_back(0);
    }
    std::vector<Mat4f> inverseBinds;
    for (const JointData& j : body.joints) {
        Mat4f m(1.0f);
        m[3] = Vec4f(-j.restPosition, 1);
        inverseBinds.push_back(m);
    }
    const int inverseBindAccessor = data.add<Mat4f>(inverseBinds, kFloat, "MAT4", false, 0);

    // Nodes 0 … J−1 are the joints, node J carries the mesh.
    OrderedJson nodes = OrderedJson::array(), jointList = OrderedJson::array();
    for (size_t j = 0; j < body.joints.size(); ++j) {
        const JointData& joint = body.joints[j];
        const Vec3f offset = joint.restPosition - (joint.parent >= 0 ? body.joints[size_t(joint.parent)].restPosition : Vec3f(0));
        OrderedJson node = {{"name", joint.name}, {"translation", {offset.x, offset.y, offset.z}}};
        OrderedJson children = OrderedJson::array();
        for (size_t c = j + 1; c < body.joints.size(); ++c)
            if (body.joints[c].parent == int32_t(j)) children.push_back(c);
        if (!children.empty()) node["children"] = children;
        nodes.push_back(node);
        jointList.push_back(j);
    }
    nodes.push_back({{"name", body.name.empty() ? "body" : body.name}, {"mesh", 0}, {"skin", 0}});

    OrderedJson primitive = {{"attributes", attributes}, {"indices", indices}, {"mode", 4}};
    OrderedJson meshJson = {{"name", body.name.empty() ? "body" : body.name}};
    OrderedJson extras = {{"doppelBody", bodyExtras(body)}};
    if (!targets.empty()) {
        primitive["targets"] = targets;
        meshJson["weights"] = weights;
        extras["targetNames"] = targetNames;
    }
    meshJson["primitives"] = OrderedJson::array({primitive});
    meshJson["extras"] = extras;
    std::vector<uint8_t> binary = data.finish();
    const OrderedJson root = {
        {"asset", {{"version", "2.0"}, {"generator", "Doppel body"}}},
        {"scene", 0},
        {"scenes", OrderedJson::array({{{"nodes", {0, body.joints.size()}}}})},
        {"nodes", nodes},
        {"meshes", OrderedJson::array({meshJson})},
        {"skins", OrderedJson::array({{{"joints", jointList}, {"skeleton", 0}, {"inverseBindMatrices", inverseBindAccessor}}})},
        {"buffers", OrderedJson::array({{{"byteLength", binary.size()}}})},
        {"bufferViews", data.views},
        {"accessors", data.accessors}};
    std::string text = root.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
    while (text.size() % 4) text.push_back(' ');

    Writer file;
    const auto chunk = [&](uint32_t type, std::span<const uint8_t> bytes) {
        file.value(uint32_t(bytes.size()));
        file.value(type);
        file.append(bytes);
    };
    file.value(uint32_t(0x46546C67));  // "glTF"
    file.value(uint32_t(2));
    file.value(uint32_t(12 + 8 + text.size() + 8 + binary.size()));
    chunk(0x4E4F534A, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});  // "JSON"
    chunk(0x004E4942, binary);                                                        // "BIN\0"
    return file.finish();
}

Status writeBody(const BodyModel& body, const std::filesystem::path& path) {
    DPL_TRY(const auto bytes, encodeBody(body));
    return writeFileAtomically(path, bytes);
}

}  // namespace dpl
