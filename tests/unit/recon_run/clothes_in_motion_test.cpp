// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/clothes_in_motion.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace dpl::test {
namespace {

ClothFaults faults() {
    ClothFaults made;
    made.outside = {123, 1, 0.0021}, made.uncovered = {77, 2, 0.013};
    made.garments = {{.name = "top"}, {.name = "skirt", .longestStretch = 1.9, .longestSplatM = 0.04}};
    made.garments[1].outside = {120, 2, 0.0042}, made.garments[1].uncovered = {70, 0, 0.016};
    return made;
}

TEST(ClothesInMotion, textStatesWorstPoseAndShareOfAllAndOfEachGarment) {
    const std::string text = clothesText(faults(), "clips/walk.bvh", {0, 0.1, 0.2});
    EXPECT_TRUE(text.starts_with("clothes in walk.bvh, 3 poses")) << text;
    const size_t garment = text.find("  skirt  ");
    ASSERT_NE(garment, std::string::npos) << text;
    for (const auto& [line, ofGarment] : {std::pair{"0.210 %  (at most 123 pixels, at 0.1 s)", false},
                                          {"1.300 %  (at most 77 pixels, at 0.2 s)", false},
                                          {"0.420 %  (at most 120 pixels, at 0.2 s)", true},
                                          {"1.600 %  (at most 70 pixels, at 0.0 s)", true}}) {
        const size_t at = text.find(line);
        ASSERT_NE(at, std::string::npos) << line << "\n" << text;
        EXPECT_EQ(at > garment, ofGarment) << line;
    }
}

TEST(ClothesInMotion, jsonStatesTheSame) {
    const auto json = nlohmann::json::parse(clothesJson(faults(), "walk.bvh", {0, 0.1, 0.2}));
    EXPECT_EQ(json["outside_tubes"]["most_px"], 123);
    EXPECT_EQ(json["outside_tubes"]["worst_pose_s"], 0.1);
    EXPECT_EQ(json["uncovered"]["share"], 0.013);
    EXPECT_EQ(json["garments"][1]["name"], "skirt");
    EXPECT_EQ(json["garments"][1]["outside_tubes"]["share"], 0.0042);
    EXPECT_EQ(json["garments"][1]["uncovered"]["most_px"], 70);
    EXPECT_EQ(json["garments"][0]["outside_tubes"]["most_px"], 0);
}

}  // namespace
}  // namespace dpl::test
