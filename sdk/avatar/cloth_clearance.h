// SPDX-License-Identifier: Apache-2.0
// Garments kept out of the body in any pose, by their control nodes. Formulas: docs/reference/correctives.md, "Clearance".
//
//   load:   body layer ─► tubes;   garment vertices ─► place, joints, neighbours and clearance at rest of each node
//   frame:  node sums ─► pushed out of the tubes ─► neighbours even what they are pushed ─► node sums
#pragma once

#include <span>
#include <vector>

#include "sdk/avatar/body_tube.h"

namespace dpl {

/** What push() needs of an avatar. Immutable once made; any thread. */
class ClothClearance {
public:
    ClothClearance() = default;
    /** Empty, and push() does nothing, without motion modes: what moves clothes far enough to need it. So it is without a body layer or
     *  humanoid bones. The avatar must have passed the checks of its reader and checkRig. */
    ClothClearance(std::span<const JointData> joints, const MeshData& mesh, const PoseCorrectiveData& correctives);

    bool empty() const { return nodes_.empty(); }
    uint64_t bytes() const;

    /** Moves what sinks into a tube 1 cm deeper than it lies at rest, or than 5 mm above it, out again. nodes: M, of correctiveNodes; those
     * that are not pushed keep their bytes. worldFromRest: jointTransforms of the pose. scratch keeps its memory. Returns the largest
     * change of a node, metres. Takes about 0.05 ms, on the calling thread. */
    float push(std::span<const Mat3x4f> worldFromRest, std::span<Vec4f> nodes, std::vector<Vec3f>& scratch) const;

private:
    struct Near {
        uint32_t tube;
        float leastM;  // distance from the tube that is kept; negative: inside of it
    };
    struct Node {
        uint32_t index = 0;  // of the correctives
        uint32_t firstNear = 0, lastNear = 0;
        Vec3f rest{0};
        glm::u16vec4 joints{0};
        Vec4f weights{0};
        float mostM = 0;  // limit of its offset
    };
    struct Pair {
        uint32_t a, b;  // of nodes_
        float mostApartM;
    };
    std::vector<BodyTube> tubes_;
    std::vector<Near> near_;
    std::vector<Node> nodes_;
    std::vector<Pair> pairs_;

    void addLayer(const MeshData& mesh, const LayerData& layer, const PoseCorrectiveData& correctives, std::span<const JointData> joints);
    void addPairs(const MeshData& mesh, const LayerData& layer, const PoseCorrectiveData& correctives, size_t firstNode);
    Mat3x4f carryOf(const Node& node, std::span<const Mat3x4f> worldFromRest) const;
};

}  // namespace dpl
