// SPDX-License-Identifier: Apache-2.0
// Everything that follows from pose and views for each subject of a frame. Computed once for each draw, then only read.
//
//   placement, views ─► the views in the space of the subject
//   pose, joints ─► joint transforms ─► level of detail (of all subjects together) ─► components out of view
//   pose ─► coefficients of the pose correctives ─► control nodes, expressions added ─► limits of cloth
#pragma once

#include <array>
#include <span>
#include <vector>

#include "sdk/render/avatar_store.h"

namespace dpl {

/** One subject in one draw call. General splats have no pose: their vectors are empty. */
struct DrawnSubject {
    std::vector<Mat3x4f> worldFromRest;  // of each joint
    std::vector<float> coefficients;     // of the pose correctives, then of the expressions; empty without control nodes
    std::vector<Vec4f> nodes;            // their control nodes, within the limits of cloth
    ClothScratch cloth;
    float pushedM = 0;            // by how much at most
    SplatDetail detail;           // of an avatar
    GeneralDetail generalDetail;  // of general splats
    float drawnShare = 1;         // upper bound of the share of its splats that this level of detail draws
    float largestGrowth = 1;      // upper bound of the factor by which it enlarges splats
    SubjectViews views;           // of the draw
    std::array<uint32_t, gpu::kMaxViews>
        unseen{};  // for each frame of the draw: bits of the components that its views cannot show, and of hidden layers
};

/** The parts of `out` that depend on the pose of an avatar alone: worldFromRest, coefficients, nodes, pushedM. Keeps its memory. */
void poseAvatar(const LoadedSubject& subject, const Pose& pose, DrawnSubject& out);

/** Distributes the views of a draw call over frames: all views in one frame, or one frame for each view. */
struct FrameViews {
    std::span<const Cameraf> all;
    bool shared = true;
    size_t frameCount() const { return shared ? 1 : all.size(); }
    std::span<const Cameraf> of(size_t frame) const { return shared ? all : all.subspan(frame, 1); }
};

/** All subjects of one draw call. */
struct PosedSet {
    std::span<const DrawnSubject> subjects;  // in the order they were given in; valid until the next pose
    DetailTotals splats;                     // of all subjects
};

/** Poses the subjects of one draw call after the other in memory of its own, so that a warm frame allocates nothing. One thread at a time.
 */
class SubjectPoser {
public:
    /** subjects[k] belongs to what[k], views to the world. Level of detail is chosen for all views at once, so that both eyes see the same
     * splats. cullComponents: otherwise only components of hidden layers count as unseen. */
    PosedSet pose(std::span<const Drawn> what, std::span<LoadedSubject* const> subjects, const FrameViews& views,
                  const DetailOptions& detail, bool cullComponents);

private:
    std::array<DrawnSubject, kMaxDrawnTogether> posed_;
};

}  // namespace dpl
