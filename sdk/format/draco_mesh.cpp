// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/draco_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>

#include <draco/compression/config/decoder_options.h>
#include <draco/compression/expert_encode.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/mesh/mesh.h>

#include "sdk/core/reader.h"
#include "sdk/format/avatar_file.h"

namespace dpl {
namespace {

constexpr int kMaxAttributes = 16;
constexpr int kNormalBits = 12, kUvBits = 16;
constexpr uint64_t kVerticesPerByte = 8, kTrianglesPerByte = 16, kFreeElements = 256;

/** A Draco decoder that checks the attributes after their headers and before Draco allocates their values. */
template <class Base>
class Bounded : public Base {
public:
    explicit Bounded(uint32_t vertexCount) : vertexCount_(vertexCount) {}

protected:
    bool DecodeAllAttributes() override {
        const draco::PointCloud* cloud = this->point_cloud();
        if (cloud->num_points() != vertexCount_ || cloud->num_attributes() > kMaxAttributes) return false;
        for (int i = 0; i < cloud->num_attributes(); ++i) {
            const draco::PointAttribute* a = cloud->attribute(i);
            if (a->num_components() < 1 || a->num_components() > 4 || draco::DataTypeLength(a->data_type()) < 1 ||
                draco::DataTypeLength(a->data_type()) > 4)
                return false;
        }
        return Base::DecodeAllAttributes();
    }

private:
    uint32_t vertexCount_;
};

Result<uint32_t> varint(Reader& in) {
    uint64_t value = 0;
    for (uint32_t shift = 0; shift < 35; shift += 7) {
        DPL_TRY(uint8_t byte, in.value<uint8_t>());
        value |= uint64_t(byte & 0x7f) << shift;
        if (byte & 0x80) continue;
        if (value > std::numeric_limits<uint32_t>::max()) break;
        return uint32_t(value);
    }
    return fail(Code::CorruptData, "a count in a Draco mesh is too long");
}

struct DracoCounts {
    bool edgebreaker = false;
    uint32_t faces = 0, vertices = 0;
};

/** Reads the header and the counts behind it (Draco bitstream 2.2) without Draco. */
Result<DracoCounts> readCounts(std::span<const uint8_t> bytes) {
    Reader in(bytes);
    DPL_TRY(auto magic, in.take(5));
    if (std::memcmp(magic.data(), "DRACO", 5) != 0) return fail(Code::CorruptData, "a compressed mesh does not begin with 'DRACO'");
    DPL_TRY(uint8_t major, in.value<uint8_t>());
    DPL_TRY(uint8_t minor, in.value<uint8_t>());
    if (major != 2 || minor != 2) return fail(Code::Unsupported, "Draco bitstream {}.{}, glTF uses 2.2", int(major), int(minor));
    DPL_TRY(uint8_t geometry, in.value<uint8_t>());
    DPL_TRY(uint8_t method, in.value<uint8_t>());
    DPL_TRY(uint16_t flags, in.value<uint16_t>());
    if (geometry != 1 || method > 1) return fail(Code::CorruptData, "Draco data that is not a triangle mesh");
    if (flags != 0) return fail(Code::Unsupported, "Draco metadata; export the mesh without it");
    DracoCounts counts;
    counts.edgebreaker = method == 1;
    if (counts.edgebreaker) {
        DPL_RETURN_IF_ERROR(in.skip(1));
        DPL_TRY(counts.vertices, varint(in));
        DPL_TRY(counts.faces, varint(in));
    } else {
        DPL_TRY(counts.faces, varint(in));
        DPL_TRY(counts.vertices, varint(in));
    }
    return counts;
}

template <class Decoder>
bool runDecoder(std::span<const uint8_t> bytes, uint32_t vertexCount, draco::Mesh* mesh) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    Bounded<Decoder> decoder(vertexCount);
    const draco::DecoderOptions options;
    return decoder.Decode(options, &buffer, mesh).ok();
}

template <class T, size_t N>
int addAttribute(draco::Mesh& mesh, draco::GeometryAttribute::Type type, draco::DataType dataType, bool normalized,
                 const std::vector<std::array<T, N>>& values) {
    draco::GeometryAttribute description;
    description.Init(type, nullptr, N, dataType, normalized, sizeof(T) * N, 0);
    const int id = mesh.AddAttribute(description, true, uint32_t(values.size()));
    draco::PointAttribute* attribute = mesh.attribute(id);
    for (uint32_t v = 0; v < values.size(); ++v) attribute->SetAttributeValue(draco::AttributeValueIndex(v), values[v].data());
    return id;
}

/** Draco keeps options as text. Its setters print six decimals, too few for the lattice, so this writes the text itself. */
draco::Options latticeQuantization(int bits, const Vec3f& origin) {
    char text[96];
    draco::Options options;
    options.SetInt("quantization_bits", bits);
    std::snprintf(text, sizeof(text), "%.12g %.12g %.12g", double(origin.x), double(origin.y), double(origin.z));
    options.SetString("quantization_origin", text);
    std::snprintf(text, sizeof(text), "%.12g", (std::exp2(bits) - 1) * double(kPositionStepM));
    options.SetString("quantization_range", text);
    return options;
}

template <class T, class V>
std::vector<std::array<T, 4>> asArrays(const std::vector<V>& values) {
    std::vector<std::array<T, 4>> out(values.size());
    for (size_t v = 0; v < values.size(); ++v) out[v] = {T(values[v].x), T(values[v].y), T(values[v].z), T(values[v].w)};
    return out;
}

}  // namespace

Result<std::vector<uint8_t>> encodeDraco(const LayerMesh& mesh) try {
    const uint32_t vertexCount = uint32_t(mesh.positions.size());
    draco::Mesh out;
    out.set_num_points(vertexCount);
    out.SetNumFaces(mesh.triangles.size());
    for (uint32_t f = 0; f < mesh.triangles.size(); ++f) {
        const glm::uvec3& t = mesh.triangles[f];
        out.SetFace(draco::FaceIndex(f), {draco::PointIndex(t.x), draco::PointIndex(t.y), draco::PointIndex(t.z)});
    }
    Vec3f low(0), high(0);
    std::vector<std::array<float, 3>> positions(vertexCount);
    for (uint32_t v = 0; v < vertexCount; ++v) {
        const Vec3f& p = mesh.positions[v];
        low = v ? glm::min(low, p) : p, high = v ? glm::max(high, p) : p;
        positions[v] = {p.x, p.y, p.z};
    }
    const int position = addAttribute(out, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, false, positions);
    out.attribute(position)->set_unique_id(kDracoPosition);
    auto add = [&](draco::GeometryAttribute::Type type, draco::DataType dataType, bool normalized, const auto& values, uint32_t id) {
        if (values.empty()) return -1;
        const int attribute = addAttribute(out, type, dataType, normalized, values);
        out.attribute(attribute)->set_unique_id(id);
        return attribute;
    };
    add(draco::GeometryAttribute::COLOR, draco::DT_UINT16, true, asArrays<uint16_t>(mesh.colours), kDracoColour);
    if (mesh.wideJoints)
        add(draco::GeometryAttribute::GENERIC, draco::DT_UINT16, false, asArrays<uint16_t>(mesh.joints), kDracoJoints);
    else
        add(draco::GeometryAttribute::GENERIC, draco::DT_UINT8, false, asArrays<uint8_t>(mesh.joints), kDracoJoints);
    add(draco::GeometryAttribute::GENERIC, draco::DT_UINT8, true, asArrays<uint8_t>(mesh.weights), kDracoWeights);
    std::vector<std::array<float, 3>> normals;
    for (const Vec3f& n : mesh.normals) normals.push_back({n.x, n.y, n.z});
    std::vector<std::array<float, 2>> uv;
    for (const Vec2f& at : mesh.uv) uv.push_back({at.x, at.y});
    const int normal = add(draco::GeometryAttribute::NORMAL, draco::DT_FLOAT32, false, normals, kDracoNormal);
    const int place = add(draco::GeometryAttribute::TEX_COORD, draco::DT_FLOAT32, false, uv, kDracoUv);

    // The step is a power of two and the range a whole number of steps, so quantising lattice positions is exact in both directions.
    const Vec3f extent = (high - low) / kPositionStepM;
    const float steps = std::max({extent.x, extent.y, extent.z});
    int bits = 14;
    while (std::exp2(float(bits)) - 1 < steps) ++bits;
    draco::ExpertEncoder encoder(out);
    encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);
    encoder.SetSpeedOptions(1, 1);
    encoder.options().SetAttributeOptions(position, latticeQuantization(bits, low));
    if (normal >= 0) encoder.SetAttributeQuantization(normal, kNormalBits);
    if (place >= 0) encoder.SetAttributeQuantization(place, kUvBits);
    // Draco before 1.5.7 writes small, regular meshes that no Draco reads: alphabets far larger than the bytes behind them
    // (github.com/google/draco/issues/1013). Attributes of such a mesh are stored as they are.
    encoder.options().SetGlobalBool("compress_connectivity", true);
    for (const bool entropyCoded : {true, false}) {
        encoder.options().SetGlobalBool("use_built_in_attribute_compression", entropyCoded);
        draco::EncoderBuffer buffer;
        if (auto status = encoder.EncodeToBuffer(&buffer); !status.ok())
            return fail(Code::Internal, "Draco could not encode a layer: {}", status.error_msg_string());
        std::vector<uint8_t> bytes(buffer.data(), buffer.data() + buffer.size());
        draco::Mesh read;
        if (runDecoder<draco::MeshSequentialDecoder>(bytes, vertexCount, &read)) return bytes;
    }
    return fail(Code::Internal, "Draco cannot read the layer that it wrote");
} catch (const std::bad_alloc&) {
    return outOfMemory("compress a mesh");
} catch (const std::exception& e) {
    return fail(Code::Internal, "Draco could not encode a layer: {}", e.what());
}

Result<DracoDecoded> decodeDraco(std::span<const uint8_t> bytes, uint32_t vertexCount, uint32_t triangleCount) try {
    DPL_TRY(const DracoCounts counts, readCounts(bytes));
    // Edgebreaker may split vertices at seams later, so its count is a lower bound.
    if (counts.faces != triangleCount || (counts.edgebreaker ? counts.vertices > vertexCount : counts.vertices != vertexCount))
        return fail(Code::CorruptData, "a Draco mesh of {} vertices and {} triangles, its accessors say {} and {}", counts.vertices,
                    counts.faces, vertexCount, triangleCount);
    if (vertexCount > bytes.size() * kVerticesPerByte + kFreeElements || triangleCount > bytes.size() * kTrianglesPerByte + kFreeElements)
        return fail(Code::CorruptData, "a Draco mesh of {} vertices and {} triangles in {} bytes", vertexCount, triangleCount,
                    bytes.size());
    draco::Mesh mesh;
    const bool ok = counts.edgebreaker ? runDecoder<draco::MeshEdgebreakerDecoder>(bytes, vertexCount, &mesh)
                                       : runDecoder<draco::MeshSequentialDecoder>(bytes, vertexCount, &mesh);
    if (!ok) return fail(Code::CorruptData, "a Draco mesh cannot be decoded; the file is damaged");
    if (mesh.num_points() != vertexCount || mesh.num_faces() != triangleCount)
        return fail(Code::CorruptData, "a Draco mesh decodes to other counts than promised");

    DracoDecoded out;
    out.triangles.resize(triangleCount);
    for (uint32_t f = 0; f < triangleCount; ++f) {
        const draco::Mesh::Face& face = mesh.face(draco::FaceIndex(f));
        out.triangles[f] = {face[0].value(), face[1].value(), face[2].value()};
        if (std::max({out.triangles[f].x, out.triangles[f].y, out.triangles[f].z}) >= vertexCount)
            return fail(Code::CorruptData, "triangle {} of a Draco mesh points past its vertices", f);
    }
    for (int i = 0; i < mesh.num_attributes(); ++i) {
        const draco::PointAttribute* a = mesh.attribute(i);
        const uint32_t components = a->num_components();
        if (out.values.contains(a->unique_id()))
            return fail(Code::CorruptData, "a Draco mesh has two attributes with id {}", a->unique_id());
        std::vector<float>& values = out.values[a->unique_id()];
        out.components[a->unique_id()] = components;
        values.resize(size_t(vertexCount) * components);
        for (uint32_t v = 0; v < vertexCount; ++v) {
            const draco::AttributeValueIndex at = a->mapped_index(draco::PointIndex(v));
            if (at.value() >= a->size()) return fail(Code::CorruptData, "a Draco attribute has fewer values than vertices");
            // ConvertValue<float> would divide a normalised integer by its maximum; the raw value is needed.
            float* to = values.data() + size_t(v) * components;
            const uint8_t* raw = a->GetAddress(at);
            for (uint32_t k = 0; k < components; ++k) {
                auto take = [&]<class T>(T) {
                    T x;
                    std::memcpy(&x, raw + k * sizeof(T), sizeof(T));
                    to[k] = float(x);
                };
                switch (a->data_type()) {
                    case draco::DT_INT8:
                        take(int8_t());
                        break;
                    case draco::DT_UINT8:
                        take(uint8_t());
                        break;
                    case draco::DT_INT16:
                        take(int16_t());
                        break;
                    case draco::DT_UINT16:
                        take(uint16_t());
                        break;
                    case draco::DT_FLOAT32:
                        take(float());
                        break;
                    default:
                        return fail(Code::Unsupported, "a Draco attribute of type {}", int(a->data_type()));
                }
            }
        }
    }
    return out;
} catch (const std::bad_alloc&) {
    return outOfMemory("decode a mesh");
} catch (const std::exception& e) {
    return fail(Code::CorruptData, "a Draco mesh cannot be decoded: {}", e.what());
}

}  // namespace dpl
