// SPDX-License-Identifier: Apache-2.0
// The only translation unit with tinygltf. It passes a JSON of known keys and a buffer of four zero bytes, never the file's binary chunk:
//  - tinygltf would copy the chunk; Doppel reads from the caller's bytes;
//  - tinygltf's Draco code dereferences unknown attribute ids and writes attributes of five components past an array of four. Draco data
//    therefore goes through draco_mesh.h, and TINYGLTF_ENABLE_DRACO stays off.
#include "sdk/format/tiny_gltf_parse.h"

#include <fstream>                 // tiny_gltf.h forgets it under TINYGLTF_NO_FS
#include "sdk/format/load_json.h"  // before tiny_gltf.h, for the namespace of its values

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#include <tiny_gltf.h>
#pragma GCC diagnostic pop

namespace dpl {
namespace {

bool refuseImage(tinygltf::Image*, const int, std::string* error, std::string*, int, int, const unsigned char*, int, void*) {
    if (error) *error += "images are not read";
    return false;
}

std::string glbAround(std::string json) {
    while (json.size() % 4) json.push_back(' ');
    std::string glb("glTF\2\0\0\0", 8);
    auto word = [&](uint32_t value) { glb.append(reinterpret_cast<const char*>(&value), 4); };
    word(uint32_t(12 + 8 + json.size() + 8 + 4));
    word(uint32_t(json.size())), word(0x4E4F534A), glb += json;
    word(4), word(0x004E4942), word(0);
    return glb;
}

Quatf quaternionOf(const std::vector<double>& v) {
    return v.size() == 4 ? Quatf(float(v[3]), float(v[0]), float(v[1]), float(v[2])) : Quatf(1, 0, 0, 0);
}
Vec3f vectorOf(const std::vector<double>& v, float otherwise) {
    return v.size() == 3 ? Vec3f(v[0], v[1], v[2]) : Vec3f(otherwise);
}

/** Splits a matrix into T·R·S; shear is lost. */
void decompose(const std::vector<double>& m, GltfNode& node) {
    Mat3f r;
    for (int c = 0; c < 3; ++c) r[c] = Vec3f(m[c * 4], m[c * 4 + 1], m[c * 4 + 2]);
    node.translation = Vec3f(m[12], m[13], m[14]);
    node.scale = Vec3f(glm::length(r[0]), glm::length(r[1]), glm::length(r[2]));
    if (glm::determinant(r) < 0) node.scale.x = -node.scale.x;
    for (int c = 0; c < 3; ++c) r[c] = node.scale[c] != 0 ? r[c] / node.scale[c] : Vec3f(c == 0, c == 1, c == 2);
    node.rotation = glm::quat_cast(r);
}

GltfNode convertNode(const tinygltf::Node& from) {
    GltfNode node;
    node.name = from.name, node.mesh = from.mesh, node.skin = from.skin;
    for (int child : from.children) node.children.push_back(uint32_t(child));
    if (from.matrix.size() == 16) {
        decompose(from.matrix, node);
    } else {
        node.translation = vectorOf(from.translation, 0), node.scale = vectorOf(from.scale, 1), node.rotation = quaternionOf(from.rotation);
    }
    return node;
}

GltfMesh convertMesh(const tinygltf::Mesh& from) {
    GltfMesh mesh;
    mesh.name = from.name;
    for (double w : from.weights) mesh.weights.push_back(float(w));
    for (const tinygltf::Primitive& p : from.primitives) {
        GltfPrimitive& to = mesh.primitives.emplace_back();
        for (const auto& [semantic, accessor] : p.attributes) to.attributes[semantic] = uint32_t(accessor);
        for (const auto& target : p.targets) {
            auto& entry = to.targets.emplace_back();
            for (const auto& [semantic, accessor] : target) entry[semantic] = uint32_t(accessor);
        }
        to.indices = p.indices, to.mode = p.mode;
    }
    return mesh;
}

GltfAccessor convertAccessor(const tinygltf::Accessor& from) {
    GltfAccessor a;
    a.view = from.bufferView, a.offset = from.byteOffset, a.component = GltfComponent(from.componentType), a.normalized = from.normalized;
    a.components = from.type == TINYGLTF_TYPE_MAT4                                      ? 16
                   : from.type >= TINYGLTF_TYPE_VEC2 && from.type <= TINYGLTF_TYPE_VEC4 ? uint32_t(from.type)
                   : from.type == TINYGLTF_TYPE_SCALAR                                  ? 1
                                                                                        : 0;
    a.count = uint32_t(std::min<size_t>(from.count, std::numeric_limits<uint32_t>::max()));
    a.least = from.minValues, a.largest = from.maxValues;
    if (from.sparse.isSparse) {
        a.sparse = {uint32_t(from.sparse.count),           from.sparse.indices.bufferView,
                    from.sparse.values.bufferView,         size_t(from.sparse.indices.byteOffset),
                    size_t(from.sparse.values.byteOffset), GltfComponent(from.sparse.indices.componentType)};
        if (from.sparse.count < 1) a.sparse.count = std::numeric_limits<uint32_t>::max();  // fails the range check later
    }
    return a;
}

GltfAnimation convertAnimation(const tinygltf::Animation& from) {
    GltfAnimation animation;
    animation.name = from.name;
    for (const auto& s : from.samplers) animation.samplers.push_back({uint32_t(s.input), uint32_t(s.output), s.interpolation});
    for (const auto& c : from.channels) animation.channels.push_back({c.target_node, c.target_path, uint32_t(c.sampler)});
    return animation;
}

}  // namespace

Result<GltfModel> parseWithTinyGltf(const std::string& json) try {
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(refuseImage, nullptr);
    tinygltf::Model model;
    std::string error, warning;
    const std::string glb = glbAround(json);
    if (!loader.LoadBinaryFromMemory(&model, &error, &warning, reinterpret_cast<const unsigned char*>(glb.data()), unsigned(glb.size()))) {
        if (error == std::bad_alloc().what()) return outOfMemory("read a glTF");  // tinygltf passes on the text of what it catches
        return fail(Code::CorruptData, "not a valid glTF: {}", error);
    }
    GltfModel out;
    out.generator = model.asset.generator;
    if (!model.scenes.empty()) out.sceneName = model.scenes.front().name;
    for (const auto& v : model.bufferViews) out.views.push_back({v.byteOffset, v.byteLength, v.byteStride});
    for (const auto& a : model.accessors) out.accessors.push_back(convertAccessor(a));
    for (const auto& m : model.meshes) out.meshes.push_back(convertMesh(m));
    for (const auto& n : model.nodes) out.nodes.push_back(convertNode(n));
    for (const auto& s : model.skins) out.skins.push_back({s.name, s.inverseBindMatrices, {s.joints.begin(), s.joints.end()}});
    for (const auto& a : model.animations) out.animations.push_back(convertAnimation(a));
    return out;
} catch (const std::bad_alloc&) {
    return outOfMemory("read a glTF");
} catch (const std::exception& e) {
    return fail(Code::CorruptData, "not a valid glTF: {}", e.what());
}

}  // namespace dpl
