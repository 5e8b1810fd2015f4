// SPDX-License-Identifier: Apache-2.0
// What keeps the learned offsets of garments sound in any pose: out of the body, then from tearing.
#pragma once

#include "sdk/avatar/cloth_clearance.h"
#include "sdk/avatar/cloth_strain.h"

namespace dpl {

/** Room for ClothLimits::apply(). It keeps its memory. */
struct ClothScratch {
    std::vector<Vec3f> pushes, eased;
};

/** What apply() needs of an avatar. Immutable once made; any thread. */
class ClothLimits {
public:
    ClothLimits() = default;
    /** The avatar must have passed the checks of its reader and checkRig. */
    ClothLimits(std::span<const JointData> joints, const MeshData& mesh, const PoseCorrectiveData& correctives)
        : clearance_(joints, mesh, correctives), strain_(mesh, correctives) {}

    uint64_t bytes() const { return clearance_.bytes() + strain_.bytes(); }

    /** nodes: M, of correctiveNodes. drawn: as of correctiveCoefficients. worldFromRest: jointTransforms of the pose. Returns by how much a
     * node changes at most, metres. On the calling thread. */
    float apply(std::span<const Mat3x4f> worldFromRest, float drawn, std::span<Vec4f> nodes, ClothScratch& scratch) const {
        const float pushedM = clearance_.push(worldFromRest, nodes, scratch.pushes);
        return pushedM + strain_.ease(nodes, drawn, scratch.eased);
    }

private:
    ClothClearance clearance_;
    ClothStrain strain_;
};

}  // namespace dpl
