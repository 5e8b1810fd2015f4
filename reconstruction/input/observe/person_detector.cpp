// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/observe/person_detector.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "reconstruction/base/models_folder.h"
#include "reconstruction/input/observe/pose_crop.h"

namespace dpl {
namespace {

// MediaPipe's pose_detection graph: input of 224 px in −1 … 1; anchors of one size at the centres of the cells of three grids; an output
// row is a logit, a box (centre, size) and four points as offsets from the anchor, in pixels of the input. Points 0 and 1 are the middle
// of the hips and a point on the circle round the person.
constexpr int kSide = 224;
constexpr AnchorGrids kGrids{{{8, 2}, {16, 2}, {32, 6}}};
constexpr size_t kAnchors = 2254, kRow = 13, kPoints = 5;
constexpr double kLeastScore = 0.3;
constexpr double kRoom = 1.25;        // MediaPipe's: side of the crop / diameter of the circle
constexpr double kSamePerson = 0.35;  // two hips closer than this share of the smaller crop are one person's

/** Upright squares of `side` that cover the picture and overlap by at least half. */
std::vector<PersonCrop> tiles(double width, double height, double side) {
    const auto starts = [&](double length) {
        const int count = length <= side ? 1 : int(std::ceil((length - side) / (0.5 * side))) + 1;
        std::vector<double> centres;
        for (int i = 0; i < count; ++i) centres.push_back(count == 1 ? 0.5 * length : 0.5 * side + (length - side) * i / (count - 1));
        return centres;
    };
    std::vector<PersonCrop> out;
    for (const double y : starts(height))
        for (const double x : starts(width)) out.push_back({{x, y}, side, 0});
    return out;
}

Status detectIn(OnnxNet& detector, const ImageRgb8& image, const PersonCrop& tile, std::vector<DetectedPerson>& found) {
    DPL_TRY(const auto outputs, detector.run(cropToTensor(image, tile, kSide, {0.5f, 0.5f, 0.5f}, {0.5f, 0.5f, 0.5f}), kSide));
    if (outputs.size() != 1 || outputs[0].data.size() != kAnchors * kRow)
        return fail(Code::Unsupported, "the detector has other outputs than BlazePose's; use {} of tools/models", network_files::kDetector);
    static const std::vector<Vec2d> centres = anchorCentres(kSide, kGrids);
    for (size_t a = 0; a < kAnchors; ++a) {
        const float* row = outputs[0].data.data() + a * kRow;
        const double score = 1 / (1 + std::exp(-double(row[0])));
        if (!(score >= kLeastScore)) continue;
        const auto point = [&](size_t k) {
            return cropToPicture(tile, centres[a] + Vec2d(row[kPoints + 2 * k], row[kPoints + 2 * k + 1]), kSide);
        };
        const Vec2d hips = point(0), up = point(1) - hips;
        const double radius = glm::length(up);
        if (radius > 4 && std::isfinite(radius)) found.push_back({{hips, 2 * kRoom * radius, std::atan2(up.x, -up.y)}, score});
    }
    return {};
}

std::vector<DetectedPerson> bestOfEach(std::vector<DetectedPerson> found, size_t most) {
    std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
    std::vector<DetectedPerson> kept;
    for (const DetectedPerson& one : found) {
        const bool known = std::any_of(kept.begin(), kept.end(), [&](const DetectedPerson& other) {
            return glm::length(one.crop.centrePx - other.crop.centrePx) < kSamePerson * std::min(one.crop.sidePx, other.crop.sidePx) / 2;
        });
        if (!known) kept.push_back(one);
        if (kept.size() == most) break;
    }
    return kept;
}

}  // namespace

Result<std::vector<DetectedPerson>> detectPeople(OnnxNet& detector, const ImageRgb8& image, size_t most) {
    const double width = image.widthPx, height = image.heightPx, longer = std::max(width, height), shorter = std::min(width, height);
    std::vector<DetectedPerson> found;
    for (const PersonCrop& tile : tiles(width, height, longer)) DPL_RETURN_IF_ERROR(detectIn(detector, image, tile, found));
    if (longer > 1.1 * shorter)
        for (const PersonCrop& tile : tiles(width, height, shorter)) DPL_RETURN_IF_ERROR(detectIn(detector, image, tile, found));
    if (found.empty() && shorter > 2 * kSide)
        for (const PersonCrop& tile : tiles(width, height, 0.5 * shorter)) DPL_RETURN_IF_ERROR(detectIn(detector, image, tile, found));
    return bestOfEach(std::move(found), most);
}

}  // namespace dpl
