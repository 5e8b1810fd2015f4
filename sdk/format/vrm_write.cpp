// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/vrm_write.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "sdk/format/skinned_mesh_write.h"
#include "sdk/format/vrm_expressions.h"

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

/** The bindings of one of VRM's expressions to morph targets: a node, the number of its target, and a weight. */
class Bindings {
public:
    Bindings(const AvatarData& avatar, std::span<const MeshMorph> morphs) {
        std::vector<uint32_t> targetCount(avatar.mesh.layers.size(), 0);
        for (const MeshMorph& morph : morphs)
            for (size_t l = 0; l < avatar.mesh.layers.size(); ++l)
                if (movesLayer(morph, avatar.mesh.layers[l]))
                    of_[morph.expression].push_back({{"node", avatar.joints.size() + l}, {"index", targetCount[l]++}});
    }
    void add(size_t expression, float weight, Json& to) const {
        for (Json bind : of_[expression]) {
            bind["weight"] = std::round(weight * 100.0) / 100;  // shares have two decimals; a float would be written with nine
            to.push_back(std::move(bind));
        }
    }

private:
    std::array<std::vector<Json>, kExpressionCount> of_;
};

Json expressions(const Bindings& bindings, std::span<const MeshMorph> morphs) {
    Json out;
    for (const std::string_view name : kVrmExpressions) {
        Json binds = Json::array();
        eachVrmShare(name, [&](size_t expression, float weight) { bindings.add(expression, weight, binds); });
        if (!binds.empty()) out["preset"][std::string(name)]["morphTargetBinds"] = std::move(binds);
    }
    for (const MeshMorph& morph : morphs) {
        Json binds = Json::array();
        bindings.add(morph.expression, 1, binds);
        if (!binds.empty()) out["custom"][kExpressionNames[morph.expression]]["morphTargetBinds"] = std::move(binds);
    }
    return out;
}

/** Whether a bone moves vertices. */
bool carriesSkin(const AvatarData& avatar, std::string_view bone) {
    for (size_t v = 0; v < avatar.mesh.jointIndices.size(); ++v)
        for (int k = 0; k < 4; ++k)
            if (avatar.mesh.jointWeights[v][k] > 0 && avatar.joints[avatar.mesh.jointIndices[v][k]].humanoidBone == bone) return true;
    return false;
}

/** Gazes by expressions; null where there are none, or where bones turn the eyes. */
Json gazes(const AvatarData& avatar, std::span<const MeshMorph> morphs) {
    constexpr float kFarthestDegrees = 30;  // of a gaze, where its expression has weight 1
    Vec3f eyes(0);
    size_t count = 0;
    for (const MeshMorph& morph : morphs) {
        if (!std::string_view(kExpressionNames[morph.expression]).starts_with("eyeLookUp")) continue;
        for (const uint32_t v : morph.vertices) eyes += avatar.mesh.restPositions[v], ++count;
    }
    if (count == 0 || carriesSkin(avatar, "leftEye")) return nullptr;
    const auto head = std::find_if(avatar.joints.begin(), avatar.joints.end(),
                                   [](const JointData& joint) { return joint.humanoidBone == "head"; });  // checkVrmBones() found it
    const Vec3f fromHead = eyes / float(count) - head->restPosition;
    Json out = {{"type", "expression"}, {"offsetFromHeadBone", {fromHead.x, fromHead.y, fromHead.z}}};
    for (const char* range : {"rangeMapHorizontalInner", "rangeMapHorizontalOuter", "rangeMapVerticalDown", "rangeMapVerticalUp"})
        out[range] = {{"inputMaxValue", kFarthestDegrees}, {"outputScale", 1}};
    return out;
}

}  // namespace

Status checkVrmBones(std::span<const JointData> joints) {
    for (const std::string_view bone : kDemanded)
        if (std::none_of(joints.begin(), joints.end(), [&](const JointData& joint) { return joint.humanoidBone == bone; }))
            return fail(Code::InvalidArgument, "the skeleton has no bone '{}', which VRM demands; write the mesh without --vrm", bone);
    return {};
}

Status addVrm(GlbBuilder& glb, const AvatarData& avatar, const VrmAbout& about, std::span<const MeshMorph> morphs) {
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
    Json& vrm = glb.root["extensions"]["VRMC_vrm"] = {{"specVersion", "1.0"},
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
    if (Json shown = expressions(Bindings(avatar, morphs), morphs); !shown.is_null()) vrm["expressions"] = std::move(shown);
    if (Json looks = gazes(avatar, morphs); !looks.is_null()) vrm["lookAt"] = std::move(looks);
    return {};
}

}  // namespace dpl
