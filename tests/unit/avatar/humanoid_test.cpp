// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "sdk/avatar/humanoid.h"
#include "tests/unit/avatar/rigs.h"

namespace dpl {
namespace {

TEST(Humanoid, namesOfManyRigs) {
    const char* const kCases[][2] = {
        {"pelvis", "hips"},
        {"left_hip", "leftUpperLeg"},
        {"left_knee", "leftLowerLeg"},
        {"left_ankle", "leftFoot"},
        {"spine1", "spine"},  // SMPL-X
        {"spine3", "upperChest"},
        {"left_collar", "leftShoulder"},
        {"left_shoulder", "leftUpperArm"},
        {"left_elbow", "leftLowerArm"},
        {"right_wrist", "rightHand"},
        {"left_index1", "leftIndexProximal"},
        {"right_pinky3", "rightLittleDistal"},
        {"left_thumb1", "leftThumbMetacarpal"},
        {"left_eye_smplhf", "leftEye"},
        {"jaw", "jaw"},
        {"thigh_l", "leftUpperLeg"},
        {"upperarm_r", "rightUpperArm"},
        {"spine_01", "spine"},
        {"index_01_l", "leftIndexProximal"},  // game engine
        {"calf_r", "rightLowerLeg"},
        {"ball_l", "leftToes"},
        {"clavicle_l", "leftShoulder"},
        {"neck_01", "neck"},
        {"thumb_02_r", "rightThumbProximal"},
        {"upperleg01.L", "leftUpperLeg"},
        {"upperleg02.L", ""},
        {"lowerarm01.R", "rightLowerArm"},
        {"shoulder01.L", ""},
        {"wrist.L", "leftHand"},  // MakeHuman
        {"finger1-1.L", "leftThumbMetacarpal"},
        {"finger5-3.R", "rightLittleDistal"},
        {"spine05", "spine"},
        {"spine01", "upperChest"},
        {"metacarpal1.L", ""},
        {"toe2-1.L", ""},
        {"pelvis.L", ""},
        {"UpArm_L", "leftUpperArm"},
        {"LoLeg_R", "rightLowerLeg"},
        {"__UpLeg_L", ""},
        {"mixamorig:Hips", "hips"},
        {"mixamorig:LeftArm", "leftUpperArm"},
        {"mixamorig:LeftForeArm", "leftLowerArm"},  // Mixamo
        {"mixamorig:LeftShoulder", "leftShoulder"},
        {"mixamorig:Spine1", "chest"},
        {"mixamorig:RightUpLeg", "rightUpperLeg"},
        {"mixamorig:LeftToeBase", "leftToes"},
        {"mixamorig:LeftHandIndex3", "leftIndexDistal"},
        {"mixamorig:LeftHandIndex4", ""},
        {"hip", "hips"},
        {"abdomen", "spine"},
        {"chest", "chest"},
        {"lCollar", "leftShoulder"},
        {"rShldr", "rightUpperArm"},  // Daz / CMU
        {"lForeArm", "leftLowerArm"},
        {"rThigh", "rightUpperLeg"},
        {"lShin", "leftLowerLeg"},
        {"rButtock", ""},
        {"lMid1", "leftMiddleProximal"},
        {"LeftHip", "leftUpperLeg"},
        {"LHipJoint", ""},
        {"RightElbow", "rightLowerArm"},
        {"lowerback", "spine"},
        {"lhand", "leftHand"},  // bvh11
        {"upper_arm.L", "leftUpperArm"},
        {"DEF-forearm.R", "rightLowerArm"},
        {"f_index.02.L", "leftIndexIntermediate"},
        {"shoulder.L", "leftShoulder"},
        {"J_Bip_L_UpperArm", "leftUpperArm"},
        {"leftUpperLeg", "leftUpperLeg"},
        {"rightLittleIntermediate", "rightLittleIntermediate"},  // VRM
        {"leftThumbMetacarpal", "leftThumbMetacarpal"},
        {"upperChest", "upperChest"},
        {"", ""},
        {"l", ""},
        {"_", ""},
        {"12345678901234567890", ""},
        {"left", ""},
        {"Armature|", ""},
        {"camera", ""},
        {"left_index99999999999", ""},
    };
    for (const auto& c : kCases) EXPECT_EQ(humanoidBoneFor(c[0]), c[1]) << c[0];
}

TEST(Humanoid, everyBoneNameIsItsOwn) {
    for (const std::string_view bone : humanoidBoneNames()) EXPECT_EQ(humanoidBoneFor(bone), bone);
}

TEST(Humanoid, theTreeSettlesWhatNamesLeaveOpen) {
    // In files like bvh11 collars exist, so shoulders are upper arms. The first neck joint is the neck.
    std::vector<JointData> joints;
    const auto add = [&](const char* name, int parent) {
        joints.push_back({name, parent, {}, {}});
        return int(joints.size()) - 1;
    };
    const int hips = add("Hips", -1), leftHip = add("LeftHip", hips);
    add("LeftAnkle", add("LeftKnee", leftHip));
    add("RightAnkle", add("RightKnee", add("RightHip", hips)));
    const int chest2 = add("Chest2", add("Chest", add("lowerback", hips)));
    const int neck = add("lowerneck", chest2);
    add("Head", add("Neck", neck));
    const int leftShoulder = add("LeftShoulder", add("LeftCollar", chest2));
    add("lhand", add("LeftWrist", add("LeftElbow", leftShoulder)));
    add("RightWrist", add("RightElbow", add("RightShoulder", add("RightCollar", chest2))));
    const auto bones = humanoidBones(joints);
    EXPECT_EQ(bones[size_t(leftShoulder)], "leftUpperArm");
    EXPECT_EQ(bones[size_t(leftHip)], "leftUpperLeg");
    EXPECT_EQ(bones[size_t(neck)], "neck");
    EXPECT_EQ(bones[size_t(chest2)], "upperChest");
    std::set<std::string> once;
    for (const std::string& bone : bones) EXPECT_TRUE(bone.empty() || once.insert(bone).second) << bone << " twice";
}

TEST(Humanoid, smplFootBelowAnkleIsToes) {
    const auto rig = test::personRig(0);
    EXPECT_EQ(rig[test::jointOf(rig, "leftToes")].name, "left_foot");
    EXPECT_EQ(rig[test::jointOf(rig, "leftFoot")].name, "left_ankle");
    EXPECT_EQ(rig[test::jointOf(rig, "upperChest")].name, "spine3");
}

TEST(Humanoid, labelsThatAreSetAreKept) {
    std::vector<JointData> joints = {{"left_hip", -1, {}, "hips"}, {"pelvis", 0, {}, ""}};
    EXPECT_EQ(humanoidBones(joints), (std::vector<std::string>{"hips", ""}));
}

TEST(Humanoid, armsThatHangFromTheHeadLeaveNoNeck) {
    const std::vector<JointData> joints = {{"pelvis", -1, {0, 1, 0}},
                                           {"left_hip", 0, {0.1f, 0.9f, 0}},
                                           {"right_hip", 0, {-0.1f, 0.9f, 0}},
                                           {"spine1", 0, {0, 1.2f, 0}},
                                           {"head", 3, {0, 1.5f, 0}},
                                           {"left_shoulder", 4, {0.2f, 1.4f, 0}},
                                           {"right_shoulder", 4, {-0.2f, 1.4f, 0}},
                                           {"left_elbow", 5, {0.5f, 1.4f, 0}},
                                           {"right_elbow", 6, {-0.5f, 1.4f, 0}}};
    const auto bones = humanoidBones(joints);  // must end: the walk from the head never meets the top of the spine
    EXPECT_EQ(bones[0], "hips");
    EXPECT_EQ(bones[4], "head");
    EXPECT_EQ(std::count(bones.begin(), bones.end(), "neck"), 0);
}

}  // namespace
}  // namespace dpl
