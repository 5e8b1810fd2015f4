// SPDX-License-Identifier: Apache-2.0
// The expressions of VRM 1.0 as mixtures of ARKit's, for streams that come in and files that go out. VRM says nothing of shapes: the
// shares are ours, those that look like the name on our faces.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "sdk/format/expression_names.h"

namespace dpl {

/** VRM's presets that move a face; "neutral", which moves nothing, is not among them. */
constexpr std::array<std::string_view, 17> kVrmExpressions{"happy",      "angry",  "sad",      "relaxed",  "surprised", "aa",
                                                           "ih",         "ou",     "ee",       "oh",       "blink",     "blinkLeft",
                                                           "blinkRight", "lookUp", "lookDown", "lookLeft", "lookRight"};

/** What VRM 0 calls them in its files, and what VRM 1 calls the same. */
constexpr std::array<std::pair<std::string_view, std::string_view>, 17> kVrm0Names{{{"joy", "happy"},
                                                                                    {"angry", "angry"},
                                                                                    {"sorrow", "sad"},
                                                                                    {"fun", "relaxed"},
                                                                                    {"a", "aa"},
                                                                                    {"i", "ih"},
                                                                                    {"u", "ou"},
                                                                                    {"e", "ee"},
                                                                                    {"o", "oh"},
                                                                                    {"blink", "blink"},
                                                                                    {"blink_l", "blinkLeft"},
                                                                                    {"blink_r", "blinkRight"},
                                                                                    {"lookup", "lookUp"},
                                                                                    {"lookdown", "lookDown"},
                                                                                    {"lookleft", "lookLeft"},
                                                                                    {"lookright", "lookRight"},
                                                                                    {"neutral", "neutral"}}};

/** A share of one of ARKit's expressions in one of VRM's. */
struct VrmShare {
    std::string_view of;    // VRM's name
    std::string_view name;  // ARKit's; "Both": left and right
    float weight;
};
constexpr VrmShare kVrmShares[] = {
    {"happy", "mouthSmileBoth", 0.8f},
    {"happy", "cheekSquintBoth", 0.5f},
    {"happy", "eyeSquintBoth", 0.3f},
    {"angry", "browDownBoth", 1},
    {"angry", "mouthPressBoth", 0.5f},
    {"angry", "noseSneerBoth", 0.5f},
    {"sad", "browInnerUp", 0.8f},
    {"sad", "mouthFrownBoth", 0.8f},
    {"relaxed", "mouthSmileBoth", 0.3f},
    {"relaxed", "eyeBlinkBoth", 0.2f},
    {"surprised", "eyeWideBoth", 1},
    {"surprised", "browInnerUp", 0.8f},
    {"surprised", "browOuterUpBoth", 0.8f},
    {"surprised", "jawOpen", 0.4f},
    {"aa", "jawOpen", 0.7f},
    {"ih", "jawOpen", 0.25f},
    {"ih", "mouthStretchBoth", 0.4f},
    {"ou", "mouthPucker", 0.8f},
    {"ou", "jawOpen", 0.15f},
    {"ee", "mouthStretchBoth", 0.6f},
    {"ee", "mouthSmileBoth", 0.2f},
    {"ee", "jawOpen", 0.1f},
    {"oh", "mouthFunnel", 0.7f},
    {"oh", "jawOpen", 0.4f},
    {"blink", "eyeBlinkBoth", 1},
    {"blinkLeft", "eyeBlinkLeft", 1},
    {"blinkRight", "eyeBlinkRight", 1},
    {"lookUp", "eyeLookUpBoth", 1},
    {"lookDown", "eyeLookDownBoth", 1},
    {"lookLeft", "eyeLookOutLeft", 1},
    {"lookLeft", "eyeLookInRight", 1},
    {"lookRight", "eyeLookInLeft", 1},
    {"lookRight", "eyeLookOutRight", 1},
};

/** Hands each share of one of VRM's expressions to take(expression of kExpressionNames, weight). False: VRM has no such name. */
template <class Take>
bool eachVrmShare(std::string_view of, Take&& take) {
    bool known = false;
    for (const VrmShare& share : kVrmShares) {
        if (share.of != of) continue;
        known = true;
        if (!share.name.ends_with("Both")) {
            take(*expressionOf(share.name), share.weight);
            continue;
        }
        const std::string stem(share.name.substr(0, share.name.size() - 4));
        for (const char* side : {"Left", "Right"}) take(*expressionOf(stem + side), share.weight);
    }
    return known;
}

}  // namespace dpl
