// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/capture/validation.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/input/capture/priors.h"
#include "sdk/core/result.h"

namespace dpl {
namespace {

constexpr size_t kOthersOfASide = 2;  // training frames of its kind that must still see the side of a still frame that is set aside

/** Places among `count` frames in a row: half of them side by side near the middle, the others alone, evenly spread. */
std::vector<size_t> places(size_t count, double share) {
    if (double(count) < priors::kMinFramesForValidation) return {};
    const size_t chosen = std::max<size_t>(1, size_t(std::lround(share * double(count))));
    const size_t block = chosen >= 3 ? (chosen + 1) / 2 : 0;
    const size_t parts = chosen - block + (block > 0 ? 1 : 0);
    std::vector<size_t> out;
    for (size_t i = 0; i < parts; ++i) {
        const size_t centre = (2 * i + 1) * count / (2 * parts);
        const bool row = block > 0 && i == parts / 2;
        for (size_t k = 0; k < (row ? block : 1); ++k) out.push_back(row ? centre - block / 2 + k : centre);
    }
    return out;
}

/** Direction in which the camera looks, in the scan's world. */
Vec3d lookDirection(const Camerad& camera) {
    return glm::transpose(camera.viewFromWorldRotation) * Vec3d(0, 0, 1);
}

bool othersSeeItsSide(const Scan& scan, const std::vector<size_t>& stills, size_t f) {
    const double near = std::cos(glm::radians(priors::kSameSideDeg));
    size_t others = 0;
    for (size_t g : stills)
        others += g != f && scan.frames[g].split == Split::Train &&
                  glm::dot(lookDirection(scan.frames[f].camera), lookDirection(scan.frames[g].camera)) > near;
    return others >= kOthersOfASide;
}

}  // namespace

std::string setValidationAside(Scan& scan, const std::vector<bool>& usable) {
    const auto training = [&](FrameKind kind) {
        std::vector<size_t> frames;
        for (size_t f = 0; f < scan.frames.size(); ++f)
            if (scan.frames[f].kind == kind && scan.frames[f].split == Split::Train && usable[f]) frames.push_back(f);
        return frames;
    };
    std::vector<size_t> moving = training(FrameKind::Dynamic);
    const std::vector<size_t> stills = training(FrameKind::StaticFull), closeups = training(FrameKind::StaticCloseup);
    std::stable_sort(moving.begin(), moving.end(), [&](size_t a, size_t b) { return scan.frames[a].timeS < scan.frames[b].timeS; });
    size_t movingCount = 0;
    for (size_t place : places(moving.size(), priors::kValidationMovingShare))
        scan.frames[moving[place]].split = Split::Validation, ++movingCount;
    const auto setStillsAside = [&](const std::vector<size_t>& frames, double share) {
        size_t count = 0;
        for (size_t place : places(frames.size(), share))
            if (othersSeeItsSide(scan, frames, frames[place])) scan.frames[frames[place]].split = Split::Validation, ++count;
        return count;
    };
    const size_t stillCount = setStillsAside(stills, priors::kValidationStillShare),
                 closeupCount = setStillsAside(closeups, priors::kValidationCloseupShare);
    if (movingCount + stillCount + closeupCount == 0)
        return formatText(
            "validation: none, because {} moving, {} still and {} close-up training frames are too few; parts are judged on training "
            "frames",
            moving.size(), stills.size(), closeups.size());
    return formatText(
        "validation: {} of {} moving, {} of {} still and {} of {} close-up training frames are set aside; they train nothing, and parts "
        "are judged on them",
        movingCount, moving.size(), stillCount, stills.size(), closeupCount, closeups.size());
}

}  // namespace dpl
