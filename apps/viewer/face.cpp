// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/face.h"

#include <algorithm>
#include <cctype>
#include <optional>
#include <utility>

#include "apps/shared/pictures.h"

namespace dpl {
namespace {

constexpr std::string_view kLeftSide = "Left", kRightSide = "Right";

FaceRegion faceRegionOf(std::string_view name) {
    for (const auto& [word, region] : {std::pair("eye", FaceRegion::Eyes),
                                       {"brow", FaceRegion::Brows},
                                       {"jaw", FaceRegion::Jaw},
                                       {"cheek", FaceRegion::Cheeks},
                                       {"nose", FaceRegion::Cheeks},
                                       {"tongue", FaceRegion::Tongue}})
        if (name.starts_with(word)) return region;
    return FaceRegion::Mouth;
}

std::string inSmallLetters(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return out;
}

/** "mouthSmileLeft" -> "mouth smile left". */
std::string spelledOut(std::string_view name) {
    std::string words;
    for (const char letter : name) {
        if (std::isupper(static_cast<unsigned char>(letter))) words += ' ';
        words += char(std::tolower(static_cast<unsigned char>(letter)));
    }
    return words;
}

bool isDirection(std::string_view name) {  // the mouth or the jaw goes there
    return name == "mouthLeft" || name == "mouthRight" || name == "jawLeft" || name == "jawRight";
}

/** The expression that goes with one of the left side, and the words for both. Nothing: it has no side, or is the right one. */
struct OtherSide {
    std::string name, words;
};
std::optional<OtherSide> otherSideOf(const std::string& name) {
    if (isDirection(name) || !name.ends_with(kLeftSide)) return std::nullopt;
    const std::string stem = name.substr(0, name.size() - kLeftSide.size());
    // Eyes look to one side together: one of them inwards, the other outwards.
    if (stem == "eyeLookIn") return OtherSide{"eyeLookOutRight", "eye look right"};
    if (stem == "eyeLookOut") return OtherSide{"eyeLookInRight", "eye look left"};
    return OtherSide{stem + std::string(kRightSide), spelledOut(stem)};
}

}  // namespace

const char* nameOf(FaceRegion region) {
    static constexpr std::array<const char*, kFaceRegions> kNames = {"Eyes", "Brows", "Mouth", "Jaw", "Cheeks and nose", "Tongue"};
    return kNames[size_t(region)];
}

Result<FaceByHand> FaceByHand::of(const doppel::Avatar& avatar) {
    std::array<std::string, DPL_EXPRESSION_COUNT> names;
    std::vector<uint32_t> held;
    for (uint32_t i = 0; i < DPL_EXPRESSION_COUNT; ++i) {
        const auto about = avatar.expressionInfo(i);
        if (!about) return fromSdk(about.error());
        names[i] = about->name;
        if (about->drawn) held.push_back(i);
    }
    return of(names, held);
}

FaceByHand FaceByHand::of(const std::array<std::string, DPL_EXPRESSION_COUNT>& names, const std::vector<uint32_t>& held) {
    FaceByHand face;
    std::vector<bool> paired(names.size(), false);
    for (const uint32_t i : held) face.single_.push_back({spelledOut(names[i]), names[i], faceRegionOf(names[i]), {i, i}});
    for (const uint32_t i : held) {
        const auto other = otherSideOf(names[i]);
        const auto with = other ? std::find_if(held.begin(), held.end(), [&](uint32_t j) { return names[j] == other->name; }) : held.end();
        if (with == held.end()) continue;
        paired[i] = paired[*with] = true;
        face.paired_.push_back({other->words, names[i] + ", " + other->name, faceRegionOf(names[i]), {i, *with}});
    }
    for (const FaceSlider& slider : face.single_)
        if (!paired[slider.expressions[0]]) face.paired_.push_back(slider);
    for (auto* sliders : {&face.single_, &face.paired_})
        std::stable_sort(sliders->begin(), sliders->end(), [](const FaceSlider& a, const FaceSlider& b) { return a.region < b.region; });
    return face;
}

std::vector<const FaceSlider*> FaceByHand::sliders(std::string_view search) const {
    std::vector<const FaceSlider*> found;
    const std::string wanted = inSmallLetters(search);
    for (const FaceSlider& slider : together ? paired_ : single_)
        if (slider.words.find(wanted) != std::string::npos || inSmallLetters(slider.names).find(wanted) != std::string::npos)
            found.push_back(&slider);
    return found;
}

bool FaceByHand::isNeutral() const {
    return std::all_of(weights.begin(), weights.end(), [](float weight) { return weight == 0; });
}

}  // namespace dpl
