// SPDX-License-Identifier: Apache-2.0
// Test-time pose fits of many frames on one avatar (docs/reference/registration.md). What the frames share is made once.
#pragma once

#include <optional>

#include "reconstruction/training/trainer/polish.h"

namespace dpl {

class PoseFitter {
public:
    static constexpr double kSecondFit = 0.25;  // share of the rounds that a fit from a fitted pose runs, the last ones

    /** Keeps a reference to `avatar`. */
    PoseFitter(const AvatarData& avatar, Jobs& jobs);

    /** fitPose() of a frame. from: the pose that fits an avatar much like this one, where it is known; then only the last rounds run, those
     * of the smallest steps. Const, so several threads may fit, each with jobs of its own. */
    Result<PoseFitResult> fit(const TrainFrame& frame, const PoseFitSettings& settings, Jobs& jobs, const Pose* from = nullptr) const;

    /** fit() of every frame, in their order, a frame a thread: same results for any number of threads. from: empty, or as fitAll() returned
     * it for these frames and an avatar much like this one. nullopt: the frame's picture cannot be used. Error: Cancelled. */
    Result<std::vector<std::optional<PoseFitResult>>> fitAll(std::span<const TrainFrame> frames, const PoseFitSettings& settings,
                                                             Jobs& jobs, std::span<const std::optional<PoseFitResult>> from = {}) const;

private:
    const AvatarData& avatar_;
    TrainableSplats splats_;
    std::vector<RestTriangle<float>> bind_;
    VertexIncidence incidence_;
    std::vector<Vec3f> normals_;  // empty without light
};

}  // namespace dpl
