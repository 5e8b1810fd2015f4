// SPDX-License-Identifier: Apache-2.0
// Finds the cameras of pictures that bring none (docs/reference/cameras.md):
//
//   stills, close-ups ── COLMAP, person masked out ──► cameras of stills, focal length, k1
//   points of the background, triangulated from the stills ──► cameras of moving and held-out pictures
//   close-ups that COLMAP could not place ── the same with the person, who stands still ──► cameras
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "reconstruction/input/cameras/camera_check.h"

namespace dpl {

enum class SolveRole : uint8_t {
    Still,    // shows the whole subject, who stands still. In the order of the walk
    Closeup,  // near, the subject stands still
    Moving,   // the subject moves. In the order of time
    HeldOut,  // placed last; changes no other camera
};

struct SolvePicture {
    std::string name;             // safe as a file name, unique
    std::filesystem::path image;  // JPEG or PNG, upright, not distorted by an editor
    SolveRole role = SolveRole::Still;
};

/** Decoded pixels of a picture, as stored. */
struct SolvePixels {
    std::vector<uint8_t> grey;    // row by row
    std::vector<uint8_t> person;  // the same size, ≥ 128: person; empty: not known
};

struct SolveSettings {
    std::filesystem::path folder;  // exists; for COLMAP's files and log
    uint32_t widthPx = 0, heightPx = 0;
    double focalGuessPx = 0;                          // of EXIF, say; 0: that of a phone's main camera
    std::function<Result<SolvePixels>(size_t)> load;  // pixels of a picture; called on the calling thread
};

/** What became of one picture. */
struct SolveOutcome {
    std::optional<Camerad> camera;  // in a world of any scale, origin and up; empty: not placed
    size_t features = 0;            // found on the background
    size_t matches = 0;             // that agree with the camera; 0 without one
    double sharpness = 0;           // variance of the Laplacian of the whole picture, grey levels²
    double missPx = 0;              // median, over the matches
    bool unmasked = false;          // placed with the help of the person
};

struct SolvedCameras {
    std::vector<SolveOutcome> pictures;  // in the order given
    LensDistortion lens;                 // of all pictures; only k1
    std::vector<Vec3d> points;           // of the background
    double missPx = 0;                   // median miss of the stills' matches
};

/** Errors: NotFound without COLMAP; Cancelled within a second; InvalidArgument without a still. Pictures that cannot be placed are no
 * error: see camera_verdict.h. COLMAP uses two threads; its results can differ in their last digits from run to run. */
Result<SolvedCameras> solveCameras(std::span<const SolvePicture> pictures, const SolveSettings& settings);

}  // namespace dpl
