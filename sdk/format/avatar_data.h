// SPDX-License-Identifier: Apache-2.0
// An avatar as plain arrays: what the file holds after decoding, and what packaging hands to the writer. No behaviour.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sdk/math/projection.h"
#include "sdk/math/types.h"

namespace dpl {

/** A joint of the rig. All joint frames are parallel to the world at rest, so a rest pose is positions only; joint j turns
 *  about restPosition relative to its parent:  G_j = G_parent · [R_j | p_j − R_j p_j],  v' = Σ_j w_j G_j v. */
struct JointData {
    std::string name;
    int32_t parent = -1;       // parents come first
    Vec3f restPosition{0};     // metres, avatar space (world at rest)
    std::string humanoidBone;  // VRM humanoid name ("hips", "leftUpperArm" ...) or empty
};

/** A contiguous range of vertices and triangles with one role; never shares vertices with another layer. */
struct LayerData {
    std::string name;  // "body", "top", ...
    std::string role;  // "body" | "garment" | "hair"
    uint32_t firstVertex = 0, vertexCount = 0;
    uint32_t firstTriangle = 0, triangleCount = 0;
};

struct MeshData {
    std::vector<Vec3f> restPositions;        // V, metres, rest pose, static offsets folded in
    std::vector<glm::u8vec4> colours;        // V, sRGB + alpha 255, for stock viewers
    std::vector<glm::u16vec4> jointIndices;  // V
    std::vector<glm::u8vec4> jointWeights;   // V, unorm8, each sums to 255
    std::vector<Triangle> triangles;         // F, indices into the whole vertex array
    std::vector<LayerData> layers;
};

constexpr uint8_t kSplatSingleFace = 1;  // draws only from outside (gate of projection.h)
constexpr uint8_t kSplatCloth = 2;       // label channel: cloth, else body

/** N flat splats, sorted by triangle (layers are triangle ranges), then Morton order inside it: the parent costs no bytes. */
struct SplatData {
    std::vector<uint32_t> triangleStart;  // F+1: splats of triangle t are [triangleStart[t], triangleStart[t+1])
    std::vector<Vec2f> uv;                // barycentric of corners 1 and 2
    std::vector<float> phi;               // radians, in the rest plane from T1
    std::vector<Vec2f> scaleM;            // standard deviations along the two axes at rest, metres (linear)
    std::vector<float> opacity;           // [0,1]
    std::vector<uint8_t> flags;
    uint32_t shDegree = 0;
    std::vector<float> sh;  // N × (degree+1)² × 3, coefficient-major, rest frame of the avatar

    uint32_t count() const { return uint32_t(uv.size()); }
};

/** How the surface and its brightness follow the pose (docs/reference/correctives.md): offsets and light of coarse control nodes, linear in
 *  K numbers of the pose, spread to the vertices by four weights each. Empty (nodeCount 0): the avatar has none.
 *
 *      d = feature(pose) − mean;   k = modes · d;   off² = ‖d‖² − Σ_i k_i² / ‖mode_i‖²
 *      k ← k · min(1, reach / ‖k‖) · min(1, reachOffModes / off);   node = Σ_i k_i · nodes[n][i];   (ΔV, L − 1)_v = Σ weight · node
 *
 *  The feature is the first two columns of each named joint's local rotation, minus those of the identity: 6 numbers a joint. Modes are
 *  orthogonal, so `off` is the pose's distance from what they span: what was learned fades where nothing was learned. */
struct PoseCorrectiveData {
    uint32_t modeCount = 0, nodeCount = 0;  // K, M
    std::vector<uint32_t> joints;           // J: rising indices of the joints that are heard
    std::vector<float> mean;                // 6·J
    std::vector<float> modes;               // K × 6·J
    float reach = 0;                        // ‖k‖ of far training poses: longer ones are shortened to it
    float reachOffModes = 1e6f;             // `off` of far training poses, or so much that nothing fades
    std::vector<glm::u16vec4> nodeIndices;  // V
    std::vector<glm::u8vec4> nodeWeights;   // V, unorm8, each sums to 255
    std::vector<Vec4f> nodes;               // M × K: offset in metres (rest pose), change of brightness

    bool empty() const { return nodeCount == 0; }
};

/** One row of the evidence table: a part that was kept or left out, and why. */
struct EvidenceData {
    std::string part;  // "sh degree 2", "pose-dependent offsets" ...
    bool kept = false;
    float gainDb = 0;    // held-out gain when kept (0 when not measured; then `reason` says so)
    uint64_t bytes = 0;  // its cost in the file
    std::string reason;
};

struct ClipChannel {
    uint32_t joint = 0;
    std::vector<Quatf> rotations;  // one per time
};

/** A clip on this avatar's own rig: local rotations as in JointData, and the root's translation. */
struct ClipData {
    std::string name;
    std::vector<float> timesS;            // strictly rising
    std::vector<ClipChannel> channels;    // joints without a channel stay at rest
    std::vector<Vec3f> rootTranslations;  // one per time, or empty: stays at the origin
};

struct AvatarData {
    std::string name;
    std::string generator;
    std::vector<JointData> joints;
    MeshData mesh;
    SplatData splats;
    PoseCorrectiveData correctives;
    std::vector<ClipData> clips;
    std::vector<EvidenceData> evidence;
    float kappaPx2 = float(kKappaPx2);
    bool compensated = true;  // energy-preserving low-pass (projection.h)
    float trainedPixelM = 0;  // size of a pixel of the training at the subject, metres (sdk/math/coverage.h); 0: not known
};

/** General (unbound) splats, as in INRIA PLY and SPZ files: means, full covariances, in the file's own coordinates. */
struct StaticSplatData {
    std::vector<Vec3f> position;  // metres
    std::vector<Quatf> rotation;  // unit
    std::vector<Vec3f> scaleM;    // standard deviations, linear
    std::vector<float> opacity;   // [0,1]
    uint32_t shDegree = 0;
    std::vector<float> sh;              // N × (degree+1)² × 3, coefficient-major
    float kappaPx2 = float(kKappaPx2);  // the low-pass that they were trained with ...
    bool compensated = false;           // ... and whether it kept their energy ("antialiased")
    uint32_t count() const { return uint32_t(position.size()); }
};

}  // namespace dpl
