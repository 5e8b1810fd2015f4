// SPDX-License-Identifier: Apache-2.0
// Learned offsets kept from tearing garments, in any pose, by their control nodes. Formulas: docs/reference/correctives.md, "Strain".
//
//   load:   garment edges ─► by how much two nodes may differ, so that no edge that goes from one to the other is strained beyond a limit
//   frame:  share of the pose correctives that is drawn ─► the limit: none for poses of the film
//           nodes ─► those that differ by more come nearer to each other ─► nodes
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/format/avatar_data.h"

namespace dpl {

// In poses of which this share of the pose correctives is drawn, or more, offsets are as they were learned.
constexpr float kFilmedShare = 0.3f;
// Difference of the offsets of an edge's ends, over its length at rest, in poses unlike all of the film.
constexpr float kMostStrain = 0.6f;

/** What ease() needs of an avatar. Immutable once made; any thread. */
class ClothStrain {
public:
    ClothStrain() = default;
    /** Empty, and ease() does nothing, where no node of a garment has learned an offset. The avatar must have passed the checks of its
     *  reader. */
    ClothStrain(const MeshData& mesh, const PoseCorrectiveData& correctives);

    bool empty() const { return pairs_.empty(); }
    uint64_t bytes() const { return pairs_.size() * sizeof(Pair) + nodes_.size() * sizeof(uint16_t); }

    /** nodes: M, of correctiveNodes; those that nothing eases keep their bytes. drawn: as of correctiveCoefficients. eased is scratch and
     *  keeps its memory. Returns the largest change of a node, metres. On the calling thread. */
    float ease(std::span<Vec4f> nodes, float drawn, std::vector<Vec3f>& eased) const;

private:
    struct Pair {
        uint16_t a, b;  // of nodes_
        float mostApartM;
    };
    std::vector<uint16_t> nodes_;  // of the correctives
    std::vector<Pair> pairs_;      // rising
};

}  // namespace dpl
