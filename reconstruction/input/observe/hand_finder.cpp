// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/observe/hand_finder.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/base/models_folder.h"
#include "reconstruction/input/observe/pose_crop.h"
#include "reconstruction/input/observe/priors.h"

namespace dpl {
namespace {

constexpr int kMarksSide = 224;
// MediaPipe's palm detection: input of 256 px in 0 … 1; anchors of one size at the centres of the cells of three grids; an output row is a
// logit, a box (centre, size) and seven points as offsets from the anchor, in pixels of the input. Point 0 is the wrist, point 2 the base
// of the middle finger. The crop is the box, 2.6 times as large and moved half its side towards the fingers.
constexpr int kPalmSide = 256;
constexpr AnchorGrids kPalmGrids{{{8, 2}, {16, 2}, {32, 6}}};
constexpr size_t kPalmAnchors = 2944, kPalmRow = 19, kPalmPoints = 5;
constexpr double kPalmScore = 0.5, kPalmRoom = 2.6, kPalmTowardsFingers = 0.5;
constexpr size_t kMostPalms = 4;

ArmMarks armOf(std::span<const Vec2d> p, size_t side) {
    return {p[13 + side], p[15 + side], p[19 + side], p[17 + side]};
}

void put(const SeenHand& hand, size_t side, std::vector<Keypoint>& out) {
    out.resize(2 * kHandPoints);
    const double length = lengthPx(hand.marks);
    for (size_t k = 0; k < kHandPoints; ++k) {
        const double doubt = hand.spreadPx[k + 1] / (priors::kHandSpread * length);
        out[side * kHandPoints + k] = {hand.marks[k + 1], hand.score / (1 + doubt * doubt)};
    }
}

}  // namespace

Result<std::optional<HandFinder>> HandFinder::loadIfThere(const std::filesystem::path& models) {
    std::error_code ignored;
    if (!std::filesystem::exists(models / network_files::kHands, ignored)) return std::optional<HandFinder>();
    DPL_TRY(OnnxNet marks, OnnxNet::load(models / network_files::kHands));
    std::optional<OnnxNet> palms;
    if (std::filesystem::exists(models / network_files::kPalms, ignored)) {
        DPL_TRY(palms, OnnxNet::load(models / network_files::kPalms));
    }
    return std::optional(HandFinder(std::move(marks), std::move(palms)));
}

Result<SeenHand> HandFinder::lookOnce(const ImageRgb8& image, const PersonCrop& crop, bool mirrored) {
    std::vector<float> input = cropToTensor(image, crop, kMarksSide, {0, 0, 0}, {1, 1, 1});
    if (mirrored) mirrorRows(input, kMarksSide);
    DPL_TRY(const auto outputs, marks_.run(input, kMarksSide));
    // Marks in pixels of the crop, flag, handedness, marks in metres.
    if (outputs.size() != 4 || outputs[0].data.size() != 3 * kHandMarks || outputs[1].data.size() != 1 || outputs[2].data.size() != 1)
        return fail(Code::Unsupported, "{} has other outputs than MediaPipe's network of hands; run tools/models again",
                    network_files::kHands);
    SeenHand seen;
    seen.score = std::clamp(double(outputs[1].data[0]), 0.0, 1.0);
    const double says = std::clamp(double(outputs[2].data[0]), 0.0, 1.0);
    seen.leftness = mirrored ? says : 1 - says;
    for (size_t k = 0; k < kHandMarks; ++k) {
        const float* v = outputs[0].data.data() + 3 * k;
        seen.marks[k] = cropToPicture(crop, {mirrored ? kMarksSide - v[0] : v[0], v[1]}, kMarksSide);
    }
    return seen;
}

Result<std::optional<SeenHand>> HandFinder::look(const ImageRgb8& image, const PersonCrop& start) {
    DPL_TRY(SeenHand first, lookOnce(image, start, false));
    if (first.score < priors::kHandConfirmed) return std::optional<SeenHand>();
    const auto crop = cropOfHand(first.marks);
    if (!crop) return std::optional<SeenHand>();
    DPL_TRY(SeenHand seen, lookOnce(image, *crop, false));
    DPL_TRY(const SeenHand other, lookOnce(image, *crop, true));
    seen.score = 0.5 * (seen.score + other.score);
    if (seen.score < priors::kHandConfirmed) return std::optional<SeenHand>();
    seen.leftness = 0.5 * (seen.leftness + other.leftness);
    for (size_t k = 0; k < kHandMarks; ++k) {
        seen.spreadPx[k] = glm::length(seen.marks[k] - other.marks[k]);
        seen.marks[k] = 0.5 * (seen.marks[k] + other.marks[k]);
    }
    return std::optional(seen);
}

Result<std::vector<PersonCrop>> HandFinder::palms(const ImageRgb8& image, const PersonCrop& where) {
    std::vector<PersonCrop> kept;
    if (!palms_) return kept;
    DPL_TRY(const auto outputs, palms_->run(cropToTensor(image, where, kPalmSide, {0, 0, 0}, {1, 1, 1}), kPalmSide));
    if (outputs.size() != 1 || outputs[0].data.size() != kPalmAnchors * kPalmRow)
        return fail(Code::Unsupported, "{} has other outputs than MediaPipe's palm detector; run tools/models again",
                    network_files::kPalms);
    static const std::vector<Vec2d> centres = anchorCentres(kPalmSide, kPalmGrids);
    std::vector<std::pair<double, PersonCrop>> found;
    for (size_t a = 0; a < kPalmAnchors; ++a) {
        const float* row = outputs[0].data.data() + a * kPalmRow;
        const double score = 1 / (1 + std::exp(-double(row[0])));
        if (!(score >= kPalmScore)) continue;
        const auto at = [&](size_t i) { return cropToPicture(where, centres[a] + Vec2d(row[i], row[i + 1]), kPalmSide); };
        const Vec2d up = at(kPalmPoints + 4) - at(kPalmPoints);
        const double side = kPalmRoom * std::max(row[3], row[4]) * where.sidePx / kPalmSide, length = glm::length(up);
        if (!(length > 1) || !(side > 4) || !std::isfinite(side)) continue;
        found.push_back({score, {at(1) + (kPalmTowardsFingers * side / kPalmRoom / length) * up, side, std::atan2(up.x, -up.y)}});
    }
    std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    for (const auto& [score, crop] : found) {
        const bool known = std::any_of(kept.begin(), kept.end(), [&](const PersonCrop& other) {
            return glm::length(crop.centrePx - other.centrePx) < 0.25 * std::max(crop.sidePx, other.sidePx);
        });
        if (!known) kept.push_back(crop);
        if (kept.size() == kMostPalms) break;
    }
    return kept;
}

Result<std::optional<SeenHand>> HandFinder::atArm(const ImageRgb8& image, const ArmMarks& arm) {
    for (const double room : {priors::kHandRoom, priors::kSecondHandRoom}) {
        DPL_TRY(std::optional<SeenHand> seen, look(image, cropOfArm(arm, room)));
        if (seen && glm::length(seen->marks[0] - arm.wrist) < priors::kHandFromWrist * lengthPx(seen->marks)) return seen;
    }
    return std::optional<SeenHand>();
}

Result<std::vector<Keypoint>> HandFinder::find(const ImageRgb8& image, std::span<const Vec2d> landmarks, std::span<const double> confidence,
                                               bool closeup) {
    std::array<std::optional<SeenHand>, 2> hands;
    if (landmarks.size() < 33 || confidence.size() < 33) return fail(Code::InvalidArgument, "{} landmarks of a pose", landmarks.size());
    for (size_t side = 0; side < 2; ++side)
        if (confidence[15 + side] >= priors::kWristSeen) {
            DPL_TRY(hands[side], atArm(image, armOf(landmarks, side)));
        }
    if (hands[0] && hands[1] && isSameHand(hands[0]->marks, hands[1]->marks)) {
        const auto owner = armOfHand(hands[0]->marks[0], landmarks[15], landmarks[16]);
        for (size_t side = 0; side < 2; ++side)
            if (owner != side) hands[side].reset();
    }
    if (closeup && !hands[0] && !hands[1]) {
        const double longer = std::max(image.widthPx, image.heightPx);
        DPL_TRY(const auto places, palms(image, {{0.5 * image.widthPx, 0.5 * image.heightPx}, longer, 0}));
        for (const PersonCrop& place : places) {
            DPL_TRY(const std::optional<SeenHand> seen, look(image, place));
            if (!seen) continue;
            auto& slot = hands[seen->leftness >= 0.5 ? 0 : 1];
            if (!slot || slot->score < seen->score) slot = seen;
        }
    }
    std::vector<Keypoint> out;
    for (size_t side = 0; side < 2; ++side)
        if (hands[side]) put(*hands[side], side, out);
    return out;
}

}  // namespace dpl
