// SPDX-License-Identifier: Apache-2.0
// Reads any skinned glTF 2.0 binary into plain arrays: meshes, one joint list, node tree, morph targets, animations. Used for bodies and
// clips; avatars have their own reader (avatar_file.h). Both make the checks of parseGlb first.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/read_limits.h"
#include "sdk/math/types.h"

namespace dpl {

struct SkinnedGltf {
    /** A node at rest: parentFromNode = T(translation)·R(rotation)·S(scale). The rest rotation may be any. */
    struct Node {
        std::string name;
        int32_t parent = -1;  // index into nodes; parents come first
        Vec3f translation{0};
        Quatf rotation{1, 0, 0, 0};  // unit
        Vec3f scale{1};
        std::string humanoidBone;  // VRM 1 name, where the file states it (VRM 0, VRM 1, VRM animation)
    };
    struct Joint {
        uint32_t node = 0;       // index into nodes
        Mat4f jointFromMesh{1};  // inverse bind matrix, from mesh space (bind pose) to joint space
    };
    struct Morph {
        std::string name;  // from mesh.extras.targetNames, else "morph0", "morph1" ...
        float restWeight = 0;
        std::vector<Vec3f> offsets;  // V, mesh space, at weight 1
    };
    /** One primitive. Vertices and triangles keep the order of the file. */
    struct Mesh {
        std::string name;
        int32_t node = -1;  // node that carries it; its transform does not apply to a skinned mesh
        bool skinned = false;
        std::vector<Vec3f> positions;            // V, mesh space
        std::vector<Vec2f> uv;                   // V or empty (TEXCOORD_0)
        std::vector<Vec4f> colours;              // V or empty (COLOR_0, as stored, 0..1)
        std::vector<glm::u16vec4> jointIndices;  // V or empty, indices into joints
        std::vector<Vec4f> jointWeights;         // V or empty; the four largest, sum 1 (unorm8: skin_weights.h)
        std::vector<glm::uvec3> triangles;
        std::vector<Morph> morphs;
    };
    enum class Path : uint8_t { Translation, Rotation, Scale };
    enum class Interpolation : uint8_t { Step, Linear, Cubic };
    struct Channel {
        uint32_t node = 0;
        Path path = Path::Rotation;
        Interpolation interpolation = Interpolation::Linear;
        std::vector<float> timesS;  // rising, not empty
        std::vector<Vec4f> values;  // one per time (Cubic: in-tangent, value, out-tangent); rotations xyzw, others xyz0
    };
    struct Animation {
        std::string name;
        std::vector<Channel> channels;  // without channels of morph weights, and without those of which no key is sound
        std::string leftOut;            // a sentence: keys that are not sound, by channel; empty: none
        float endS() const;
    };

    std::vector<Node> nodes;
    std::vector<Joint> joints;  // of all skins in use; a node with the same bind pose occurs once
    std::vector<Mesh> meshes;
    std::vector<Animation> animations;

    /** sceneFromNode at rest, one per node. */
    std::vector<Mat4f> restTransforms() const;
};

struct SkinnedGltfOptions {
    bool requireSkin = true;  // false: for clip files, which may have nodes and animations only
    ReadLimits limits;
};

/** Reads a .glb, also with KHR_draco_mesh_compression and sparse accessors. The bytes may be freed on return. Any thread.
 *  Keys of animations that are not sound are left out and named: a time that is not finite or does not rise, numbers that are not finite or
 *  beyond 10⁹, a rotation without length.
 *  CorruptData: damaged bytes. Unsupported: not a .glb, external buffers, a required extension that is not known.
 *  NotFound, with requireSkin: no mesh is skinned; the text says "no skin weights" if there are meshes. */
Result<SkinnedGltf> readSkinnedGltf(std::span<const uint8_t> bytes, const SkinnedGltfOptions& options = {});

/** Value of a channel at a time; before the first and after the last key the value is held. Rotations are unit xyzw. */
Vec4f sampleChannel(const SkinnedGltf::Channel& channel, float timeS);

}  // namespace dpl
