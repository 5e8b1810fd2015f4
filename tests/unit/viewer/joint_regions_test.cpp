// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/joint_regions.h"

#include <gtest/gtest.h>

namespace {

using namespace dpl;
using enum BodyRegion;

TEST(JointRegions, followHumanoidBones) {
    const std::vector<std::string> bones = {"hips",      "spine",         "neck",         "head",      "leftEye",
                                            "jaw",       "leftShoulder",  "leftLowerArm", "leftHand",  "leftThumbMetacarpal",
                                            "rightHand", "rightUpperArm", "leftUpperLeg", "rightFoot", "rightLittleDistal",
                                            "leftToes",  "upperChest"};
    const std::vector<BodyRegion> want = {Trunk,   Trunk,    HeadAndNeck, HeadAndNeck, HeadAndNeck, HeadAndNeck,
                                          LeftArm, LeftArm,  LeftHand,    LeftHand,    RightHand,   RightArm,
                                          LeftLeg, RightLeg, RightHand,   LeftLeg,     Trunk};
    EXPECT_EQ(regionsOf(bones, std::vector<int32_t>(bones.size(), -1)), want);
}

TEST(JointRegions, jointsWithoutBoneAreWhereTheirParentIs) {
    const std::vector<std::string> bones = {"", "hips", "", "leftUpperLeg", "", ""};
    const std::vector<int32_t> parents = {-1, 0, 1, 1, 3, 4};
    EXPECT_EQ(regionsOf(bones, parents), (std::vector<BodyRegion>{Other, Trunk, Trunk, LeftLeg, LeftLeg, LeftLeg}));
}

}  // namespace
