// SPDX-License-Identifier: Apache-2.0
// An avatar as plain arrays: the decoded content of a file, and the input of the writer. No behaviour.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "sdk/math/projection.h"
#include "sdk/math/types.h"

namespace dpl {

/** A joint of the rig. All joint frames are parallel to the world at rest, so the rest pose consists of positions alone. Joint j rotates
 *  about restPosition relative to its parent:  G_j = G_parent · [R_j | p_j − R_j p_j],  v' = Σ_j w_j G_j v. */
struct JointData {
    std::string name;
    int32_t parent = -1;       // index; parents come first; -1: root
    Vec3f restPosition{0};     // metres, avatar space (world at rest)
    std::string humanoidBone;  // VRM humanoid name ("hips", "leftUpperArm" ...) or empty
};

/** A contiguous range of vertices and triangles with one role. Layers share no vertices. */
struct LayerData {
    std::string name;  // "body", "top", ...
    std::string role;  // "body" | "garment" | "hair"
    uint32_t firstVertex = 0, vertexCount = 0;
    uint32_t firstTriangle = 0, triangleCount = 0;
};

struct MeshData {
    std::vector<Vec3f> restPositions;        // V, metres, rest pose, fitted vertex offsets included
    std::vector<glm::u8vec4> colours;        // V, sRGB, alpha 255; for viewers that draw no splats
    std::vector<glm::u16vec4> jointIndices;  // V
    std::vector<glm::u8vec4> jointWeights;   // V, unorm8, each sums to 255
    std::vector<Triangle> triangles;         // F, indices into the whole vertex array
    std::vector<LayerData> layers;
};

constexpr uint8_t kSplatSingleFace = 1;  // visible only from the outside (docs/reference/gate.md)
constexpr uint8_t kSplatCloth = 2;       // set: cloth; else body

/** N flat splats, sorted by triangle and within a triangle by Morton code. The order stores the parent triangles, so they need no array. */
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

/** Motion modes that are limited together, such as those of the legs. */
struct MotionGroupData {
    uint32_t columnCount = 0;  // K'_g
    float reach = 1e6f;        // limit of the length of its coefficients, taken from far training poses
};

/** Motion modes: further columns of the pose correctives, driven by whether and how far the subject has moved away from the pose in which
 * it stood still (docs/reference/correctives.md). Cloth that has moved does not fall back, so these are held with a leak. No groups: none.
 *
 *      angle_j = angle between joint j's local rotation and still_j;   D = sqrt(Σ_j angle_j²)
 *      u       = [smoothstep(movedFrom, movedTo, D), min(max(angle_j − rest_j, 0), most_j) …]        1 + J inputs, 0 in the still pose
 *      h       = max(h · exp(−dt / hold), u) for each hold; h = u for hold 0, and wherever no time is known
 *      k'      = modes · h;   the coefficients of a group are shortened together to its reach */
struct MotionModeData {
    std::vector<MotionGroupData> groups;  // their columns follow one another
    std::vector<uint32_t> joints;         // J: rising indices of the joints that count
    std::vector<Vec4f> still;             // J: unit quaternion xyzw, local rotation in the still pose
    std::vector<Vec2f> rangeRad;          // J: rest (no input within this angle of still) and most (largest input)
    float movedFromRad = 0, movedToRad = 1;
    std::vector<float> holdsS;  // time constants of the leaks, seconds; 0: settles at once
    std::vector<float> lagsS;   // time constants of the lags, seconds; may be empty
    std::vector<float> modes;   // K' × featureCount(): of each hold 1 + J inputs, then of each lag 6·J numbers

    bool empty() const { return groups.empty(); }
    size_t inputCount() const { return 1 + joints.size(); }  // of a hold
    size_t turnCount() const { return 6 * joints.size(); }   // numbers of a lag
    size_t heldCount() const { return holdsS.size() * inputCount(); }
    size_t lagCount() const { return lagsS.size() * turnCount(); }
    size_t featureCount() const { return heldCount() + lagCount(); }
    uint32_t columnCount() const {  // K'
        uint32_t count = 0;
        for (const MotionGroupData& group : groups) count += group.columnCount;
        return count;
    }
};

/** Pose correctives: how the surface and its brightness follow the pose (docs/reference/correctives.md). M control nodes carry an offset
 *  and a brightness that are linear in K coefficients of the pose. Each vertex takes them from four nodes by weights. nodeCount 0: none.
 *  modeCount 0 with nodes: the pose moves nothing, and the nodes serve the expressions alone (ExpressionData).
 *
 *      d = feature(pose) − mean;   k = modes · d;   off² = ‖d‖² − Σ_i k_i² / ‖mode_i‖²
 *      k ← k · min(1, reach / ‖k‖) · min(1, reachOffModes / off);   node = Σ_i k_i · nodes[n][i];   (ΔV, L − 1)_v = Σ weight · node
 *
 *  The feature holds 6 numbers per joint of `joints`: the first two columns of its local rotation minus those of the identity. Modes are
 *  orthogonal, so `off` is the distance of the pose from their span. The correctives fade in poses that training did not see. With motion
 *  modes, k has K' further entries, and each node as many further values behind its K. */
struct PoseCorrectiveData {
    uint32_t modeCount = 0, nodeCount = 0;  // K, M
    std::vector<uint32_t> joints;           // J: rising indices of the joints that the feature reads
    std::vector<float> mean;                // 6·J
    std::vector<float> modes;               // K × 6·J
    float reach = 0;                        // limit of ‖k‖, taken from far training poses
    float reachOffModes = 1e6f;             // limit of `off`, taken from far training poses; 1e6: never fades
    std::vector<glm::u16vec4> nodeIndices;  // V
    std::vector<glm::u8vec4> nodeWeights;   // V, unorm8, each sums to 255
    MotionModeData motion;                  // K' further columns
    std::vector<Vec4f> nodes;               // M × (K + K'): offset in metres (rest pose), change of brightness

    bool empty() const { return nodeCount == 0; }
    bool followsPose() const { return modeCount > 0; }
    uint32_t columnCount() const { return modeCount + motion.columnCount(); }  // values of a node
};

/** Expressions: offsets that control nodes of the head add for weights that a program sets, such as 0.5 of a smile
 *  (docs/reference/expressions.md). The nodes and their vertices are those of the pose correctives. No shapes: none.
 *
 *      node_n += Σ_s weight_s · offset_sn        after the modes of the pose, whose reach and fade know nothing of it */
struct ExpressionData {
    std::vector<uint8_t> shapes;  // S: rising indices of kExpressionNames (expression_names.h)
    std::vector<uint32_t> ends;   // S: where the entries of a shape end; those of the next one follow
    std::vector<uint16_t> nodes;  // entries: control nodes, rising within a shape
    std::vector<Vec3f> offsetsM;  // entries: metres at weight 1, at rest
    // The face's own nodes: firstNode and all behind it. The vertices on them, in rising order, and where the pose alone has each of these
    // (face_nodes.h). firstNode 0: the shapes move nodes of the pose correctives, as in files of encoding 1.
    uint32_t firstNode = 0;
    std::vector<uint32_t> vertices;
    std::vector<glm::u16vec4> poseIndices;
    std::vector<glm::u8vec4> poseWeights;

    bool empty() const { return shapes.empty(); }
    uint32_t begin(size_t shape) const { return shape == 0 ? 0 : ends[shape - 1]; }
};

constexpr size_t kIrradianceCoefficients = 8;

/** Light that stays in the world while the subject turns (docs/reference/light.md): how the irradiance of the scan differs from its mean.
 *
 *      E(n) = clamp(1 + Σ_i irradiance_i Y_i(n), kMinIrradiance, kMaxIrradiance)       L_v = E(posed normal) / E(normal at rest) */
struct LightData {
    std::array<float, kIrradianceCoefficients> irradiance{};  // coefficients 1 to 8 in the order and signs of sdk/math/sh.h

    bool empty() const { return irradiance == std::array<float, kIrradianceCoefficients>{}; }
};

/** One table row of the evidence: an optional part of the avatar, whether it was kept, and why. */
struct EvidenceData {
    std::string part;  // "sh degree 2", "pose-dependent offsets" ...
    bool kept = false;
    float gainDb = 0;    // masked PSNR of validation frames (training frames without a split), with the part less without; 0: not measured
    uint64_t bytes = 0;  // in the file
    std::string reason;
};

constexpr size_t kCaptureSides = 4;  // at rest: front (+Z), left (+X), back (−Z), right (−X)

/** How the scan's still pictures show one side of the surface that a joint moves. Medians by area. */
struct CaptureSide {
    float pixelM = 0;    // size of a pixel on the surface, metres; 0: not seen
    float detailM = 0;   // size of the finest detail that the pictures show: at least pixelM, larger where they are blurred; 0: not seen
    uint32_t views = 0;  // pictures that look at it at less than 60° to its normal
};

/** The capture map (docs/reference/body-map.md). It changes no picture; programs may keep cameras from coming nearer than it lets them. */
struct CaptureMapData {
    std::vector<CaptureSide> sides;  // 4 a joint, joint by joint; empty: no map

    bool empty() const { return sides.empty(); }
};

struct ClipChannel {
    uint32_t joint = 0;
    std::vector<Quatf> rotations;  // one per time of the clip
};

/** A clip on the avatar's own rig: local rotations as in JointData, and the translation of the root. */
struct ClipData {
    std::string name;
    std::vector<float> timesS;            // strictly rising
    std::vector<ClipChannel> channels;    // joints without a channel stay at rest
    std::vector<Vec3f> rootTranslations;  // one per time, metres; empty: none
};

struct AvatarData {
    std::string name;
    std::string generator;
    std::vector<JointData> joints;
    MeshData mesh;
    SplatData splats;
    PoseCorrectiveData correctives;
    ExpressionData expressions;
    LightData light;
    std::vector<ClipData> clips;
    std::vector<EvidenceData> evidence;
    float kappaPx2 = float(kKappaPx2);
    bool compensated = true;  // energy-preserving low-pass (docs/reference/footprint.md)
    CaptureMapData captureMap;
    float trainedPixelM = 0;  // size of a training pixel at the subject, metres (docs/reference/coverage.md); 0: not known
};

/** General splats, as in INRIA PLY and SPZ files. Bound to no mesh; three axes each. */
struct StaticSplatData {
    std::vector<Vec3f> position;  // metres
    std::vector<Quatf> rotation;  // unit
    std::vector<Vec3f> scaleM;    // standard deviations, linear
    std::vector<float> opacity;   // [0,1]
    uint32_t shDegree = 0;
    std::vector<float> sh;              // N × (degree+1)² × 3, coefficient-major
    float kappaPx2 = float(kKappaPx2);  // variance of the low-pass used in training, px²
    bool compensated = false;           // the low-pass in training preserved energy ("antialiased")
    uint32_t count() const { return uint32_t(position.size()); }
};

}  // namespace dpl
