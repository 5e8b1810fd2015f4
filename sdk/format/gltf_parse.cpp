// SPDX-License-Identifier: Apache-2.0
// parseGlb. Libraries receive bytes only after their size, nesting and place in the file have been checked.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "sdk/core/reader.h"
#include "sdk/format/gltf_humanoid.h"
#include "sdk/format/gltf_model.h"
#include "sdk/format/load_json.h"
#include "sdk/format/tiny_gltf_parse.h"

namespace dpl {
namespace {

using Json = nlohmann::json;
constexpr size_t kMostComponents = 16;  // of an accessor's element
constexpr uint32_t kGlbMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinChunk = 0x004E4942;

struct Glb {
    std::string_view json;
    std::span<const uint8_t> bin;
};

Result<Glb> openGlb(std::span<const uint8_t> bytes, const ReadLimits& limits) {
    if (bytes.size() > limits.maxFileBytes)
        return fail(Code::CorruptData, "a file of {} bytes, the limit is {}", bytes.size(), limits.maxFileBytes);
    Reader in(bytes);
    DPL_TRY(uint32_t magic, in.u32());
    if (magic != kGlbMagic) return fail(Code::Unsupported, "not a binary glTF (.glb): it does not begin with 'glTF'");
    DPL_TRY(uint32_t version, in.u32());
    if (version != 2) return fail(Code::Unsupported, "glTF container version {}, only 2 is read", version);
    DPL_TRY(uint32_t length, in.u32());
    if (length != bytes.size())
        return fail(Code::CorruptData, "the header says {} bytes, the file has {}: truncated, or with something appended", length,
                    bytes.size());
    Glb glb;
    for (bool first = true; in.remaining() > 0; first = false) {
        DPL_TRY(uint32_t chunkBytes, in.u32());
        DPL_TRY(uint32_t type, in.u32());
        if (chunkBytes % 4 != 0) return fail(Code::CorruptData, "a chunk of {} bytes, not a multiple of 4", chunkBytes);
        DPL_TRY(auto data, in.take(chunkBytes));
        if (first != (type == kJsonChunk))
            return fail(Code::CorruptData, first ? "the first chunk is not JSON" : "there are two JSON chunks");
        if (first) {
            if (chunkBytes > limits.maxJsonBytes)
                return fail(Code::CorruptData, "{} bytes of JSON, the limit is {}", chunkBytes, limits.maxJsonBytes);
            glb.json = {reinterpret_cast<const char*>(data.data()), data.size()};
        } else if (type == kBinChunk) {
            if (glb.bin.data()) return fail(Code::CorruptData, "there are two binary chunks");
            glb.bin = data;
        }
    }
    if (glb.json.empty()) return fail(Code::CorruptData, "the file has no JSON chunk");
    return glb;
}

/** Measures nesting depth and number of values without building a tree. nlohmann's SAX parser does not recurse, so depth is safe. */
struct ShapeCheck : nlohmann::json_sax<Json> {
    explicit ShapeCheck(const ReadLimits& limits) : limits_(limits) {}
    bool value() { return ++values_ <= limits_.maxJsonValues || refuse("has too many values"); }
    bool open() { return (++depth_ <= limits_.maxJsonDepth || refuse("is nested too deeply")) && value(); }
    bool close() { return --depth_, true; }
    bool refuse(const char* why) { return problem = why, false; }
    uint32_t values() const { return values_; }
    bool null() override { return value(); }
    bool boolean(bool) override { return value(); }
    bool number_integer(number_integer_t) override { return value(); }
    bool number_unsigned(number_unsigned_t) override { return value(); }
    bool number_float(number_float_t, const string_t&) override { return value(); }
    bool string(string_t&) override { return value(); }
    bool binary(binary_t&) override { return value(); }
    bool start_object(size_t) override { return open(); }
    bool key(string_t&) override { return value(); }
    bool end_object() override { return close(); }
    bool start_array(size_t) override { return open(); }
    bool end_array() override { return close(); }
    bool parse_error(size_t at, const std::string&, const nlohmann::detail::exception&) override {
        errorAt = at;
        return refuse("is not valid JSON");
    }
    const char* problem = "is not valid JSON";
    size_t errorAt = 0;

private:
    const ReadLimits& limits_;
    uint32_t depth_ = 0, values_ = 0;
};

/** A copy of `from` with the named keys only; empty if it is no object. */
Json pick(const Json& from, std::initializer_list<const char*> keys) {
    Json to = Json::object();
    if (from.is_object())
        for (const char* key : keys)
            if (auto it = from.find(key); it != from.end()) to[key] = *it;
    return to;
}

/** The place of a null in `value`, such as "nodes/3/scale/0". glTF has no null, and tinygltf would read 0 or a default. */
std::optional<std::string> placeOfNull(const Json& value) {
    if (value.is_null()) return std::string();
    if (!value.is_structured()) return std::nullopt;
    size_t index = 0;
    for (auto it = value.begin(); it != value.end(); ++it, ++index)
        if (auto place = placeOfNull(*it)) {
            const std::string key = value.is_object() ? it.key() : std::to_string(index);
            return place->empty() ? key : key + "/" + *place;
        }
    return std::nullopt;
}

/** Refuses materials that are not there. They are not read, but the file is damaged. */
Status checkMaterials(const Json& root) {
    const auto materials = root.find("materials");
    const size_t count = materials != root.end() && materials->is_array() ? materials->size() : 0;
    const auto meshes = root.find("meshes");
    if (meshes == root.end()) return {};
    for (const Json& mesh : *meshes) {
        const auto primitives = mesh.is_object() ? mesh.find("primitives") : mesh.end();
        if (primitives == mesh.end()) continue;
        for (const Json& primitive : *primitives) {
            if (!primitive.is_object()) continue;
            const auto material = primitive.find("material");
            if (material == primitive.end() || (material->is_number_unsigned() && material->get<uint64_t>() < count)) continue;
            return fail(Code::CorruptData, "a primitive of the glTF names material {}, there are {}",
                        material->dump(-1, ' ', false, Json::error_handler_t::replace).substr(0, 32), count);
        }
    }
    return {};
}

/** Applies `change` to each element of array `key` and limits their number. */
template <class Change>
Status copyArray(const Json& root, Json& out, const char* key, size_t limit, Change change) {
    auto it = root.find(key);
    if (it == root.end()) return {};
    if (!it->is_array()) return fail(Code::CorruptData, "glTF '{}' is not an array", key);
    if (it->size() > limit) return fail(Code::CorruptData, "{} entries in glTF '{}', the limit is {}", it->size(), key, limit);
    Json& to = out[key] = Json::array();
    for (const Json& element : *it) {
        if (!element.is_object()) return fail(Code::CorruptData, "an entry of glTF '{}' is not an object", key);
        to.push_back(change(element));
    }
    return {};
}

struct DracoLink {
    size_t mesh, primitive;
    int64_t indices, view;
    std::map<std::string, uint32_t> attributes;
};

struct SplattingLink {
    size_t mesh, primitive;
    GltfSplatting splatting;
};

/** Data of primitives that bypasses tinygltf. */
struct PrimitiveLinks {
    std::vector<DracoLink> draco;
    std::vector<SplattingLink> splatting;
};

int64_t integerAt(const Json& object, const char* key) {
    auto it = object.find(key);
    return it != object.end() && it->is_number_integer() && it->is_number_unsigned()
               ? int64_t(std::min<uint64_t>(it->get<uint64_t>(), 1ull << 40))
               : -1;
}

void textAt(const Json& object, const char* key, std::string& text) {
    if (auto it = object.find(key); it != object.end()) text = it->is_string() ? it->get<std::string>() : "?";
}

GltfSplatting splattingOf(const Json& extension) {
    GltfSplatting out;
    textAt(extension, "kernel", out.kernel), textAt(extension, "colorSpace", out.colorSpace);
    textAt(extension, "projection", out.projection), textAt(extension, "sortingMethod", out.sortingMethod);
    if (auto inner = extension.find("extensions"); inner != extension.end() && inner->is_object() && !inner->empty())
        out.extension = inner->begin().key();
    return out;
}

/** Copies the known keys of a primitive. tinygltf refuses indices without a view, so those of Draco primitives go to `links`. */
Json copyPrimitive(const Json& from, size_t mesh, size_t primitive, PrimitiveLinks& links) {
    Json to = pick(from, {"attributes", "indices", "mode", "targets"});
    const auto extensions = from.find("extensions");
    if (extensions == from.end() || !extensions->is_object()) return to;
    if (auto splatting = extensions->find("KHR_gaussian_splatting"); splatting != extensions->end() && splatting->is_object())
        links.splatting.push_back({mesh, primitive, splattingOf(*splatting)});
    const auto link = extensions->find("KHR_draco_mesh_compression");
    if (link == extensions->end() || !link->is_object()) return to;
    DracoLink entry{mesh, primitive, integerAt(from, "indices"), integerAt(*link, "bufferView"), {}};
    if (auto attributes = link->find("attributes"); attributes != link->end() && attributes->is_object())
        for (const auto& [semantic, id] : attributes->items())
            if (id.is_number_unsigned()) entry.attributes[semantic] = uint32_t(std::min<uint64_t>(id.get<uint64_t>(), 0xffffffffu));
    links.draco.push_back(std::move(entry));
    to.erase("indices");
    return to;
}

constexpr std::array<const char*, 4> kKnownRequired = {"KHR_draco_mesh_compression", "KHR_gaussian_splatting", "KHR_mesh_quantization",
                                                       "KHR_texture_transform"};

Status checkRequired(const Json& root) {
    auto required = root.find("extensionsRequired");
    if (required == root.end() || !required->is_array()) return {};
    for (const Json& name : *required) {
        const auto* text = name.get_ptr<const std::string*>();
        const bool known = text && std::find(kKnownRequired.begin(), kKnownRequired.end(), *text) != kKnownRequired.end();
        // Materials and textures are not read; only extensions that change geometry matter.
        const bool harmless = text && (text->starts_with("KHR_materials") || text->find("texture") != std::string::npos);
        if (!known && !harmless)
            return fail(Code::Unsupported, "the file requires the glTF extension {}, which is not read; export the file without it",
                        name.dump(-1, ' ', false, Json::error_handler_t::replace));
    }
    return {};
}

Status checkBuffers(const Json& root, std::span<const uint8_t> bin) {
    auto buffers = root.find("buffers");
    if (buffers == root.end()) return {};
    if (!buffers->is_array() || buffers->size() != 1 || !(*buffers)[0].is_object())
        return fail(Code::Unsupported, "a .glb with other than one buffer; export it as a single file");
    const Json& buffer = (*buffers)[0];
    if (buffer.contains("uri")) return fail(Code::Unsupported, "the buffer lies outside the file; export it as a self-contained .glb");
    const int64_t length = integerAt(buffer, "byteLength");
    if (length < 1 || uint64_t(length) > bin.size())
        return fail(Code::CorruptData, "the buffer claims {} bytes, the binary chunk has {}", length, bin.size());
    return {};
}

/** Refuses indices that are not whole numbers, which tinygltf would read as 0, and views of a buffer that is not there. */
Status checkTables(const Json& root) {
    for (const char* table : {"bufferViews", "accessors"})
        if (auto list = root.find(table); list != root.end())
            for (const Json& entry : *list)
                for (const char* key : {"buffer", "bufferView", "byteOffset", "byteLength", "byteStride", "componentType", "count"})
                    if (auto it = entry.find(key); it != entry.end() && !it->is_number_unsigned())
                        return fail(Code::CorruptData, "'{}' in glTF '{}' is not a whole number", key, table);
    if (auto views = root.find("bufferViews"); views != root.end())
        for (const Json& view : *views)
            if (integerAt(view, "buffer") > 0)
                return fail(Code::CorruptData, "a buffer view names buffer {}, there is one", integerAt(view, "buffer"));
    return {};
}

/** Refuses bounds that no value of an accessor has. They are not read further, but tell of damage. */
Status checkBounds(const Json& root) {
    constexpr double kLargest = 1e10;  // above any index
    const auto list = root.find("accessors");
    if (list == root.end() || !list->is_array()) return {};
    for (size_t i = 0; i < list->size(); ++i)
        for (const char* key : {"min", "max"}) {
            const Json& accessor = (*list)[i];
            const auto bounds = accessor.is_object() ? accessor.find(key) : accessor.end();
            if (!accessor.is_object() || bounds == accessor.end()) continue;
            if (!bounds->is_array() || bounds->size() > 16)
                return fail(Code::CorruptData, "'{}' of accessor {} is not an array of at most 16 numbers", key, i);
            for (const Json& bound : *bounds)
                if (!bound.is_number() || !(std::abs(bound.get<double>()) <= kLargest))
                    return fail(Code::CorruptData, "'{}' of accessor {} states {}, which no value has; the file is damaged", key, i,
                                bound.dump(-1, ' ', false, Json::error_handler_t::replace).substr(0, 40));
        }
    return {};
}

/** Copies the known keys only: for extras and unknown extensions tinygltf takes up to a hundred times their size. */
Result<Json> knownKeys(const Json& root, std::span<const uint8_t> bin, const ReadLimits& limits, PrimitiveLinks& links,
                       std::vector<std::vector<std::string>>& targetNames) {
    if (!root.is_object()) return fail(Code::CorruptData, "the glTF JSON is not an object");
    const auto asset = root.find("asset");
    if (asset == root.end() || !asset->is_object()) return fail(Code::CorruptData, "the glTF has no 'asset'");
    const auto version = asset->find("version");
    if (version == asset->end() || !version->is_string() || !version->get<std::string>().starts_with("2."))
        return fail(Code::Unsupported, "not glTF 2");
    DPL_RETURN_IF_ERROR(checkRequired(root));
    DPL_RETURN_IF_ERROR(checkBuffers(root, bin));
    // Member by member: a value made from an initializer list leaks when memory ends in it.
    Json out = Json::object();
    out["asset"] = pick(*asset, {"version", "generator"});
    if (!bin.empty()) {
        Json buffer = Json::object();
        buffer["byteLength"] = 4;
        out["buffers"] = Json::array();
        out["buffers"].push_back(std::move(buffer));
    }
    DPL_RETURN_IF_ERROR(copyArray(root, out, "scenes", 64, [](const Json& s) { return pick(s, {"name"}); }));
    DPL_RETURN_IF_ERROR(copyArray(root, out, "bufferViews", 65536, [](const Json& v) {
        return pick(v, {"buffer", "byteOffset", "byteLength", "byteStride"});
    }));
    DPL_RETURN_IF_ERROR(copyArray(root, out, "accessors", 65536, [](const Json& a) {
        Json to = pick(a, {"bufferView", "byteOffset", "componentType", "normalized", "count", "type", "sparse"});
        for (const char* key : {"min", "max"})
            if (auto it = a.find(key); it != a.end() && it->is_array() && it->size() <= kMostComponents) to[key] = *it;
        return to;
    }));
    DPL_RETURN_IF_ERROR(checkTables(out));
    DPL_RETURN_IF_ERROR(checkBounds(root));
    for (const Json& a : out.value("accessors", Json::array()))
        if (auto sparse = a.find("sparse"); sparse != a.end() && !sparse->is_object())
            return fail(Code::CorruptData, "a sparse accessor is not an object");
    size_t mesh = 0, primitiveCount = 0;
    DPL_RETURN_IF_ERROR(copyArray(root, out, "meshes", 4096, [&](const Json& m) {
        Json to = pick(m, {"name", "weights"});
        auto& names = targetNames.emplace_back();
        if (auto extras = m.find("extras"); extras != m.end() && extras->is_object())
            if (auto list = extras->find("targetNames"); list != extras->end() && list->is_array())
                for (const Json& name : *list) names.push_back(name.is_string() ? name.get<std::string>() : std::string());
        to["primitives"] = Json::array();
        if (auto primitives = m.find("primitives"); primitives != m.end() && primitives->is_array())
            for (const Json& p : *primitives)
                if (p.is_object() && ++primitiveCount <= 4096)
                    to["primitives"].push_back(copyPrimitive(p, mesh, to["primitives"].size(), links));
        ++mesh;
        return to;
    }));
    if (primitiveCount > 4096) return fail(Code::CorruptData, "{} mesh primitives, the limit is 4096", primitiveCount);
    DPL_RETURN_IF_ERROR(copyArray(root, out, "nodes", limits.maxNodes, [](const Json& n) {
        return pick(n, {"name", "children", "matrix", "translation", "rotation", "scale", "mesh", "skin"});
    }));
    DPL_RETURN_IF_ERROR(copyArray(root, out, "skins", 1024, [](const Json& s) {
        return pick(s, {"name", "inverseBindMatrices", "joints"});
    }));
    size_t channelCount = 0;
    DPL_RETURN_IF_ERROR(copyArray(root, out, "animations", 4096, [&](const Json& a) {
        Json to = pick(a, {"name"});
        for (const char* key : {"channels", "samplers"}) {
            to[key] = Json::array();
            auto list = a.find(key);
            if (list == a.end() || !list->is_array()) continue;
            for (const Json& entry : *list) {
                if (++channelCount > 262144) break;
                Json one = pick(entry, {"sampler", "input", "output", "interpolation"});
                if (entry.is_object() && entry.contains("target")) one["target"] = pick(entry["target"], {"node", "path"});
                to[key].push_back(std::move(one));
            }
        }
        return to;
    }));
    if (channelCount > 262144) return fail(Code::CorruptData, "more than 262144 animation channels and samplers");
    DPL_RETURN_IF_ERROR(checkMaterials(root));
    if (const auto place = placeOfNull(out)) return fail(Code::CorruptData, "the glTF has a null at {}, where a value belongs", *place);
    return out;
}

size_t componentBytes(GltfComponent c) {
    switch (c) {
        case GltfComponent::I8:
        case GltfComponent::U8:
            return 1;
        case GltfComponent::I16:
        case GltfComponent::U16:
            return 2;
        case GltfComponent::U32:
        case GltfComponent::F32:
            return 4;
    }
    return 0;
}

/** Elements in a buffer view, as the file gives them. Sizes in bytes. */
struct ViewElements {
    int32_t view;
    size_t offset, elementBytes, stride;
    uint64_t count;
};

Status checkRange(const GltfModel& m, const ViewElements& e, const char* what, size_t index) {
    if (e.view < 0 || size_t(e.view) >= m.views.size())
        return fail(Code::CorruptData, "{} {} names buffer view {}, there are {}", what, index, e.view, m.views.size());
    if (e.count == 0) return fail(Code::CorruptData, "{} {} is empty", what, index);
    const size_t length = m.views[e.view].length;
    if (e.offset > length || e.elementBytes > length - e.offset || (e.count - 1) > (length - e.offset - e.elementBytes) / e.stride)
        return fail(Code::CorruptData, "{} {} reaches past its buffer view", what, index);
    return {};
}

Status checkRanges(const GltfModel& m) {
    for (size_t i = 0; i < m.views.size(); ++i) {
        const GltfView& v = m.views[i];
        if (v.offset > m.bin.size() || v.length > m.bin.size() - v.offset)
            return fail(Code::CorruptData, "buffer view {} reaches past the binary chunk", i);
        if (v.stride != 0 && (v.stride < 4 || v.stride > 252))
            return fail(Code::CorruptData, "buffer view {} has a stride of {}", i, v.stride);
    }
    for (size_t i = 0; i < m.accessors.size(); ++i) {
        const GltfAccessor& a = m.accessors[i];
        const size_t bytes = componentBytes(a.component) * a.components;
        if (bytes == 0) return fail(Code::CorruptData, "accessor {} has a type that is not read", i);
        if (a.view >= 0) {
            const size_t stride = size_t(a.view) < m.views.size() && m.views[a.view].stride ? m.views[a.view].stride : bytes;
            if (stride < bytes) return fail(Code::CorruptData, "accessor {} has elements longer than its stride", i);
            DPL_RETURN_IF_ERROR(checkRange(m, {a.view, a.offset, bytes, stride, a.count}, "accessor", i));
        }
        if (a.sparse.count) {
            const size_t indexBytes = componentBytes(a.sparse.indexComponent);
            if (a.sparse.count > a.count || (indexBytes != 1 && indexBytes != 2 && indexBytes != 4))
                return fail(Code::CorruptData, "sparse accessor {} is malformed", i);
            DPL_RETURN_IF_ERROR(
                checkRange(m, {a.sparse.indexView, a.sparse.indexOffset, indexBytes, indexBytes, a.sparse.count}, "sparse accessor", i));
            DPL_RETURN_IF_ERROR(
                checkRange(m, {a.sparse.valueView, a.sparse.valueOffset, bytes, bytes, a.sparse.count}, "sparse accessor", i));
        }
    }
    return {};
}

Status checkIndex(int64_t index, size_t count, const char* what) {
    if (index >= int64_t(count)) return fail(Code::CorruptData, "the glTF names {} {}, there are {}", what, index, count);
    return {};
}

Status checkPrimitive(const GltfModel& m, const GltfPrimitive& p) {
    DPL_RETURN_IF_ERROR(checkIndex(p.indices, m.accessors.size(), "accessor"));
    DPL_RETURN_IF_ERROR(checkIndex(p.dracoView, m.views.size(), "buffer view"));
    for (const auto& [name, accessor] : p.attributes) DPL_RETURN_IF_ERROR(checkIndex(accessor, m.accessors.size(), "accessor"));
    for (const auto& target : p.targets)
        for (const auto& [name, accessor] : target) DPL_RETURN_IF_ERROR(checkIndex(accessor, m.accessors.size(), "accessor"));
    return {};
}

Status checkReferences(GltfModel& m, const ReadLimits& limits) {
    for (const GltfMesh& mesh : m.meshes)
        for (const GltfPrimitive& p : mesh.primitives) DPL_RETURN_IF_ERROR(checkPrimitive(m, p));
    for (uint32_t n = 0; n < m.nodes.size(); ++n) {
        GltfNode& node = m.nodes[n];
        DPL_RETURN_IF_ERROR(checkIndex(node.mesh, m.meshes.size(), "mesh"));
        DPL_RETURN_IF_ERROR(checkIndex(node.skin, m.skins.size(), "skin"));
        for (uint32_t child : node.children) {
            DPL_RETURN_IF_ERROR(checkIndex(child, m.nodes.size(), "node"));
            if (m.nodes[child].parent >= 0) return fail(Code::CorruptData, "node {} has two parents", child);
            m.nodes[child].parent = int32_t(n);
        }
        const float sum = node.translation.x + node.translation.y + node.translation.z + node.scale.x + node.scale.y + node.scale.z +
                          node.rotation.x + node.rotation.y + node.rotation.z + node.rotation.w;
        const float length = glm::length(node.rotation);
        if (!std::isfinite(sum) || !(length > 1e-6f)) return fail(Code::CorruptData, "node {} has a transform that is not finite", n);
        if (std::abs(length - 1) > 1e-5f) node.rotation = node.rotation / length;
    }
    // The nodes must be a forest: one parent each, and every chain of parents ends at a root. Visits each node once.
    std::vector<uint8_t> state(m.nodes.size(), 0);
    for (uint32_t n = 0; n < m.nodes.size(); ++n) {
        int32_t at = int32_t(n);
        for (; at >= 0 && state[at] == 0; at = m.nodes[at].parent) state[at] = 1;
        if (at >= 0 && state[at] == 1) return fail(Code::CorruptData, "the node tree has a cycle at node {}", at);
        for (at = int32_t(n); at >= 0 && state[at] == 1; at = m.nodes[at].parent) state[at] = 2;
    }
    for (const GltfSkin& skin : m.skins) {
        if (skin.joints.empty() || skin.joints.size() > limits.maxJoints)
            return fail(Code::CorruptData, "a skin of {} joints, the limit is {}", skin.joints.size(), limits.maxJoints);
        for (uint32_t joint : skin.joints) DPL_RETURN_IF_ERROR(checkIndex(joint, m.nodes.size(), "node"));
        DPL_RETURN_IF_ERROR(checkIndex(skin.inverseBind, m.accessors.size(), "accessor"));
        if (skin.inverseBind >= 0 && m.accessors[skin.inverseBind].count < skin.joints.size())
            return fail(Code::CorruptData, "a skin has fewer bind matrices than joints");
    }
    for (const GltfAnimation& animation : m.animations) {
        for (const auto& s : animation.samplers) {
            DPL_RETURN_IF_ERROR(checkIndex(s.input, m.accessors.size(), "accessor"));
            DPL_RETURN_IF_ERROR(checkIndex(s.output, m.accessors.size(), "accessor"));
        }
        for (const auto& c : animation.channels) {
            DPL_RETURN_IF_ERROR(checkIndex(c.node, m.nodes.size(), "node"));
            DPL_RETURN_IF_ERROR(checkIndex(c.sampler, animation.samplers.size(), "animation sampler"));
        }
    }
    return {};
}

Status linkDraco(GltfModel& m, const std::vector<DracoLink>& draco) {
    for (const DracoLink& link : draco) {
        if (link.mesh >= m.meshes.size() || link.primitive >= m.meshes[link.mesh].primitives.size())
            return fail(Code::CorruptData, "a compressed primitive is malformed");
        if (link.view < 0 || uint64_t(link.view) >= m.views.size())
            return fail(Code::CorruptData, "a compressed primitive names buffer view {}, there are {}", link.view, m.views.size());
        if (link.indices < 0 || uint64_t(link.indices) >= m.accessors.size())
            return fail(Code::CorruptData, "a compressed primitive has no indices");
        GltfPrimitive& p = m.meshes[link.mesh].primitives[link.primitive];
        p.dracoView = int32_t(link.view), p.indices = int32_t(link.indices), p.dracoAttributes = link.attributes;
    }
    return {};
}

}  // namespace

Result<GltfModel> parseGlb(std::span<const uint8_t> bytes, const ReadLimits& limits) try {
    DPL_TRY(const Glb glb, openGlb(bytes, limits));
    ShapeCheck shape(limits);
    if (!Json::sax_parse(glb.json, &shape))
        return fail(Code::CorruptData, "the JSON of the file {} (near byte {})", shape.problem, shape.errorAt);
    const JsonReserve reserve(shape.values());
    const Json root = Json::parse(glb.json, nullptr, false);
    PrimitiveLinks links;
    std::vector<std::vector<std::string>> targetNames;
    DPL_TRY(const Json known, knownKeys(root, glb.bin, limits, links, targetNames));
    DPL_TRY(GltfModel model, parseWithTinyGltf(known.dump(-1, ' ', false, Json::error_handler_t::replace)));
    model.bin = glb.bin, model.json = glb.json, model.jsonValues = shape.values();
    for (size_t i = 0; i < model.meshes.size() && i < targetNames.size(); ++i) model.meshes[i].targetNames = std::move(targetNames[i]);
    DPL_RETURN_IF_ERROR(linkDraco(model, links.draco));
    for (SplattingLink& link : links.splatting)
        if (link.mesh < model.meshes.size() && link.primitive < model.meshes[link.mesh].primitives.size())
            model.meshes[link.mesh].primitives[link.primitive].splatting = std::move(link.splatting);
    DPL_RETURN_IF_ERROR(checkRanges(model));
    DPL_RETURN_IF_ERROR(checkReferences(model, limits));
    if (auto extensions = root.find("extensions"); extensions != root.end() && extensions->is_object()) {
        DPL_RETURN_IF_ERROR(readHumanoidMap(*extensions, model.nodes));
        if (auto ours = extensions->find("DPL_gaussian_avatar"); ours != extensions->end())
            model.avatarExtension = ours->dump(-1, ' ', false, Json::error_handler_t::replace);
    }
    return model;
} catch (const std::bad_alloc&) {
    return outOfMemory("read a glTF");
} catch (const std::exception& e) {
    return fail(Code::CorruptData, "not a valid glTF: {}", e.what());
}

}  // namespace dpl
