// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/vrm_write.h"

#include <algorithm>
#include <string>
#include <string_view>

namespace dpl {
namespace {

// By the specification of humanoids of VRM 1.0.
constexpr std::string_view kDemanded[] = {"hips",         "spine",         "head",          "leftUpperLeg",  "leftLowerLeg",
                                          "leftFoot",     "rightUpperLeg", "rightLowerLeg", "rightFoot",     "leftUpperArm",
                                          "leftLowerArm", "leftHand",      "rightUpperArm", "rightLowerArm", "rightHand"};

/** The bone that a bone may not be there without; empty: none. */
std::string neededBy(const std::string& bone) {
    if (bone == "upperChest") return "chest";
    const auto with = [&](std::string_view end, std::string_view other) {
        return bone.ends_with(end) ? bone.substr(0, bone.size() - end.size()) + std::string(other) : std::string();
    };
    const bool thumb = bone.find("Thumb") != bone.npos;
    if (bone.ends_with("Distal")) return with("Distal", thumb ? "Proximal" : "Intermediate");
    if (bone.ends_with("Intermediate")) return with("Intermediate", "Proximal");
    return thumb && bone.ends_with("Proximal") ? with("Proximal", "Metacarpal") : std::string();
}

}  // namespace

Status checkVrmBones(std::span<const JointData> joints) {
    for (const std::string_view bone : kDemanded)
        if (std::none_of(joints.begin(), joints.end(), [&](const JointData& joint) { return joint.humanoidBone == bone; }))
            return fail(Code::InvalidArgument, "the skeleton has no bone '{}', which VRM demands; write the mesh without --vrm", bone);
    return {};
}

Status addVrm(GlbBuilder& glb, const AvatarData& avatar, const VrmAbout& about) {
    if (about.author.empty()) return fail(Code::InvalidArgument, "a VRM names its author");
    Json bones = Json::object();
    for (size_t j = 0; j < avatar.joints.size(); ++j)
        if (const std::string& bone = avatar.joints[j].humanoidBone; !bone.empty()) bones[bone] = {{"node", j}};
    DPL_RETURN_IF_ERROR(checkVrmBones(avatar.joints));
    for (bool again = true; again;) {
        again = false;
        for (auto bone = bones.begin(); bone != bones.end(); ++bone)
            if (const std::string needed = neededBy(bone.key()); !needed.empty() && !bones.contains(needed)) {
                bones.erase(bone), again = true;
                break;
            }
    }
    Json annotations = Json::array();
    for (size_t l = 0; l < avatar.mesh.layers.size(); ++l) annotations.push_back({{"node", avatar.joints.size() + l}, {"type", "auto"}});
    glb.root["extensionsUsed"].push_back("VRMC_vrm");
    glb.root["extensions"]["VRMC_vrm"] = {{"specVersion", "1.0"},
                                          {"meta",
                                           {{"name", avatar.name.empty() ? "avatar" : avatar.name},
                                            {"authors", Json::array({about.author})},
                                            {"licenseUrl", "https://vrm.dev/licenses/1.0/"},
                                            {"avatarPermission", "onlyAuthor"},
                                            {"allowExcessivelyViolentUsage", false},
                                            {"allowExcessivelySexualUsage", false},
                                            {"commercialUsage", "personalNonProfit"},
                                            {"allowPoliticalOrReligiousUsage", false},
                                            {"allowAntisocialOrHateUsage", false},
                                            {"creditNotation", "required"},
                                            {"allowRedistribution", false},
                                            {"modification", "prohibited"}}},
                                          {"humanoid", {{"humanBones", std::move(bones)}}},
                                          {"firstPerson", {{"meshAnnotations", std::move(annotations)}}}};
    return {};
}

}  // namespace dpl
