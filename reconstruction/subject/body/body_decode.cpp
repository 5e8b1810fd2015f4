// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>

#include "reconstruction/subject/body/body_io.h"
#include "reconstruction/subject/body/body_tools.h"
#include "sdk/avatar/humanoid.h"
#include "sdk/core/files.h"
#include "sdk/format/expression_names.h"
#include "sdk/format/skin_weights.h"
#include "sdk/format/skinned_gltf.h"

namespace dpl {
namespace {

using Json = nlohmann::json;

/** mesh.extras.doppelBody of a file from encodeBody(). readSkinnedGltf has already checked the container and the JSON's size and depth. */
std::optional<Json> findExtras(std::span<const uint8_t> bytes) {
    uint32_t jsonBytes = 0;
    if (bytes.size() < 20) return std::nullopt;
    std::memcpy(&jsonBytes, bytes.data() + 12, 4);
    if (jsonBytes > bytes.size() - 20) return std::nullopt;
    const Json root = Json::parse(bytes.begin() + 20, bytes.begin() + 20 + jsonBytes, nullptr, false);
    if (!root.is_object()) return std::nullopt;
    const Json::json_pointer place("/meshes/0/extras/doppelBody");
    if (!root.contains(place) || !root.at(place).is_object()) return std::nullopt;
    return root.at(place);
}

bool readVec3(const Json& json, Vec3f& v) {
    if (!json.is_array() || json.size() != 3) return false;
    for (int i = 0; i < 3; ++i) {
        if (!json[size_t(i)].is_number()) return false;
        v[i] = json[size_t(i)].get<float>();
    }
    return true;
}

bool readWeights(const Json& json, std::vector<std::pair<uint32_t, float>>& weights) {
    if (!json.is_array()) return false;
    for (const Json& pair : json) {
        if (!pair.is_array() || pair.size() != 2 || !pair[0].is_number_unsigned() || !pair[1].is_number()) return false;
        weights.emplace_back(pair[0].get<uint32_t>(), pair[1].get<float>());
    }
    return true;
}

uint32_t u32(const Json& object, const char* key) {
    const auto it = object.find(key);
    return it != object.end() && it->is_number_unsigned() && it->get<uint64_t>() <= UINT32_MAX ? it->get<uint32_t>() : 0;
}

std::string text(const Json& object, const char* key) {
    const auto it = object.find(key);
    return it != object.end() && it->is_string() ? it->get<std::string>() : std::string();
}

/** Replaces imported values by those in the extras. False when the extras do not match the mesh, as after an edit of the file. */
bool applyExtras(const Json& extras, BodyModel& body) {
    const auto list = [&](const char* key) {
        const auto it = extras.find(key);
        return it != extras.end() && it->is_array() ? &*it : nullptr;
    };
    const Json *positions = list("jointPositions"), *humanoid = list("humanoidBones"), *morphs = list("morphs"),
               *keypoints = list("keypoints"), *layers = list("layers");
    if (!positions || !humanoid || !morphs || !keypoints || !layers || u32(extras, "version") != 1) return false;
    if (positions->size() != body.joints.size() || humanoid->size() != body.joints.size() || morphs->size() != body.morphs.size())
        return false;
    if (const std::string name = text(extras, "name"); !name.empty()) body.name = name;
    for (size_t j = 0; j < body.joints.size(); ++j) {
        if (!readVec3((*positions)[j], body.joints[j].restPosition) || !(*humanoid)[j].is_string()) return false;
        body.joints[j].humanoidBone = (*humanoid)[j].get<std::string>();
    }
    for (size_t m = 0; m < body.morphs.size(); ++m) {
        const Json& json = (*morphs)[m];
        ShapeMorph& morph = body.morphs[m];
        if (!json.is_object() || text(json, "name") != morph.name || !json.contains("min") || !json.contains("max") ||
            !json["min"].is_number() || !json["max"].is_number())
            return false;
        morph.minValue = json["min"].get<float>();
        morph.maxValue = json["max"].get<float>();
        const auto offsets = json.find("jointOffsets");
        if (offsets == json.end() || !offsets->is_array() || offsets->size() != body.joints.size()) return false;
        for (size_t j = 0; j < body.joints.size(); ++j)
            if (!readVec3((*offsets)[j], morph.jointOffsets[j])) return false;
    }
    body.keypoints.clear();
    for (const Json& json : *keypoints) {
        BodyKeypoint k;
        if (!json.is_object() || !json.contains("vertices") || !json.contains("joints")) return false;
        k.name = text(json, "name");
        if (!readWeights(json["vertices"], k.vertices) || !readWeights(json["joints"], k.joints)) return false;
        body.keypoints.push_back(std::move(k));
    }
    body.mesh.layers.clear();
    for (const Json& json : *layers) {
        if (!json.is_object()) return false;
        body.mesh.layers.push_back({text(json, "name"), text(json, "role"), u32(json, "firstVertex"), u32(json, "vertexCount"),
                                    u32(json, "firstTriangle"), u32(json, "triangleCount")});
    }
    return true;
}

/** Whether a file says that a morph with the name of an expression shapes the body: one that was written before bodies had expressions. */
bool isShapeMorph(const std::optional<Json>& extras, const std::string& name) {
    if (!extras || !extras->contains("morphs") || !extras->at("morphs").is_array()) return false;
    const Json& morphs = extras->at("morphs");
    return std::any_of(morphs.begin(), morphs.end(), [&](const Json& m) { return m.is_object() && text(m, "name") == name; });
}

/** The body's expression of this number, which is added where it is missing. They stay in rising order. */
ExpressionShape& expressionNumbered(size_t number, BodyModel& body) {
    const auto at = std::find_if(body.expressions.begin(), body.expressions.end(),
                                 [&](const ExpressionShape& shape) { return shape.expression >= number; });
    if (at != body.expressions.end() && at->expression == number) return *at;
    return *body.expressions.insert(at, {uint8_t(number), {}});
}

/** The joints under one root, parents first, and the new index of each glTF joint. The skin's order is kept when it already has parents
 *  first, as in files from encodeBody(); otherwise the order is that of the node tree. */
Status readJoints(const SkinnedGltf& gltf, std::span<const Mat4f> sceneFromNode, BodyModel& body, std::vector<uint32_t>& jointOfGltfJoint) {
    std::vector<bool> isJoint(gltf.nodes.size(), false);
    std::vector<uint32_t> order;
    for (const SkinnedGltf::Joint& j : gltf.joints) {
        if (!isJoint[j.node]) order.push_back(j.node);
        isJoint[j.node] = true;
    }
    std::vector<int32_t> parentNode(gltf.nodes.size(), -1);  // nearest ancestor that is a joint
    for (uint32_t n : order) {
        int32_t up = gltf.nodes[n].parent;
        while (up >= 0 && !isJoint[size_t(up)]) up = gltf.nodes[size_t(up)].parent;
        parentNode[n] = up;
    }
    std::vector<int32_t> place(gltf.nodes.size(), -1);
    for (uint32_t i = 0; i < order.size(); ++i) place[order[i]] = int32_t(i);
    const bool parentsFirst =
        std::all_of(order.begin(), order.end(), [&](uint32_t n) { return parentNode[n] < 0 || place[size_t(parentNode[n])] < place[n]; });
    if (!parentsFirst) {
        std::sort(order.begin(), order.end());  // ascending node index: parents come first
        for (uint32_t i = 0; i < order.size(); ++i) place[order[i]] = int32_t(i);
    }
    for (uint32_t n : order) {
        if (parentNode[n] < 0 && !body.joints.empty())
            return fail(Code::Unsupported, "body '{}': joints '{}' and '{}' are both roots; put the skeleton under one root joint",
                        body.name, body.joints[0].name, gltf.nodes[n].name);
        body.joints.push_back({gltf.nodes[n].name, parentNode[n] < 0 ? -1 : place[size_t(parentNode[n])], Vec3f(sceneFromNode[n][3]),
                               gltf.nodes[n].humanoidBone});
    }
    for (const SkinnedGltf::Joint& j : gltf.joints) jointOfGltfJoint.push_back(uint32_t(place[j.node]));
    return {};
}

/** Up to rounding. */
bool isIdentity(const Mat4f& m) {
    constexpr float kRounding = 1e-4f;
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r)
            if (!(std::abs(m[c][r] - (c == r ? 1.0f : 0.0f)) < kRounding)) return false;
    return true;
}

}  // namespace

Result<BodyModel> decodeBody(std::span<const uint8_t> bytes, std::string_view name) {
    DPL_TRY(const SkinnedGltf gltf, readSkinnedGltf(bytes));
    BodyModel body;
    body.name = std::string(name);
    const std::vector<Mat4f> sceneFromNode = gltf.restTransforms();
    std::vector<uint32_t> jointOfGltfJoint;
    DPL_RETURN_IF_ERROR(readJoints(gltf, sceneFromNode, body, jointOfGltfJoint));

    // A vertex is placed by the skin at the node tree's rest pose: Σ w · sceneFromNode · jointFromMesh · v. In files from encodeBody() this
    // is the identity up to rounding, so their positions are kept as stored. An optimiser that quantised them has changed the matrices.
    const std::optional<Json> extras = findExtras(bytes);
    std::vector<Mat4f> sceneFromMesh;
    for (const SkinnedGltf::Joint& j : gltf.joints) sceneFromMesh.push_back(sceneFromNode[j.node] * j.jointFromMesh);
    const bool asStored = extras && std::all_of(sceneFromMesh.begin(), sceneFromMesh.end(), isIdentity);
    MeshData& mesh = body.mesh;
    for (const SkinnedGltf::Mesh& part : gltf.meshes) {
        if (!part.skinned) continue;
        const uint32_t first = uint32_t(mesh.restPositions.size());
        const LayerData layer{part.name.empty() ? formatText("layer{}", mesh.layers.size()) : part.name,
                              mesh.layers.empty() ? "body" : "garment",
                              first,
                              uint32_t(part.positions.size()),
                              uint32_t(mesh.triangles.size()),
                              uint32_t(part.triangles.size())};
        std::vector<Mat4f> blend(part.positions.size(), Mat4f(1));
        for (size_t v = 0; v < part.positions.size(); ++v) {
            std::vector<std::pair<uint32_t, float>> influences;
            Mat4f m(0.0f);
            for (int i = 0; i < 4; ++i) {
                const uint32_t joint = part.jointIndices[v][i];
                if (joint >= gltf.joints.size())
                    return fail(Code::CorruptData, "body '{}': a vertex follows joint {}; the file has {} joints", name, joint,
                                gltf.joints.size());
                m += part.jointWeights[v][i] * sceneFromMesh[joint];
                influences.emplace_back(jointOfGltfJoint[joint], part.jointWeights[v][i]);
            }
            if (!asStored) blend[v] = m;
            const PackedWeights packed = packWeights(influences);
            mesh.jointIndices.push_back(packed.joints);
            mesh.jointWeights.push_back(packed.weights);
            mesh.restPositions.push_back(asStored ? part.positions[v] : Vec3f(m * Vec4f(part.positions[v], 1)));
            const Vec4f colour = part.colours.empty() ? Vec4f(0.8f, 0.7f, 0.6f, 1) : part.colours[v];
            mesh.colours.push_back(glm::u8vec4(glm::clamp(Vec3f(colour), 0.0f, 1.0f) * 255.0f + 0.5f, 255));
        }
        for (const glm::uvec3& t : part.triangles) mesh.triangles.push_back(t + first);
        for (const SkinnedGltf::Morph& m : part.morphs) {
            if (const auto expression = expressionOf(m.name); expression && !isShapeMorph(extras, m.name)) {
                std::vector<Vec3f>& offsets = expressionNumbered(*expression, body).offsetsM;
                offsets.resize(first, Vec3f(0));
                for (size_t v = 0; v < m.offsets.size(); ++v) offsets.push_back(Mat3f(blend[v]) * m.offsets[v]);
                continue;
            }
            auto morph = std::find_if(body.morphs.begin(), body.morphs.end(), [&](const ShapeMorph& s) { return s.name == m.name; });
            if (morph == body.morphs.end()) {
                body.morphs.push_back({m.name, -1, 1, {}, std::vector<Vec3f>(body.joints.size(), Vec3f(0))});
                morph = body.morphs.end() - 1;
            }
            morph->vertexOffsets.resize(first, Vec3f(0));
            for (size_t v = 0; v < m.offsets.size(); ++v) morph->vertexOffsets.push_back(Mat3f(blend[v]) * m.offsets[v]);
        }
        mesh.layers.push_back(layer);
    }
    for (ShapeMorph& m : body.morphs) m.vertexOffsets.resize(mesh.restPositions.size(), Vec3f(0));
    for (ExpressionShape& shape : body.expressions) shape.offsetsM.resize(mesh.restPositions.size(), Vec3f(0));

    if (extras) {
        if (!applyExtras(*extras, body))
            return fail(Code::CorruptData, "body '{}': its doppelBody extras do not fit its mesh; write it again with `doppel body import`",
                        name);
    } else {
        assignHumanoidBones(body.joints);
        body.keypoints = deriveKeypoints(body);
        body = withBoneMorphs(std::move(body));  // glTF morphs do not move joints
    }
    DPL_RETURN_IF_ERROR(checkBody(body));
    return body;
}

Result<BodyModel> readBody(const std::filesystem::path& path) {
    constexpr size_t kMaxBodyBytes = size_t(2) << 30;
    DPL_TRY(const auto bytes, readFile(path, kMaxBodyBytes));
    auto body = decodeBody(bytes, path.stem().string());
    if (!body) return fail(body.error().code, "{}: {}", path.string(), body.error().message);
    return body;
}

}  // namespace dpl
