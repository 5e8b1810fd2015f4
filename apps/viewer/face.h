// SPDX-License-Identifier: Apache-2.0
// An avatar's expressions as sliders: which it has, in which part of the face, and how much of each.
#pragma once

#include <array>
#include <cstdint>
#include <doppel/doppel.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

enum class FaceRegion : uint8_t { Eyes, Brows, Mouth, Jaw, Cheeks, Tongue };
constexpr size_t kFaceRegions = 6;

/** For people, such as "Eyes". */
const char* nameOf(FaceRegion region);

/** One slider: an expression, or those of both sides together. */
struct FaceSlider {
    std::string words;  // for people: "mouth smile", "mouth smile left"
    std::string names;  // of its expressions, as programs know them
    FaceRegion region = FaceRegion::Mouth;
    std::array<uint32_t, 2> expressions{};  // the same twice: it is one
};

class FaceByHand {
public:
    /** Of the expressions that the avatar holds. */
    static Result<FaceByHand> of(const doppel::Avatar& avatar);
    /** names: of all expressions; held: the indices of those that the avatar holds. */
    static FaceByHand of(const std::array<std::string, DPL_EXPRESSION_COUNT>& names, const std::vector<uint32_t>& held);

    /** The avatar has a face that moves. */
    bool any() const { return !single_.empty(); }
    /** Those whose words or names have `search` in them, in capitals or not; in regions, one after the other. */
    std::vector<const FaceSlider*> sliders(std::string_view search) const;
    float weight(const FaceSlider& slider) const { return weights[slider.expressions[0]]; }
    void set(const FaceSlider& slider, float weight) { weights[slider.expressions[0]] = weights[slider.expressions[1]] = weight; }
    bool isNeutral() const;

    bool together = true;  // one slider for left and right
    bool idles = false;    // it blinks and looks around by itself, beside the sliders
    std::array<float, DPL_EXPRESSION_COUNT> weights{};

private:
    std::vector<FaceSlider> single_, paired_;
};

}  // namespace dpl
