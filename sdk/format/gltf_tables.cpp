// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/gltf_tables.h"

#include <algorithm>
#include <limits>
#include <string>

namespace dpl {
namespace {

using Json = nlohmann::json;
constexpr size_t kMostViews = 65536, kMostPrimitives = 4096, kMostChannels = 262144;

/** An object of the JSON and its name for errors, such as "node 3". */
struct Entry {
    const Json& json;
    const char* what;
    size_t index;

    const Json* find(const char* key) const {
        const auto it = json.find(key);
        return it == json.end() ? nullptr : &*it;
    }
    Error wrong(const char* key, const char* wanted) const {
        return fail(Code::CorruptData, "'{}' of {} {} is not {}", key, what, index, wanted);
    }
};

template <class Integer>
Status wholeOf(const Json& value, const char* key, const Entry& of, Integer& out) {
    if (!value.is_number_unsigned()) return of.wrong(key, "a whole number");
    out = Integer(std::min<uint64_t>(value.get<uint64_t>(), uint64_t(std::numeric_limits<Integer>::max())));
    return {};
}

enum class Presence { Optional, Required };

/** Where an optional key is absent, these leave `out` as it is. */
template <class Integer>
Status readWhole(const Entry& entry, const char* key, Integer& out, Presence presence = Presence::Optional) {
    if (const Json* value = entry.find(key)) return wholeOf(*value, key, entry, out);
    return presence == Presence::Required ? Status(entry.wrong(key, "there")) : Status();
}

Status readText(const Entry& entry, const char* key, std::string& out) {
    const Json* value = entry.find(key);
    if (value && !value->is_string()) return entry.wrong(key, "a text");
    if (value) out = value->get_ref<const std::string&>();
    return {};
}

/** count: of the numbers; 0: any. */
template <class Number>
Status readNumbers(const Entry& entry, const char* key, size_t count, std::vector<Number>& out) {
    const Json* list = entry.find(key);
    if (!list) return {};
    const bool right = list->is_array() && (count == 0 || list->size() == count) &&
                       std::all_of(list->begin(), list->end(), [](const Json& v) { return v.is_number(); });
    if (!right)
        return entry.wrong(key, count == 0 ? "an array of numbers" : count == 3 ? "3 numbers" : count == 4 ? "4 numbers" : "16 numbers");
    out.reserve(list->size());
    for (const Json& value : *list) out.push_back(value.get<Number>());
    return {};
}

/** An array of whole numbers. */
Status readWholes(const Entry& entry, const char* key, std::vector<uint32_t>& out) {
    const Json* list = entry.find(key);
    if (!list) return {};
    if (!list->is_array()) return entry.wrong(key, "an array");
    out.resize(list->size());
    for (size_t i = 0; i < out.size(); ++i) DPL_RETURN_IF_ERROR(wholeOf((*list)[i], key, entry, out[i]));
    return {};
}

/** An object of whole numbers by names. */
Status readNamed(const Json& object, const char* key, const Entry& of, std::map<std::string, uint32_t>& out) {
    if (!object.is_object()) return of.wrong(key, "an object");
    for (const auto& [name, value] : object.items()) DPL_RETURN_IF_ERROR(wholeOf(value, key, of, out[name]));
    return {};
}

/** Calls read(entry) for each element of an array of objects. count: of all such elements so far; at most `limit`. */
template <class Read>
Status readEach(const Json& parent, const char* key, const char* what, size_t limit, size_t& count, Read read) {
    const auto list = parent.find(key);
    if (list == parent.end()) return {};
    if (!list->is_array()) return fail(Code::CorruptData, "glTF '{}' is not an array", key);
    if (list->size() > limit - count)
        return fail(Code::CorruptData, "{} entries in glTF '{}', the limit is {}", count + list->size(), key, limit);
    for (size_t i = 0; i < list->size(); ++i, ++count) {
        const Entry entry{(*list)[i], what, i};
        if (!entry.json.is_object()) return fail(Code::CorruptData, "an entry of glTF '{}' is not an object", key);
        DPL_RETURN_IF_ERROR(read(entry));
    }
    return {};
}

template <class Read>
Status readEach(const Json& root, const char* key, const char* what, size_t limit, Read read) {
    size_t count = 0;
    return readEach(root, key, what, limit, count, read);
}

Status readView(const Entry& entry, GltfView& view) {
    uint32_t buffer = 0;
    DPL_RETURN_IF_ERROR(readWhole(entry, "buffer", buffer, Presence::Required));
    if (buffer > 0) return fail(Code::CorruptData, "a buffer view names buffer {}, there is one", buffer);
    DPL_RETURN_IF_ERROR(readWhole(entry, "byteOffset", view.offset));
    DPL_RETURN_IF_ERROR(readWhole(entry, "byteLength", view.length, Presence::Required));
    return readWhole(entry, "byteStride", view.stride);
}

uint32_t componentsOf(const std::string& type) {
    const std::pair<const char*, uint32_t> known[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}};
    const auto it = std::find_if(std::begin(known), std::end(known), [&](const auto& k) { return type == k.first; });
    return it == std::end(known) ? 0 : it->second;
}

Status readComponent(const Entry& entry, GltfComponent& component) {
    uint32_t number = 0;
    DPL_RETURN_IF_ERROR(readWhole(entry, "componentType", number, Presence::Required));
    component = GltfComponent(number);
    return {};
}

Status readSparse(const Json& json, size_t index, GltfAccessor::Sparse& sparse) {
    const Entry entry{json, "sparse accessor", index};
    if (!json.is_object()) return fail(Code::CorruptData, "a sparse accessor is not an object");
    DPL_RETURN_IF_ERROR(readWhole(entry, "count", sparse.count, Presence::Required));
    if (sparse.count == 0) sparse.count = std::numeric_limits<uint32_t>::max();  // 0 would mean dense; this fails the range check later
    const Json *const indices = entry.find("indices"), *const values = entry.find("values");
    if (!indices || !indices->is_object()) return entry.wrong("indices", "an object");
    if (!values || !values->is_object()) return entry.wrong("values", "an object");
    const Entry indexEntry{*indices, entry.what, index}, valueEntry{*values, entry.what, index};
    DPL_RETURN_IF_ERROR(readWhole(indexEntry, "bufferView", sparse.indexView, Presence::Required));
    DPL_RETURN_IF_ERROR(readWhole(indexEntry, "byteOffset", sparse.indexOffset));
    DPL_RETURN_IF_ERROR(readComponent(indexEntry, sparse.indexComponent));
    DPL_RETURN_IF_ERROR(readWhole(valueEntry, "bufferView", sparse.valueView, Presence::Required));
    return readWhole(valueEntry, "byteOffset", sparse.valueOffset);
}

Status readAccessor(const Entry& entry, GltfAccessor& a) {
    DPL_RETURN_IF_ERROR(readWhole(entry, "bufferView", a.view));
    DPL_RETURN_IF_ERROR(readWhole(entry, "byteOffset", a.offset));
    DPL_RETURN_IF_ERROR(readComponent(entry, a.component));
    DPL_RETURN_IF_ERROR(readWhole(entry, "count", a.count, Presence::Required));
    if (const Json* normalized = entry.find("normalized")) {
        if (!normalized->is_boolean()) return entry.wrong("normalized", "true or false");
        a.normalized = normalized->get<bool>();
    }
    std::string type;
    DPL_RETURN_IF_ERROR(readText(entry, "type", type));
    a.components = componentsOf(type);
    DPL_RETURN_IF_ERROR(readNumbers(entry, "min", 0, a.least));
    DPL_RETURN_IF_ERROR(readNumbers(entry, "max", 0, a.largest));
    const Json* sparse = entry.find("sparse");
    return sparse ? readSparse(*sparse, entry.index, a.sparse) : Status();
}

Status readSplatting(const Json& extension, size_t index, GltfSplatting& out) {
    const Entry entry{extension, "the splats of primitive", index};
    DPL_RETURN_IF_ERROR(readText(entry, "kernel", out.kernel));
    DPL_RETURN_IF_ERROR(readText(entry, "colorSpace", out.colorSpace));
    DPL_RETURN_IF_ERROR(readText(entry, "projection", out.projection));
    DPL_RETURN_IF_ERROR(readText(entry, "sortingMethod", out.sortingMethod));
    if (const Json* inner = entry.find("extensions"); inner && inner->is_object() && !inner->empty()) out.extension = inner->begin().key();
    return {};
}

Status readPrimitive(const Entry& entry, GltfPrimitive& p) {
    DPL_RETURN_IF_ERROR(readWhole(entry, "indices", p.indices));
    DPL_RETURN_IF_ERROR(readWhole(entry, "mode", p.mode));
    const Json* attributes = entry.find("attributes");
    if (!attributes) return entry.wrong("attributes", "there");
    DPL_RETURN_IF_ERROR(readNamed(*attributes, "attributes", entry, p.attributes));
    if (const Json* targets = entry.find("targets")) {
        if (!targets->is_array()) return entry.wrong("targets", "an array");
        for (const Json& target : *targets) DPL_RETURN_IF_ERROR(readNamed(target, "targets", entry, p.targets.emplace_back()));
    }
    const Json* extensions = entry.find("extensions");
    if (!extensions || !extensions->is_object()) return {};
    if (auto splatting = extensions->find("KHR_gaussian_splatting"); splatting != extensions->end() && splatting->is_object())
        DPL_RETURN_IF_ERROR(readSplatting(*splatting, entry.index, p.splatting.emplace()));
    const auto draco = extensions->find("KHR_draco_mesh_compression");
    if (draco == extensions->end() || !draco->is_object()) return {};
    const Entry link{*draco, "compressed primitive", entry.index};
    if (p.indices < 0) return fail(Code::CorruptData, "a compressed primitive has no indices");
    DPL_RETURN_IF_ERROR(readWhole(link, "bufferView", p.dracoView, Presence::Required));
    const Json* ids = link.find("attributes");
    return ids ? readNamed(*ids, "attributes", link, p.dracoAttributes) : Status();
}

Status readMesh(const Entry& entry, size_t& primitiveCount, GltfMesh& mesh) {
    DPL_RETURN_IF_ERROR(readText(entry, "name", mesh.name));
    DPL_RETURN_IF_ERROR(readNumbers(entry, "weights", 0, mesh.weights));
    if (const Json* extras = entry.find("extras"); extras && extras->is_object())
        if (auto names = extras->find("targetNames"); names != extras->end() && names->is_array())
            for (const Json& name : *names) mesh.targetNames.push_back(name.is_string() ? name.get<std::string>() : std::string());
    return readEach(entry.json, "primitives", "primitive", kMostPrimitives, primitiveCount,
                    [&](const Entry& primitive) { return readPrimitive(primitive, mesh.primitives.emplace_back()); });
}

/** Splits a matrix into T·R·S; shear is lost. */
void decompose(const std::vector<float>& m, GltfNode& node) {
    Mat3f r;
    for (int c = 0; c < 3; ++c) r[c] = Vec3f(m[c * 4], m[c * 4 + 1], m[c * 4 + 2]);
    node.translation = Vec3f(m[12], m[13], m[14]);
    node.scale = Vec3f(glm::length(r[0]), glm::length(r[1]), glm::length(r[2]));
    if (glm::determinant(r) < 0) node.scale.x = -node.scale.x;
    for (int c = 0; c < 3; ++c) r[c] = node.scale[c] != 0 ? r[c] / node.scale[c] : Vec3f(c == 0, c == 1, c == 2);
    node.rotation = glm::quat_cast(r);
}

Status readNode(const Entry& entry, GltfNode& node) {
    DPL_RETURN_IF_ERROR(readText(entry, "name", node.name));
    DPL_RETURN_IF_ERROR(readWhole(entry, "mesh", node.mesh));
    DPL_RETURN_IF_ERROR(readWhole(entry, "skin", node.skin));
    DPL_RETURN_IF_ERROR(readWholes(entry, "children", node.children));
    std::vector<float> matrix, translation, rotation, scale;
    DPL_RETURN_IF_ERROR(readNumbers(entry, "matrix", 16, matrix));
    DPL_RETURN_IF_ERROR(readNumbers(entry, "translation", 3, translation));
    DPL_RETURN_IF_ERROR(readNumbers(entry, "rotation", 4, rotation));
    DPL_RETURN_IF_ERROR(readNumbers(entry, "scale", 3, scale));
    if (!matrix.empty()) {
        decompose(matrix, node);
        return {};
    }
    if (!translation.empty()) node.translation = Vec3f(translation[0], translation[1], translation[2]);
    if (!rotation.empty()) node.rotation = Quatf(rotation[3], rotation[0], rotation[1], rotation[2]);
    if (!scale.empty()) node.scale = Vec3f(scale[0], scale[1], scale[2]);
    return {};
}

Status readSkin(const Entry& entry, GltfSkin& skin) {
    DPL_RETURN_IF_ERROR(readText(entry, "name", skin.name));
    DPL_RETURN_IF_ERROR(readWhole(entry, "inverseBindMatrices", skin.inverseBind));
    return readWholes(entry, "joints", skin.joints);
}

/** Leaves out channels that move no node; those of extensions do not. */
Status readAnimation(const Entry& entry, size_t& count, GltfAnimation& animation) {
    DPL_RETURN_IF_ERROR(readText(entry, "name", animation.name));
    DPL_RETURN_IF_ERROR(readEach(entry.json, "samplers", "animation sampler", kMostChannels, count, [&](const Entry& from) -> Status {
        GltfAnimation::Sampler& sampler = animation.samplers.emplace_back();
        sampler.interpolation = "LINEAR";
        DPL_RETURN_IF_ERROR(readWhole(from, "input", sampler.input, Presence::Required));
        DPL_RETURN_IF_ERROR(readWhole(from, "output", sampler.output, Presence::Required));
        return readText(from, "interpolation", sampler.interpolation);
    }));
    return readEach(entry.json, "channels", "animation channel", kMostChannels, count, [&](const Entry& from) -> Status {
        const Json* target = from.find("target");
        if (!target || !target->is_object()) return from.wrong("target", "an object");
        GltfAnimation::Channel channel;
        const Entry to{*target, from.what, from.index};
        if (!to.find("node")) return {};
        DPL_RETURN_IF_ERROR(readWhole(to, "node", channel.node));
        DPL_RETURN_IF_ERROR(readText(to, "path", channel.path));
        DPL_RETURN_IF_ERROR(readWhole(from, "sampler", channel.sampler, Presence::Required));
        animation.channels.push_back(std::move(channel));
        return {};
    });
}

}  // namespace

Status readGltfTables(const Json& root, const ReadLimits& limits, GltfModel& model) {
    DPL_RETURN_IF_ERROR(readEach(root, "scenes", "scene", 64,
                                 [&](const Entry& e) { return e.index == 0 ? readText(e, "name", model.sceneName) : Status(); }));
    DPL_RETURN_IF_ERROR(
        readEach(root, "bufferViews", "buffer view", kMostViews, [&](const Entry& e) { return readView(e, model.views.emplace_back()); }));
    DPL_RETURN_IF_ERROR(readEach(root, "accessors", "accessor", kMostViews,
                                 [&](const Entry& e) { return readAccessor(e, model.accessors.emplace_back()); }));
    size_t primitives = 0, channels = 0;
    DPL_RETURN_IF_ERROR(
        readEach(root, "meshes", "mesh", 4096, [&](const Entry& e) { return readMesh(e, primitives, model.meshes.emplace_back()); }));
    DPL_RETURN_IF_ERROR(
        readEach(root, "nodes", "node", limits.maxNodes, [&](const Entry& e) { return readNode(e, model.nodes.emplace_back()); }));
    DPL_RETURN_IF_ERROR(readEach(root, "skins", "skin", 1024, [&](const Entry& e) { return readSkin(e, model.skins.emplace_back()); }));
    return readEach(root, "animations", "animation", 4096,
                    [&](const Entry& e) { return readAnimation(e, channels, model.animations.emplace_back()); });
}

}  // namespace dpl
