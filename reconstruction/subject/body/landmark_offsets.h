// SPDX-License-Identifier: Apache-2.0
// Where a detector sees a body's keypoints. A detector marks "pelvis" or "ear" by its own convention, centimetres from the rig's point of
// that name. Still frames show each point from all sides, so the difference is known to a few millimetres.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/subject/body/keypoint_chain.h"

namespace dpl {

/** One still frame with its solved pose. */
struct LandmarkView {
    Camerad camera;      // metric
    double sigmaPx = 1;  // standard deviation of a keypoint's coordinate at full confidence
    std::span<const Keypoint> keypoints;
    KeypointChain::Output posed;
};

/** Where our networks mark a keypoint, relative to the body's own: metres in the rest frame, left is +x, up +y, front +z. Zero for a name
 *  that the table lacks. */
Vec3d foundLandmarkOffset(std::string_view keypoint);

/** One offset per keypoint of `chain`, metres in the rest frame of its carrier, to be added to the offset that the chain has. Each
 *  minimises Σ ρ((π(X + W·o) − x)/σ) + |o|²/priors::kLandmarkOffsetM² over the views, with ρ of Geman–McClure at `outlierSigmas`. Zero for
 *  a keypoint that fewer than three views show. */
std::vector<Vec3d> estimateLandmarkOffsets(const KeypointChain& chain, std::span<const LandmarkView> views, double outlierSigmas);

}  // namespace dpl
