// SPDX-License-Identifier: Apache-2.0
// Test-time pose fits of many frames on one avatar (docs/reference/registration.md). What the frames share is made once.
#pragma once

#include <optional>

#include "reconstruction/training/trainer/polish.h"

namespace dpl {

class PoseFitter {
public:
    /** Keeps a reference to `avatar`. */
    PoseFitter(const AvatarData& avatar, Jobs& jobs);

    /** fitPose() of a frame. Const, so several threads may fit, each with jobs of its own. */
    Result<PoseFitResult> fit(const TrainFrame& frame, const PoseFitSettings& settings, Jobs& jobs) const;

    /** fit() of every frame, in their order, a frame a thread: same results for any number of threads. nullopt: the frame's picture cannot
     * be used. Error: Cancelled. */
    Result<std::vector<std::optional<PoseFitResult>>> fitAll(std::span<const TrainFrame> frames, const PoseFitSettings& settings,
                                                             Jobs& jobs) const;

private:
    const AvatarData& avatar_;
    TrainableSplats splats_;
    std::vector<RestTriangle<float>> bind_;
    VertexIncidence incidence_;
    std::vector<Vec3f> normals_;  // empty without light
};

}  // namespace dpl
