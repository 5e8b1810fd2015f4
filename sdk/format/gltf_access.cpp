// SPDX-License-Identifier: Apache-2.0
// Reads the values of accessors and primitives of a checked glTF.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "sdk/format/draco_mesh.h"
#include "sdk/format/gltf_model.h"

namespace dpl {
namespace {

size_t bytesOf(GltfComponent c) {
    return c == GltfComponent::I8 || c == GltfComponent::U8 ? 1 : c == GltfComponent::I16 || c == GltfComponent::U16 ? 2 : 4;
}

template <class T>
float loadAs(const uint8_t* from) {
    T x;
    std::memcpy(&x, from, sizeof(T));
    return float(x);
}

float load(const uint8_t* from, GltfComponent component) {
    switch (component) {
        case GltfComponent::I8:
            return loadAs<int8_t>(from);
        case GltfComponent::U8:
            return loadAs<uint8_t>(from);
        case GltfComponent::I16:
            return loadAs<int16_t>(from);
        case GltfComponent::U16:
            return loadAs<uint16_t>(from);
        case GltfComponent::U32:
            return loadAs<uint32_t>(from);
        case GltfComponent::F32:
            return loadAs<float>(from);
    }
    return 0;
}

float normalise(float raw, GltfComponent component) {
    switch (component) {
        case GltfComponent::I8:
            return std::max(raw / 127.0f, -1.0f);
        case GltfComponent::U8:
            return raw / 255.0f;
        case GltfComponent::I16:
            return std::max(raw / 32767.0f, -1.0f);
        case GltfComponent::U16:
            return raw / 65535.0f;
        default:
            return raw;
    }
}

uint32_t loadIndex(const uint8_t* from, GltfComponent component) {
    if (component == GltfComponent::U8) return *from;
    if (component == GltfComponent::U16) {
        uint16_t x;
        std::memcpy(&x, from, 2);
        return x;
    }
    uint32_t x;
    std::memcpy(&x, from, 4);
    return x;
}

size_t strideOf(const GltfModel& m, const GltfAccessor& a) {
    return m.views[a.view].stride ? m.views[a.view].stride : bytesOf(a.component) * a.components;
}

Status finite(const std::vector<float>& values, uint32_t components, uint32_t accessor) {
    for (size_t i = 0; i < values.size(); ++i)
        if (!std::isfinite(values[i]))
            return fail(Code::CorruptData, "element {} of accessor {} is not a finite number", i / components, accessor);
    return {};
}

Status applySparse(const GltfModel& m, const GltfAccessor& a, std::vector<float>& values) {
    const uint8_t* indices = m.bin.data() + m.views[a.sparse.indexView].offset + a.sparse.indexOffset;
    const uint8_t* from = m.bin.data() + m.views[a.sparse.valueView].offset + a.sparse.valueOffset;
    const size_t indexBytes = bytesOf(a.sparse.indexComponent), bytes = bytesOf(a.component);
    for (uint32_t i = 0; i < a.sparse.count; ++i) {
        const uint32_t at = loadIndex(indices + i * indexBytes, a.sparse.indexComponent);
        if (at >= a.count) return fail(Code::CorruptData, "a sparse accessor writes element {} of {}", at, a.count);
        for (uint32_t k = 0; k < a.components; ++k)
            values[size_t(at) * a.components + k] = load(from + (size_t(i) * a.components + k) * bytes, a.component);
    }
    return {};
}

}  // namespace

Result<std::vector<float>> readFloats(const GltfModel& m, uint32_t accessor, uint32_t wanted) {
    DPL_TRY(std::vector<float> values, readAnyFloats(m, accessor, wanted));
    DPL_RETURN_IF_ERROR(finite(values, wanted, accessor));
    return values;
}

Result<std::vector<float>> readAnyFloats(const GltfModel& m, uint32_t accessor, uint32_t wanted) {
    const GltfAccessor& a = m.accessors[accessor];
    if (a.components != wanted)
        return fail(Code::CorruptData, "accessor {} has {} components, {} expected", accessor, a.components, wanted);
    if (a.view < 0 && a.sparse.count == 0) return fail(Code::CorruptData, "accessor {} has no data", accessor);
    std::vector<float> values(size_t(a.count) * a.components, 0.0f);
    if (a.view >= 0) {
        const uint8_t* from = m.bin.data() + m.views[a.view].offset + a.offset;
        const size_t stride = strideOf(m, a), bytes = bytesOf(a.component);
        for (uint32_t i = 0; i < a.count; ++i)
            for (uint32_t k = 0; k < a.components; ++k)
                values[size_t(i) * a.components + k] = load(from + i * stride + k * bytes, a.component);
    }
    if (a.sparse.count) DPL_RETURN_IF_ERROR(applySparse(m, a, values));
    if (a.normalized)
        for (float& v : values) v = normalise(v, a.component);
    return values;
}

Result<std::vector<uint32_t>> readIndices(const GltfModel& m, uint32_t accessor) {
    const GltfAccessor& a = m.accessors[accessor];
    const bool isUnsigned = a.component == GltfComponent::U8 || a.component == GltfComponent::U16 || a.component == GltfComponent::U32;
    if (a.components != 1 || !isUnsigned || a.view < 0 || a.sparse.count)
        return fail(Code::CorruptData, "accessor {} does not hold indices", accessor);
    std::vector<uint32_t> values(a.count);
    const uint8_t* from = m.bin.data() + m.views[a.view].offset + a.offset;
    const size_t stride = strideOf(m, a);
    for (uint32_t i = 0; i < a.count; ++i) values[i] = loadIndex(from + i * stride, a.component);
    return values;
}

Result<PrimitiveReader> PrimitiveReader::open(const GltfModel& m, const GltfPrimitive& p, const ReadLimits& limits) {
    PrimitiveReader r;
    r.model_ = &m, r.primitive_ = &p;
    if (p.mode != 4) return fail(Code::Unsupported, "a mesh of mode {}; only triangle lists are read", p.mode);
    const auto position = p.attributes.find("POSITION");
    if (position == p.attributes.end()) return fail(Code::CorruptData, "a mesh has no positions");
    const GltfAccessor& positions = m.accessors[position->second];
    r.vertexCount_ = positions.count;
    if (r.vertexCount_ > limits.maxVertices)
        return fail(Code::CorruptData, "a mesh of {} vertices, the limit is {}", r.vertexCount_, limits.maxVertices);
    if (p.dracoView < 0 && positions.view < 0) return fail(Code::CorruptData, "the positions of a mesh have no data");
    for (const auto& [semantic, accessor] : p.attributes)
        if (m.accessors[accessor].count != r.vertexCount_)
            return fail(Code::CorruptData, "{} has {} entries for {} vertices", semantic, m.accessors[accessor].count, r.vertexCount_);
    const uint32_t indexCount = p.indices >= 0 ? m.accessors[p.indices].count : r.vertexCount_;
    if (indexCount % 3 != 0 || indexCount / 3 > limits.maxTriangles)
        return fail(Code::CorruptData, "a mesh of {} indices: not whole triangles, or above the limit of {}", indexCount,
                    limits.maxTriangles);
    if (p.dracoView >= 0) {
        DPL_TRY(DracoDecoded decoded, decodeDraco(m.viewBytes(uint32_t(p.dracoView)), r.vertexCount_, indexCount / 3));
        for (const auto& [semantic, id] : p.dracoAttributes) {
            const auto attribute = p.attributes.find(semantic);
            if (attribute == p.attributes.end() || !decoded.values.contains(id))
                return fail(Code::CorruptData, "the compressed attribute {} is not in the mesh", semantic);
            if (decoded.components[id] != m.accessors[attribute->second].components)
                return fail(Code::CorruptData, "the compressed attribute {} has {} components", semantic, decoded.components[id]);
        }
        r.triangles_ = std::move(decoded.triangles);
        r.dracoValues_ = std::move(decoded.values);
        return r;
    }
    r.triangles_.resize(indexCount / 3);
    std::vector<uint32_t> indices;
    if (p.indices >= 0) {
        DPL_TRY(indices, readIndices(m, uint32_t(p.indices)));
    }
    for (uint32_t i = 0; i < indexCount; ++i) {
        const uint32_t vertex = p.indices >= 0 ? indices[i] : i;
        if (vertex >= r.vertexCount_) return fail(Code::CorruptData, "index {} of a mesh names vertex {} of {}", i, vertex, r.vertexCount_);
        r.triangles_[i / 3][int(i % 3)] = vertex;
    }
    return r;
}

Result<std::vector<float>> PrimitiveReader::floats(const char* semantic, uint32_t components) const {
    const auto attribute = primitive_->attributes.find(semantic);
    if (attribute == primitive_->attributes.end()) return fail(Code::CorruptData, "a mesh has no {}", semantic);
    const auto compressed = primitive_->dracoAttributes.find(semantic);
    if (primitive_->dracoView < 0 || compressed == primitive_->dracoAttributes.end())
        return readFloats(*model_, attribute->second, components);
    const GltfAccessor& a = model_->accessors[attribute->second];
    if (a.components != components) return fail(Code::CorruptData, "{} has {} components, {} expected", semantic, a.components, components);
    std::vector<float> values = dracoValues_.at(compressed->second);
    if (a.normalized)
        for (float& v : values) v = normalise(v, a.component);
    DPL_RETURN_IF_ERROR(finite(values, components, attribute->second));
    return values;
}

}  // namespace dpl
