// SPDX-License-Identifier: Apache-2.0
// Sources: VRM 1.0 specification (humanoid.md); Unity scripting reference (HumanBodyBones); Apple's documentation of ARSkeletonDefinition
// and the names that defaultBody3D gives on devices; OpenXR registry (XR_FB_body_tracking, XR_EXT_hand_tracking); MediaPipe guide "Pose
// landmark detection".
#include "sdk/motion/track_format.h"

#include <array>
#include <string_view>
#include <vector>

#include "sdk/avatar/humanoid.h"

namespace dpl {
namespace {

using Table = std::vector<TrackedJoint>;
constexpr std::string_view kSides[] = {"left", "right"};

Table vrm() {
    Table table;
    for (const std::string_view bone : humanoidBoneNames()) table.push_back({std::string(bone), std::string(bone)});
    return table;
}

std::string capital(std::string text) {
    text[0] = char(text[0] - 'a' + 'A');
    return text;
}

Table unity() {
    Table table;
    const auto add = [&](const std::string& bone) { table.push_back({capital(bone), bone}); };
    const auto both = [&](const char* part) {
        for (const std::string_view side : kSides) add(std::string(side) + part);
    };
    add("hips");
    both("UpperLeg"), both("LowerLeg"), both("Foot");
    add("spine"), add("chest"), add("neck"), add("head");
    both("Shoulder"), both("UpperArm"), both("LowerArm"), both("Hand"), both("Toes"), both("Eye");
    add("jaw");
    static constexpr const char *kUnitySegments[] = {"Proximal", "Intermediate", "Distal"},
                                *kThumb[] = {"Metacarpal", "Proximal", "Distal"};
    for (const std::string_view side : kSides)
        for (const std::string finger : {"Thumb", "Index", "Middle", "Ring", "Little"})
            for (size_t i = 0; i < 3; ++i) {  // Unity calls the first bone of the thumb proximal, VRM 1.0 metacarpal
                const std::string bone = std::string(side) + finger;
                table.push_back({capital(bone + kUnitySegments[i]), bone + (finger == "Thumb" ? kThumb[i] : kUnitySegments[i])});
            }
    add("upperChest");
    return table;
}

Table arkit() {
    Table table = {{"root", ""}, {"hips_joint", "hips"}};
    for (const std::string_view side : kSides) {
        const std::string s(side);
        for (const auto& [joint, bone] :
             {std::pair("_upLeg_joint", "UpperLeg"), {"_leg_joint", "LowerLeg"}, {"_foot_joint", "Foot"}, {"_toes_joint", "Toes"}})
            table.push_back({s + joint, s + bone});
        table.push_back({s + "_toesEnd_joint", ""});
    }
    for (int i = 1; i <= 7; ++i)
        table.push_back({"spine_" + std::to_string(i) + "_joint", i == 2 ? "spine" : i == 4 ? "chest" : i == 7 ? "upperChest" : ""});
    const auto arm = [&](const std::string& s) {
        for (const auto& [joint, bone] : {std::pair("_shoulder_1_joint", "Shoulder"),
                                          {"_arm_joint", "UpperArm"},
                                          {"_forearm_joint", "LowerArm"},
                                          {"_hand_joint", "Hand"}})
            table.push_back({s + joint, s + bone});
        for (const auto& [joint, finger] : {std::pair("Index", "Index"), {"Mid", "Middle"}, {"Pinky", "Little"}, {"Ring", "Ring"}}) {
            const std::string name = s + "_hand" + joint, bone = s + finger;
            table.push_back({name + "Start_joint", ""});
            table.push_back({name + "_1_joint", bone + "Proximal"});
            table.push_back({name + "_2_joint", bone + "Intermediate"});
            table.push_back({name + "_3_joint", bone + "Distal"});
            table.push_back({name + "End_joint", ""});
        }
        table.push_back({s + "_handThumbStart_joint", s + "ThumbMetacarpal"});
        table.push_back({s + "_handThumb_1_joint", s + "ThumbProximal"});
        table.push_back({s + "_handThumb_2_joint", s + "ThumbDistal"});
        table.push_back({s + "_handThumbEnd_joint", ""});
    };
    arm("left");
    for (int i = 1; i <= 4; ++i) table.push_back({"neck_" + std::to_string(i) + "_joint", i == 1 ? "neck" : ""});
    table.insert(table.end(), {{"head_joint", "head"}, {"jaw_joint", ""}, {"chin_joint", ""}});
    const auto eye = [&](const std::string& s) {
        for (const char* joint : {"_eye_joint", "_eyeLowerLid_joint", "_eyeUpperLid_joint", "_eyeball_joint"})
            table.push_back({s + joint, ""});
    };
    eye("left");
    table.push_back({"nose_joint", ""});
    eye("right");
    arm("right");
    return table;
}

/** The 26 joints of XrHandJointEXT; prefix such as "LEFT_". */
void addHand(Table& table, const std::string& prefix, const std::string& side) {
    table.push_back({prefix + "PALM", ""});
    table.push_back({prefix + "WRIST", side + "Hand"});
    for (const auto& [joint, finger] :
         {std::pair("THUMB", "Thumb"), {"INDEX", "Index"}, {"MIDDLE", "Middle"}, {"RING", "Ring"}, {"LITTLE", "Little"}}) {
        const std::string name = prefix + joint + "_", bone = side + finger;
        const bool thumb = std::string_view(finger) == "Thumb";
        table.push_back({name + "METACARPAL", thumb ? bone + "Metacarpal" : std::string()});
        table.push_back({name + "PROXIMAL", bone + "Proximal"});
        if (!thumb) table.push_back({name + "INTERMEDIATE", bone + "Intermediate"});
        table.push_back({name + "DISTAL", bone + "Distal"});
        table.push_back({name + "TIP", ""});
    }
}

Table fb() {
    Table table = {{"ROOT", ""},        {"HIPS", "hips"},        {"SPINE_LOWER", "spine"}, {"SPINE_MIDDLE", "chest"},
                   {"SPINE_UPPER", ""}, {"CHEST", "upperChest"}, {"NECK", "neck"},         {"HEAD", "head"}};
    for (const auto& [prefix, side] : {std::pair<std::string, std::string>("LEFT_", "left"), {"RIGHT_", "right"}}) {
        table.push_back({prefix + "SHOULDER", side + "Shoulder"});
        table.push_back({prefix + "SCAPULA", ""});
        table.push_back({prefix + "ARM_UPPER", side + "UpperArm"});
        table.push_back({prefix + "ARM_LOWER", side + "LowerArm"});
        table.push_back({prefix + "HAND_WRIST_TWIST", ""});
    }
    addHand(table, "LEFT_HAND_", "left");
    addHand(table, "RIGHT_HAND_", "right");
    return table;
}

Table openxrHands() {
    Table table = {{"HEAD", "head"}};
    addHand(table, "LEFT_", "left");
    addHand(table, "RIGHT_", "right");
    return table;
}

Table mediapipe() {
    Table table;
    for (const char* name :
         {"nose",        "left eye (inner)", "left eye",     "left eye (outer)", "right eye (inner)", "right eye",      "right eye (outer)",
          "left ear",    "right ear",        "mouth (left)", "mouth (right)",    "left shoulder",     "right shoulder", "left elbow",
          "right elbow", "left wrist",       "right wrist",  "left pinky",       "right pinky",       "left index",     "right index",
          "left thumb",  "right thumb",      "left hip",     "right hip",        "left knee",         "right knee",     "left ankle",
          "right ankle", "left heel",        "right heel",   "left foot index",  "right foot index"})
        table.push_back({name, ""});
    return table;
}

}  // namespace

std::span<const TrackedJoint> trackedJoints(TrackFormat format) {
    static const std::array<Table, kTrackFormats> tables = {vrm(), unity(), arkit(), fb(), openxrHands(), mediapipe()};
    return uint32_t(format) < kTrackFormats ? std::span<const TrackedJoint>(tables[size_t(format)]) : std::span<const TrackedJoint>();
}

}  // namespace dpl
