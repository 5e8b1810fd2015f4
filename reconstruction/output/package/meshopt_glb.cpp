// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/meshopt_glb.h"

#include <cmath>
#include <cstring>
#include <optional>
#include <string>

#include <meshoptimizer.h>

#include "sdk/core/writer.h"
#include "sdk/format/glb_builder.h"
#include "sdk/format/gltf_model.h"

namespace dpl {
namespace {

constexpr const char* kExtension = "EXT_meshopt_compression";

/** How the bytes of a buffer view are coded. */
struct ViewCode {
    enum class Mode : uint8_t { Attributes, Triangles, Indices } mode = Mode::Attributes;
    size_t stride = 0;
    float step = 0;  // of floats that are rounded to its multiples; 0: bytes stay as they are
};

class CodesOfViews {
public:
    explicit CodesOfViews(const Json& root) : root_(root), codes_(root.value("bufferViews", Json::array()).size()) {
        for (const Json& mesh : root.value("meshes", Json::array()))
            for (const Json& primitive : mesh.at("primitives")) addPrimitive(primitive);
        for (const Json& animation : root.value("animations", Json::array())) {
            for (const Json& channel : animation.at("channels")) {
                const Json& sampler = animation.at("samplers").at(channel.at("sampler").get<size_t>());
                addValues(sampler.at("input"), 0);
                addValues(sampler.at("output"), kMeshoptStep);
            }
        }
    }
    const std::optional<ViewCode>& of(size_t view) const { return codes_[view]; }

private:
    void addPrimitive(const Json& primitive) {
        if (primitive.contains("extensions")) return;  // the vertices lie in the bytes of Draco
        const auto step = [](const std::string& attribute) { return attribute == "NORMAL" ? kMeshoptNormalStep : kMeshoptStep; };
        for (const auto& [name, accessor] : primitive.at("attributes").items()) addValues(accessor, step(name));
        for (const Json& target : primitive.value("targets", Json::array()))
            for (const auto& [name, accessor] : target.items()) addValues(accessor, step(name));
        if (const Json& indices = accessorAt(primitive.at("indices")); indices.at("componentType") == kGltfU32)
            code(indices.at("bufferView"), {ViewCode::Mode::Triangles, sizeof(uint32_t)});
    }
    void addValues(const Json& accessor, float step) {
        const Json& a = accessorAt(accessor);
        const int component = a.at("componentType");
        if (component != kGltfF32) step = 0;
        const size_t stride = bytesOf(component) * componentsOf(a.at("type"));
        if (a.contains("bufferView")) code(a["bufferView"], {ViewCode::Mode::Attributes, stride, step});
        if (!a.contains("sparse")) return;
        const Json &indices = a["sparse"].at("indices"), &values = a["sparse"].at("values");
        code(indices.at("bufferView"), {ViewCode::Mode::Indices, bytesOf(indices.at("componentType"))});
        code(values.at("bufferView"), {ViewCode::Mode::Attributes, stride, step});
    }
    void code(size_t view, const ViewCode& code) {
        if (code.mode != ViewCode::Mode::Attributes || code.stride % 4 == 0) codes_.at(view) = code;  // the codec counts in words
    }
    const Json& accessorAt(const Json& index) const { return root_.at("accessors").at(index.get<size_t>()); }

    static size_t bytesOf(int component) { return component == kGltfU8 ? 1 : component == kGltfU16 ? 2 : 4; }
    static size_t componentsOf(const std::string& type) {
        return type == "SCALAR" ? 1 : type == "VEC2" ? 2 : type == "VEC3" ? 3 : type == "VEC4" ? 4 : 16;
    }

    const Json& root_;
    std::vector<std::optional<ViewCode>> codes_;
};

/** Floats as mantissa and exponent, for the filter EXPONENTIAL; empty where one has no room. */
std::vector<uint32_t> exponential(std::span<const uint8_t> bytes, float step) {
    constexpr float kMost = (1 << 23) - 1;
    const uint32_t exponent = uint32_t(std::ilogb(step)) << 24;
    std::vector<uint32_t> out(bytes.size() / sizeof(float));
    for (size_t i = 0; i < out.size(); ++i) {
        float value;
        std::memcpy(&value, bytes.data() + i * sizeof(float), sizeof(float));
        const float steps = std::round(value / step);
        if (!(std::abs(steps) <= kMost)) return {};
        out[i] = exponent | (uint32_t(int32_t(steps)) & 0xffffff);
    }
    return out;
}

std::vector<uint32_t> indicesOf(std::span<const uint8_t> bytes, size_t stride) {
    std::vector<uint32_t> out(bytes.size() / stride, 0);
    for (size_t i = 0; i < out.size(); ++i) std::memcpy(&out[i], bytes.data() + i * stride, stride);
    return out;
}

uint32_t pastTheLast(const std::vector<uint32_t>& indices) {
    uint32_t most = 0;
    for (const uint32_t index : indices) most = std::max(most, index + 1);
    return most;
}

struct Coded {
    std::vector<uint8_t> bytes;
    const char* mode;
    bool exponential = false;
};

Coded encode(std::span<const uint8_t> bytes, const ViewCode& code) {
    meshopt_encodeVertexVersion(0), meshopt_encodeIndexVersion(1);  // those of the extension, whatever is the library's newest
    Coded out;
    const size_t count = bytes.size() / code.stride;
    if (code.mode == ViewCode::Mode::Attributes) {
        const std::vector<uint32_t> words = code.step > 0 ? exponential(bytes, code.step) : std::vector<uint32_t>();
        out.mode = "ATTRIBUTES", out.exponential = !words.empty();
        out.bytes.resize(meshopt_encodeVertexBufferBound(count, code.stride));
        out.bytes.resize(meshopt_encodeVertexBuffer(
            out.bytes.data(), out.bytes.size(), words.empty() ? static_cast<const void*>(bytes.data()) : words.data(), count, code.stride));
        return out;
    }
    const std::vector<uint32_t> indices = indicesOf(bytes, code.stride);
    if (code.mode == ViewCode::Mode::Triangles) {
        out.mode = "TRIANGLES";
        out.bytes.resize(meshopt_encodeIndexBufferBound(count, pastTheLast(indices)));
        out.bytes.resize(meshopt_encodeIndexBuffer(out.bytes.data(), out.bytes.size(), indices.data(), count));
    } else {
        out.mode = "INDICES";
        out.bytes.resize(meshopt_encodeIndexSequenceBound(count, pastTheLast(indices)));
        out.bytes.resize(meshopt_encodeIndexSequence(out.bytes.data(), out.bytes.size(), indices.data(), count));
    }
    return out;
}

/** Moves views into a new binary chunk, coded where that takes fewer bytes. */
class ViewMover {
public:
    explicit ViewMover(const GltfModel& model) : model_(model) {}

    void move(size_t index, Json& view, const std::optional<ViewCode>& code) {
        const std::span<const uint8_t> bytes = model_.viewBytes(uint32_t(index));
        if (code && !bytes.empty()) {
            if (const Coded coded = encode(bytes, *code); !coded.bytes.empty() && coded.bytes.size() < bytes.size()) {
                Json& to = view["extensions"][kExtension] = {{"buffer", 0},
                                                             {"byteOffset", append(coded.bytes)},
                                                             {"byteLength", coded.bytes.size()},
                                                             {"byteStride", code->stride},
                                                             {"count", bytes.size() / code->stride},
                                                             {"mode", coded.mode}};
                if (coded.exponential) to["filter"] = "EXPONENTIAL";
                view["buffer"] = 1, view["byteOffset"] = decodedBytes_;
                decodedBytes_ += (bytes.size() + 3) / 4 * 4;
                return;
            }
        }
        view["byteOffset"] = append(bytes);
    }
    const std::vector<uint8_t>& bin() const { return bin_; }
    size_t decodedBytes() const { return decodedBytes_; }

private:
    size_t append(std::span<const uint8_t> bytes) {
        bin_.resize((bin_.size() + 3) / 4 * 4, 0);
        const size_t at = bin_.size();
        bin_.insert(bin_.end(), bytes.begin(), bytes.end());
        return at;
    }

    const GltfModel& model_;
    std::vector<uint8_t> bin_;
    size_t decodedBytes_ = 0;
};

}  // namespace

void orderForMeshopt(SeamedMesh& seamed) {
    MeshData& mesh = seamed.mesh;
    std::vector<uint32_t> newOf(seamed.old.size());
    for (const LayerData& layer : mesh.layers) {
        std::vector<uint32_t> corners, ordered(3 * layer.triangleCount), place(layer.vertexCount);
        for (uint32_t t = layer.firstTriangle; t < layer.firstTriangle + layer.triangleCount; ++t)
            for (int k = 0; k < 3; ++k) corners.push_back(mesh.triangles[t][k] - layer.firstVertex);
        meshopt_optimizeVertexCacheStrip(ordered.data(), corners.data(), corners.size(), layer.vertexCount);
        meshopt_optimizeVertexFetchRemap(place.data(), ordered.data(), ordered.size(), layer.vertexCount);
        for (uint32_t v = 0; v < layer.vertexCount; ++v) newOf[layer.firstVertex + v] = layer.firstVertex + place[v];
        for (uint32_t t = 0; t < layer.triangleCount; ++t)
            for (int k = 0; k < 3; ++k)
                mesh.triangles[layer.firstTriangle + t][k] = layer.firstVertex + place[ordered[3 * t + uint32_t(k)]];
    }
    const auto reorder = [&](auto& values) {
        auto moved = values;
        for (size_t v = 0; v < newOf.size(); ++v) moved[newOf[v]] = values[v];
        values = std::move(moved);
    };
    reorder(seamed.old), reorder(seamed.uv);
    reorder(mesh.restPositions), reorder(mesh.colours), reorder(mesh.jointIndices), reorder(mesh.jointWeights);
}

Result<std::vector<uint8_t>> compressByMeshopt(std::span<const uint8_t> glb) try {
    DPL_TRY(const GltfModel model, parseGlb(glb, {}));
    Json root = Json::parse(model.json);
    const CodesOfViews codes(root);
    ViewMover mover(model);
    if (root.contains("bufferViews"))
        for (size_t v = 0; v < root["bufferViews"].size(); ++v) mover.move(v, root["bufferViews"][v], codes.of(v));
    if (mover.decodedBytes() == 0) return std::vector<uint8_t>(glb.begin(), glb.end());
    root["buffers"] = Json::array({{{"byteLength", mover.bin().size()}},
                                   {{"byteLength", mover.decodedBytes()}, {"extensions", {{kExtension, {{"fallback", true}}}}}}});
    for (const char* list : {"extensionsUsed", "extensionsRequired"}) root[list].push_back(kExtension);
    return glbOf(root.dump(), mover.bin());
} catch (const Json::exception& e) {
    return fail(Code::CorruptData, "the mesh cannot be compressed: {}", e.what());
}

}  // namespace dpl
