// SPDX-License-Identifier: Apache-2.0
// What a viewer would dislike in a moving avatar and no single picture shows: flicker, and clothes inside the body.
#pragma once

#include <span>

#include "reconstruction/judging/report/draw_view.h"
#include "reconstruction/training/trainer/frame_pass.h"
#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

struct MotionFaults {
    double flickerLevels = 0;  // mean over slow sweeps (report/flicker.h); 0 with fewer than two moving frames
    double penetration = 0;    // share of garment vertices inside the body (garments/cloth_faults.h), mean over the moving frames' poses

    friend bool operator==(const MotionFaults&, const MotionFaults&) = default;
};

/** Part of the way from `from` to `to`: as far as turns no joint by more than 0.02 rad and moves the root by no more than 1 cm. */
Pose slowStep(const Pose& from, const Pose& to);

/** Measures an avatar in the poses of the moving ones of `frames`. Each of them but the last makes a slow step towards the next one before
 *  its own camera. `view` draws the same avatar. Errors: those of AvatarView::draw. */
Result<MotionFaults> motionFaults(const AvatarData& avatar, AvatarView& view, std::span<const TrainFrame> frames, Jobs& jobs);

}  // namespace dpl
