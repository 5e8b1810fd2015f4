// SPDX-License-Identifier: Apache-2.0
// Finds the points of hands in a picture, with MediaPipe's networks of hands. Private to reconstruction/input/observe and its tests.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "reconstruction/input/observe/hand_crop.h"
#include "reconstruction/input/observe/onnx_net.h"

namespace dpl {

/** A hand that the network confirms. */
struct SeenHand {
    HandMarks marks{};
    std::array<double, kHandMarks> spreadPx{};  // distance between the marks of the picture and of its mirror image
    double score = 0;                           // 0 … 1, that it is a hand
    double leftness = 0.5;                      // 0 … 1, that it is a left one, as the network says
};

class HandFinder {
public:
    /** Nothing when the folder lacks the network of a hand's points. The one that finds palms is optional. */
    static Result<std::optional<HandFinder>> loadIfThere(const std::filesystem::path& models);

    /** The hand in a square, which its own marks correct once. Nothing when the network sees none. */
    Result<std::optional<SeenHand>> look(const ImageRgb8& image, const PersonCrop& start);

    /** Squares about the palms that are seen in a square of the picture, best first. */
    Result<std::vector<PersonCrop>> palms(const ImageRgb8& image, const PersonCrop& where);

    /** The hands of a person by the 33 pose landmarks and their confidence (BlazePose order), in the order of handKeypointNames(). A hand
     *  belongs to the arm at whose wrist it is; one that neither arm explains, or both, is nobody's. `closeup`: where no arm shows a hand,
     *  palms of the whole picture count, and the network says which side they are of. Empty when no hand is found. */
    Result<std::vector<Keypoint>> find(const ImageRgb8& image, std::span<const Vec2d> landmarks33, std::span<const double> confidence33,
                                       bool closeup);

private:
    HandFinder(OnnxNet marks, std::optional<OnnxNet> palms) : marks_(std::move(marks)), palms_(std::move(palms)) {}
    Result<SeenHand> lookOnce(const ImageRgb8& image, const PersonCrop& crop, bool mirrored);
    Result<std::optional<SeenHand>> atArm(const ImageRgb8& image, const ArmMarks& arm);

    OnnxNet marks_;
    std::optional<OnnxNet> palms_;
};

}  // namespace dpl
