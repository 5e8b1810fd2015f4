// SPDX-License-Identifier: Apache-2.0
// Says which pictures got a camera and, where some did not, what to film again.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "reconstruction/input/cameras/solve_cameras.h"

namespace dpl {

/** Something to film again. */
struct CameraGap {
    std::string part;                 // "the left side", "the close-ups", "the background"; "that part" where no side is known
    std::string sentence;             // what is wrong, and how to film it again
    std::vector<std::string> frames;  // names of the pictures without a camera; empty: the whole walk
};

struct CameraVerdict {
    bool refuses = false;                // too few stills have cameras for an avatar
    std::vector<std::string> sentences;  // the first says how many pictures have cameras, the others are those of the gaps
    std::vector<CameraGap> gaps;
};

constexpr size_t kFewestPlacedStills = 8;

/** `front`: the direction that the subject faces and `up`, in the world of the cameras, to name sides; zero when unknown. */
CameraVerdict judgeCameras(std::span<const SolvePicture> pictures, const SolvedCameras& solved, const Vec3d& up, const Vec3d& front);

}  // namespace dpl
