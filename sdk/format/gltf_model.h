// SPDX-License-Identifier: Apache-2.0
// A glTF 2.0 binary. parseGlb has checked every index and byte range against the file. Internal.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/read_limits.h"
#include "sdk/math/types.h"

namespace dpl {

struct GltfView {
    size_t offset = 0, length = 0;  // inside the binary chunk
    size_t stride = 0;              // 0: tightly packed
};

enum class GltfComponent : uint32_t { I8 = 5120, U8 = 5121, I16 = 5122, U16 = 5123, U32 = 5125, F32 = 5126 };

struct GltfAccessor {
    int32_t view = -1;  // -1: zeros, or filled by Draco
    size_t offset = 0;
    GltfComponent component = GltfComponent::F32;
    uint32_t components = 1;  // 1, 2, 3, 4 or 16
    bool normalized = false;
    uint32_t count = 0;
    std::vector<double> least, largest;  // of each component, as stated; may be empty
    struct Sparse {
        uint32_t count = 0;
        int32_t indexView = -1, valueView = -1;
        size_t indexOffset = 0, valueOffset = 0;
        GltfComponent indexComponent = GltfComponent::U32;
    } sparse;  // count 0: dense
};

/** Extension KHR_gaussian_splatting of a primitive, with defaults filled in. */
struct GltfSplatting {
    std::string kernel, colorSpace, projection = "perspective", sortingMethod = "cameraDistance";
    std::string extension;  // name of an extension inside it, such as a compression; empty: none
};

struct GltfPrimitive {
    std::map<std::string, uint32_t> attributes;  // semantic -> accessor
    int32_t indices = -1;
    int32_t mode = 4;
    std::vector<std::map<std::string, uint32_t>> targets;
    int32_t dracoView = -1;
    std::map<std::string, uint32_t> dracoAttributes;  // semantic -> Draco unique id
    std::optional<GltfSplatting> splatting;
};

struct GltfMesh {
    std::string name;
    std::vector<GltfPrimitive> primitives;
    std::vector<float> weights;
    std::vector<std::string> targetNames;
};

struct GltfNode {
    std::string name;
    std::string humanoidBone;  // of VRM 1, as the file states it; empty: none
    int32_t parent = -1, mesh = -1, skin = -1;
    std::vector<uint32_t> children;
    Vec3f translation{0}, scale{1};
    Quatf rotation{1, 0, 0, 0};
};

struct GltfSkin {
    std::string name;
    int32_t inverseBind = -1;
    std::vector<uint32_t> joints;
};

struct GltfAnimation {
    struct Sampler {
        uint32_t input = 0, output = 0;
        std::string interpolation;
    };
    struct Channel {
        int32_t node = -1;
        std::string path;
        uint32_t sampler = 0;
    };
    std::string name;
    std::vector<Sampler> samplers;
    std::vector<Channel> channels;
};

struct GltfModel {
    std::span<const uint8_t> bin;  // borrowed from the caller's bytes
    std::string_view json;         // borrowed, the whole JSON chunk
    uint32_t jsonValues = 0;       // in it, keys included
    std::string generator, sceneName;
    std::vector<GltfView> views;
    std::vector<GltfAccessor> accessors;
    std::vector<GltfMesh> meshes;
    std::vector<GltfNode> nodes;  // a forest: each node has at most one parent, no cycles
    std::vector<GltfSkin> skins;
    std::vector<GltfAnimation> animations;
    std::string avatarExtension;  // JSON text of DPL_gaussian_avatar; empty if absent

    std::span<const uint8_t> viewBytes(uint32_t view) const { return bin.subspan(views[view].offset, views[view].length); }
};

/** Opens a .glb. Checks header and chunk lengths, then depth and size of the JSON by a SAX pass; parses the known keys by tinygltf; checks
 *  every index and range. The result borrows `bytes`. Throws nothing. */
Result<GltfModel> parseGlb(std::span<const uint8_t> bytes, const ReadLimits& limits);

/** All values of an accessor as floats, the components of an element one after another. Integers are normalised if the accessor says so;
 *  sparse values are applied. The accessor must have `wanted` components. Memory: 4 bytes per value. */
Result<std::vector<float>> readFloats(const GltfModel& model, uint32_t accessor, uint32_t wanted);
/** The same, but values may be infinite or no numbers. */
Result<std::vector<float>> readAnyFloats(const GltfModel& model, uint32_t accessor, uint32_t wanted);
/** Values of an accessor of unsigned scalars. */
Result<std::vector<uint32_t>> readIndices(const GltfModel& model, uint32_t accessor);

/** Vertices and triangles of one primitive, with or without Draco. Borrows model and primitive. */
class PrimitiveReader {
public:
    /** Opens a triangle list. Checks counts against `limits` before Draco decodes anything. */
    static Result<PrimitiveReader> open(const GltfModel& model, const GltfPrimitive& primitive, const ReadLimits& limits);

    uint32_t vertexCount() const { return vertexCount_; }
    std::vector<glm::uvec3>& triangles() { return triangles_; }
    bool has(const char* semantic) const { return primitive_->attributes.contains(semantic); }
    /** vertexCount × components floats. CorruptData if the attribute is absent. */
    Result<std::vector<float>> floats(const char* semantic, uint32_t components) const;
    uint32_t componentsOf(const char* semantic) const { return model_->accessors[primitive_->attributes.at(semantic)].components; }

private:
    const GltfModel* model_ = nullptr;
    const GltfPrimitive* primitive_ = nullptr;
    uint32_t vertexCount_ = 0;
    std::vector<glm::uvec3> triangles_;
    std::map<uint32_t, std::vector<float>> dracoValues_;  // by unique id; not normalised
};

}  // namespace dpl
