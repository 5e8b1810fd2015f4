// SPDX-License-Identifier: Apache-2.0
// Converts BlazePose landmarks to the 24 keypoints of a scan.
#include <algorithm>
#include <array>
#include <cmath>

#include "reconstruction/input/observe/observations.h"
#include "reconstruction/input/observe/priors.h"

namespace dpl {
namespace {

constexpr std::array<std::string_view, 24> kNames{"nose",       "eye_l",      "eye_r",   "ear_l",   "ear_r",   "neck",
                                                  "shoulder_l", "shoulder_r", "elbow_l", "elbow_r", "wrist_l", "wrist_r",
                                                  "knuckle_l",  "knuckle_r",  "pelvis",  "hip_l",   "hip_r",   "knee_l",
                                                  "knee_r",     "ankle_l",    "ankle_r", "toe_l",   "toe_r",   "head_top"};
enum Name : size_t {
    Nose,
    EyeL,
    EyeR,
    EarL,
    EarR,
    Neck,
    ShoulderL,
    ShoulderR,
    ElbowL,
    ElbowR,
    WristL,
    WristR,
    KnuckleL,
    KnuckleR,
    Pelvis,
    HipL,
    HipR,
    KneeL,
    KneeR,
    AnkleL,
    AnkleR,
    ToeL,
    ToeR,
    HeadTop
};

// Keypoints that are landmarks themselves: (keypoint, BlazePose index).
constexpr std::array<std::pair<size_t, size_t>, 17> kDirect{{{Nose, 0},
                                                             {EyeL, 2},
                                                             {EyeR, 5},
                                                             {EarL, 7},
                                                             {EarR, 8},
                                                             {ShoulderL, 11},
                                                             {ShoulderR, 12},
                                                             {ElbowL, 13},
                                                             {ElbowR, 14},
                                                             {WristL, 15},
                                                             {WristR, 16},
                                                             {HipL, 23},
                                                             {HipR, 24},
                                                             {KneeL, 25},
                                                             {KneeR, 26},
                                                             {AnkleL, 27},
                                                             {AnkleR, 28}}};

}  // namespace

std::span<const std::string_view> observedKeypointNames() {
    return kNames;
}

std::vector<Keypoint> keypointsFromLandmarks(std::span<const Vec2d> landmarks, std::span<const double> confidence, const ImageGrey8* mask) {
    std::vector<Keypoint> out(kNames.size());
    if (landmarks.size() < 33 || confidence.size() < 33) return out;
    std::array<Vec2d, 33> p{};
    std::copy_n(landmarks.begin(), 33, p.begin());
    const Vec2d trunk = 0.5 * (p[11] + p[12]) - 0.5 * (p[23] + p[24]);
    for (const size_t side : {0, 1}) p[25 + side] -= priors::kKneeRaise * (p[25 + side] - p[23 + side]);
    for (const size_t hip : {23, 24}) p[hip] += priors::kHipRaise * trunk;
    for (const size_t shoulder : {11, 12}) p[shoulder] -= priors::kShoulderDrop * trunk;
    for (const auto& [name, landmark] : kDirect) out[name] = {p[landmark], confidence[landmark]};
    const auto blend = [&](size_t a, size_t b, double share) {
        return Keypoint{p[a] + share * (p[b] - p[a]), std::min(confidence[a], confidence[b])};
    };
    out[KnuckleL] = blend(17, 19, 0.5);
    out[KnuckleR] = blend(18, 20, 0.5);
    out[ToeL] = blend(29, 31, priors::kToeShare);
    out[ToeR] = blend(30, 32, priors::kToeShare);
    out[Pelvis] = blend(23, 24, 0.5);
    const Keypoint shoulders = blend(11, 12, 0.5);
    // In a side view one ear is hidden and its landmark uncertain, but the middle of both stays accurate. Use the higher confidence.
    const Keypoint ears{0.5 * (p[7] + p[8]), std::max(confidence[7], confidence[8])};
    const double trust = priors::kDerivedTrust * std::min(shoulders.confidence, ears.confidence);
    const Vec2d neckToEars = ears.px - shoulders.px;
    out[Neck] = {shoulders.px + priors::kNeckShare * neckToEars, trust};
    double reach = priors::kHeadTopShare;
    if (mask && !mask->pixels.empty()) {
        const auto person = [&](const Vec2d& px) {
            return px.x >= 0 && px.y >= 0 && px.x < mask->widthPx && px.y < mask->heightPx &&
                   mask->pixels[size_t(px.y) * mask->widthPx + size_t(px.x)] >= 128;
        };
        if (person(ears.px))  // search along the neck's line for the outline, within the size of a head
            for (reach = 0.3; reach < 1.0 && person(ears.px + reach * neckToEars); reach += 0.01) {
            }
    }
    out[HeadTop] = {ears.px + reach * neckToEars, trust};
    for (Keypoint& k : out) {
        if (!(k.confidence > 0.02)) k.confidence = 0;
        if (!std::isfinite(k.px.x) || !std::isfinite(k.px.y)) k = {};
    }
    return out;
}

}  // namespace dpl
