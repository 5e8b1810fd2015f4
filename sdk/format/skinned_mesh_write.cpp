// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/skinned_mesh_write.h"

#include <algorithm>

#include "sdk/format/draco_mesh.h"
#include "sdk/format/expression_names.h"
#include "sdk/format/vertex_colour.h"

namespace dpl {
namespace {

Json triple(const Vec3f& v) {
    return Json::array({v.x, v.y, v.z});
}

LayerMesh layerMesh(const MeshData& mesh, const LayerData& layer, bool wideJoints, const LayerOptions& options) {
    LayerMesh out;
    out.wideJoints = wideJoints;
    auto cut = [&](const auto& values, auto& to) {
        if (!values.empty()) to.assign(values.begin() + layer.firstVertex, values.begin() + layer.firstVertex + layer.vertexCount);
    };
    cut(mesh.restPositions, out.positions), cut(mesh.jointIndices, out.joints), cut(mesh.jointWeights, out.weights);
    cut(options.normals, out.normals), cut(options.texture.uv, out.uv);
    for (uint32_t v = 0; v < layer.vertexCount && out.uv.empty(); ++v) {
        const glm::u8vec4& c = mesh.colours[layer.firstVertex + v];
        out.colours.emplace_back(linearFromSrgb8(c.r), linearFromSrgb8(c.g), linearFromSrgb8(c.b), c.a * 257);
    }
    for (uint32_t t = 0; t < layer.triangleCount; ++t) out.triangles.push_back(mesh.triangles[layer.firstTriangle + t] - layer.firstVertex);
    return out;
}

/** A vertex attribute of glTF. */
struct Attribute {
    const char* name;
    uint32_t dracoId;
    int component;
    const char* type;
    bool normalized = false;
    int64_t view = -1;  // -1: Draco fills the accessor
};

/** The attributes that a layer has. glb: where their values go; null: Draco has them. */
std::vector<Attribute> attributesOf(const LayerMesh& m, GlbBuilder* glb) {
    std::vector<Attribute> out;
    auto add = [&](const auto& values, Attribute attribute) {
        if (values.empty()) return;
        if (glb) attribute.view = glb->addView(values, kGltfVertices);
        out.push_back(attribute);
    };
    add(m.positions, {"POSITION", kDracoPosition, kGltfF32, "VEC3"});
    add(m.normals, {"NORMAL", kDracoNormal, kGltfF32, "VEC3"});
    add(m.uv, {"TEXCOORD_0", kDracoUv, kGltfF32, "VEC2"});
    add(m.colours, {"COLOR_0", kDracoColour, kGltfU16, "VEC4", true});
    if (m.wideJoints)
        add(m.joints, {"JOINTS_0", kDracoJoints, kGltfU16, "VEC4"});
    else
        add(std::vector<glm::u8vec4>(m.joints.begin(), m.joints.end()), {"JOINTS_0", kDracoJoints, kGltfU8, "VEC4"});
    add(m.weights, {"WEIGHTS_0", kDracoWeights, kGltfU8, "VEC4", true});
    return out;
}

/** The colours of the one material. */
void addTexture(GlbBuilder& glb, const MeshTexture& texture) {
    constexpr int kLinear = 9729, kLinearMipmapLinear = 9987, kClampToEdge = 33071;
    glb.root["images"] = Json::array({{{"name", "colour"},
                                       {"mimeType", texture.jpeg ? "image/jpeg" : "image/png"},
                                       {"bufferView", glb.addView(std::vector<uint8_t>(texture.image.begin(), texture.image.end()))}}});
    glb.root["samplers"] =
        Json::array({{{"magFilter", kLinear}, {"minFilter", kLinearMipmapLinear}, {"wrapS", kClampToEdge}, {"wrapT", kClampToEdge}}});
    glb.root["textures"] = Json::array({{{"sampler", 0}, {"source", 0}}});
    glb.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
}

/** The entries of a morph for a layer. */
std::pair<size_t, size_t> entriesOf(const MeshMorph& morph, const LayerData& layer) {
    const auto at = [&](uint32_t vertex) {
        return size_t(std::lower_bound(morph.vertices.begin(), morph.vertices.end(), vertex) - morph.vertices.begin());
    };
    return {at(layer.firstVertex), at(layer.firstVertex + layer.vertexCount)};
}

/** Where the values of a target lie: of each vertex, or of those in a view of indices. */
struct TargetPlaces {
    uint32_t vertexCount = 0;
    std::span<const uint32_t> vertices;  // of the layer
    int64_t indexView = -1;              // -1: each vertex has a value
    int indexComponent = kGltfU16;
};

/** Adds an accessor of a target. */
uint32_t addTarget(GlbBuilder& glb, const TargetPlaces& places, std::span<const Vec3f> values) {
    const bool sparse = places.indexView >= 0;
    std::vector<Vec3f> all;
    if (!sparse) {
        all.assign(places.vertexCount, Vec3f(0));
        for (size_t i = 0; i < values.size(); ++i) all[places.vertices[i]] = values[i];
        values = all;
    }
    const uint32_t view = glb.addView(std::span(reinterpret_cast<const uint8_t*>(values.data()), values.size_bytes()));
    Json& accessor = glb.addAccessor(sparse ? -1 : int64_t(view), kGltfF32, "VEC3", places.vertexCount);
    if (sparse)
        accessor["sparse"] = {{"count", values.size()},
                              {"indices", {{"bufferView", places.indexView}, {"componentType", places.indexComponent}}},
                              {"values", {{"bufferView", view}}}};
    Vec3f low = values.front(), high = low;
    if (values.size() < places.vertexCount) low = high = Vec3f(0);
    for (const Vec3f& v : values) low = glm::min(low, v), high = glm::max(high, v);
    accessor["min"] = triple(low), accessor["max"] = triple(high);
    return glb.lastAccessor();
}

/** Adds the morph targets of a layer, sparse where that takes fewer bytes. */
void addTargets(GlbBuilder& glb, std::span<const MeshMorph> morphs, const LayerData& layer, Json& mesh) {
    Json names = Json::array(), targets = Json::array();
    for (const MeshMorph& morph : morphs) {
        if (!movesLayer(morph, layer)) continue;
        const auto [begin, end] = entriesOf(morph, layer);
        std::vector<uint32_t> vertices(morph.vertices.begin() + ptrdiff_t(begin), morph.vertices.begin() + ptrdiff_t(end));
        for (uint32_t& vertex : vertices) vertex -= layer.firstVertex;
        TargetPlaces places{layer.vertexCount, vertices};
        const bool wide = layer.vertexCount > 1u << 16;
        constexpr size_t kValues = 2 * sizeof(Vec3f);
        if (vertices.size() * (kValues + (wide ? 4 : 2)) < layer.vertexCount * kValues) {
            places.indexComponent = wide ? kGltfU32 : kGltfU16;
            places.indexView = wide ? glb.addView(vertices) : glb.addView(std::vector<uint16_t>(vertices.begin(), vertices.end()));
        }
        Json target;
        target["POSITION"] = addTarget(glb, places, std::span(morph.offsetsM).subspan(begin, end - begin));
        target["NORMAL"] = addTarget(glb, places, std::span(morph.turns).subspan(begin, end - begin));
        targets.push_back(std::move(target)), names.push_back(kExpressionNames[morph.expression]);
    }
    if (targets.empty()) return;
    mesh["weights"] = std::vector<int>(targets.size(), 0);
    mesh["extras"]["targetNames"] = std::move(names);
    mesh["primitives"][0]["targets"] = std::move(targets);
}

Status addLayer(GlbBuilder& glb, const MeshData& mesh, const LayerData& layer, bool wideJoints, const LayerOptions& options) {
    const LayerMesh m = layerMesh(mesh, layer, wideJoints, options);
    Json primitive = {{"mode", 4}, {"material", 0}};
    const std::vector<Attribute> attributes = attributesOf(m, options.draco ? nullptr : &glb);
    int64_t indices = -1;
    if (options.draco) {
        DPL_TRY(const std::vector<uint8_t> bytes, encodeDraco(m));
        Json& draco = primitive["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", glb.addView(bytes)}};
        for (const Attribute& attribute : attributes) draco["attributes"][attribute.name] = attribute.dracoId;
    } else {
        indices = glb.addView(m.triangles, kGltfIndices);
    }
    for (const Attribute& attribute : attributes) {
        Json& accessor = glb.addAccessor(attribute.view, attribute.component, attribute.type, m.positions.size(), attribute.normalized);
        if (attribute.dracoId == kDracoPosition) {
            Vec3f low = m.positions.front(), high = low;
            for (const Vec3f& p : m.positions) low = glm::min(low, p), high = glm::max(high, p);
            accessor["min"] = triple(low), accessor["max"] = triple(high);
        }
        primitive["attributes"][attribute.name] = glb.lastAccessor();
    }
    glb.addAccessor(indices, kGltfU32, "SCALAR", m.triangles.size() * 3);
    primitive["indices"] = glb.lastAccessor();
    Json written = {{"name", layer.name}, {"primitives", Json::array({std::move(primitive)})}};
    addTargets(glb, options.morphs, layer, written);
    glb.root["meshes"].push_back(std::move(written));
    return {};
}

/** Nodes 0..J−1 are the joints, the nodes after them the layers. Layers are root nodes, so that no transform applies to skinned meshes. */
void addNodesAndSkin(GlbBuilder& glb, const AvatarData& a) {
    Json nodes = Json::array(), roots = Json::array({0}), joints = Json::array();
    std::vector<Mat4f> inverseBind;
    for (size_t j = 0; j < a.joints.size(); ++j) {
        const JointData& joint = a.joints[j];
        const Vec3f parent = joint.parent < 0 ? Vec3f(0) : a.joints[joint.parent].restPosition;
        nodes.push_back({{"name", joint.name}, {"translation", triple(joint.restPosition - parent)}});
        if (joint.parent >= 0) nodes[joint.parent]["children"].push_back(j);
        joints.push_back(j);
        Mat4f bind(1);
        bind[3] = Vec4f(Vec3f(0) - joint.restPosition, 1);
        inverseBind.push_back(bind);
    }
    for (size_t l = 0; l < a.mesh.layers.size(); ++l) {
        roots.push_back(nodes.size());
        nodes.push_back({{"name", a.mesh.layers[l].name}, {"mesh", l}, {"skin", 0}});
    }
    glb.root["nodes"] = std::move(nodes);
    glb.addAccessor(glb.addView(inverseBind), kGltfF32, "MAT4", inverseBind.size());
    glb.root["skins"] = Json::array({{{"joints", std::move(joints)}, {"skeleton", 0}, {"inverseBindMatrices", glb.lastAccessor()}}});
    glb.root["scenes"] = Json::array({{{"name", a.name}, {"nodes", std::move(roots)}}});
    glb.root["scene"] = 0;
}

void addClip(GlbBuilder& glb, const AvatarData& a, const ClipData& clip) {
    Json samplers = Json::array(), channels = Json::array();
    Json& times = glb.addAccessor(glb.addView(clip.timesS), kGltfF32, "SCALAR", clip.timesS.size());
    times["min"] = Json::array({clip.timesS.front()}), times["max"] = Json::array({clip.timesS.back()});
    const uint32_t input = glb.lastAccessor();
    auto add = [&](uint32_t node, const char* path) {
        channels.push_back({{"sampler", samplers.size()}, {"target", {{"node", node}, {"path", path}}}});
        samplers.push_back({{"input", input}, {"output", glb.lastAccessor()}, {"interpolation", "LINEAR"}});
    };
    for (const ClipChannel& channel : clip.channels) {
        std::vector<Vec4f> xyzw;
        for (const Quatf& q : channel.rotations) xyzw.emplace_back(q.x, q.y, q.z, q.w);
        glb.addAccessor(glb.addView(xyzw), kGltfF32, "VEC4", xyzw.size());
        add(channel.joint, "rotation");
    }
    if (!clip.rootTranslations.empty()) {
        std::vector<Vec3f> places;
        for (const Vec3f& t : clip.rootTranslations) places.push_back(t + a.joints[0].restPosition);
        glb.addAccessor(glb.addView(places), kGltfF32, "VEC3", places.size());
        add(0, "translation");
    }
    glb.root["animations"].push_back({{"name", clip.name}, {"samplers", std::move(samplers)}, {"channels", std::move(channels)}});
}

}  // namespace

bool movesLayer(const MeshMorph& morph, const LayerData& layer) {
    const auto [begin, end] = entriesOf(morph, layer);
    return begin < end;
}

Status addLayers(GlbBuilder& glb, const AvatarData& avatar, const LayerOptions& options) {
    const MeshData& mesh = avatar.mesh;
    if (mesh.layers.empty()) return {};
    // The colours contain the light of the scan, so viewers must not light them again.
    glb.root["extensionsUsed"].push_back("KHR_materials_unlit");
    glb.root["materials"] = Json::array({{{"name", "captured"},
                                          {"doubleSided", true},
                                          {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}},
                                          {"extensions", {{"KHR_materials_unlit", Json::object()}}}}});
    if (!options.texture.uv.empty()) addTexture(glb, options.texture);
    if (options.draco) {
        glb.root["extensionsUsed"].push_back("KHR_draco_mesh_compression");
        glb.root["extensionsRequired"] = {"KHR_draco_mesh_compression"};
    }
    for (const LayerData& layer : mesh.layers) DPL_RETURN_IF_ERROR(addLayer(glb, mesh, layer, avatar.joints.size() > 256, options));
    return {};
}

void addSkeletonAndClips(GlbBuilder& glb, const AvatarData& avatar) {
    addNodesAndSkin(glb, avatar);
    for (const ClipData& clip : avatar.clips) addClip(glb, avatar, clip);
}

Status checkGlbSize(const GlbBuilder& glb) {
    if (glb.bin().size() > (1ull << 31) - (64u << 20))
        return fail(Code::Unsupported, "the avatar has {} bytes, more than a .glb that every reader takes", glb.bin().size());
    return {};
}

}  // namespace dpl
