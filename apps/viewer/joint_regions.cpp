// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/joint_regions.h"

#include <array>
#include <optional>
#include <string_view>

namespace dpl {
namespace {

std::optional<BodyRegion> regionOf(std::string_view bone) {
    const bool left = bone.starts_with("left");
    const auto has = [bone](std::string_view word) { return bone.find(word) != bone.npos; };
    for (const std::string_view word : {"Hand", "Thumb", "Index", "Middle", "Ring", "Little"})
        if (has(word)) return left ? BodyRegion::LeftHand : BodyRegion::RightHand;
    for (const std::string_view word : {"Shoulder", "Arm"})
        if (has(word)) return left ? BodyRegion::LeftArm : BodyRegion::RightArm;
    for (const std::string_view word : {"Leg", "Foot", "Toes"})
        if (has(word)) return left ? BodyRegion::LeftLeg : BodyRegion::RightLeg;
    if (has("Eye") || bone == "head" || bone == "neck" || bone == "jaw") return BodyRegion::HeadAndNeck;
    if (bone == "hips" || bone == "spine" || bone == "chest" || bone == "upperChest") return BodyRegion::Trunk;
    return std::nullopt;
}

}  // namespace

const char* nameOf(BodyRegion region) {
    static constexpr std::array<const char*, kBodyRegions> kNames = {"Head and neck", "Trunk",    "Left arm",  "Left hand", "Right arm",
                                                                     "Right hand",    "Left leg", "Right leg", "Others"};
    return kNames[size_t(region)];
}

std::vector<BodyRegion> regionsOf(std::span<const std::string> bones, std::span<const int32_t> parents) {
    std::vector<BodyRegion> regions;
    for (size_t i = 0; i < bones.size(); ++i) {
        const BodyRegion inherited = parents[i] >= 0 ? regions[size_t(parents[i])] : BodyRegion::Other;
        regions.push_back(regionOf(bones[i]).value_or(inherited));
    }
    return regions;
}

}  // namespace dpl
