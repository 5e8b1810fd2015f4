// SPDX-License-Identifier: Apache-2.0
// Bone lengths as shape morphs, for bodies whose own morphs hardly change them. A stretch moves every joint below the bone, and moves the
// skin along the bone in proportion, so that joints keep their place inside the limb.
#include <algorithm>
#include <array>

#include "reconstruction/subject/body/body_tools.h"
#include "reconstruction/subject/body/priors.h"

namespace dpl {
namespace {

struct Stretch {
    const char* name;
    std::array<std::array<const char*, 2>, 2> bones;  // (from, to) of the left and the right side
};
constexpr Stretch kStretches[] = {{"bone_upper_arm", {{{"leftUpperArm", "leftLowerArm"}, {"rightUpperArm", "rightLowerArm"}}}},
                                  {"bone_lower_arm", {{{"leftLowerArm", "leftHand"}, {"rightLowerArm", "rightHand"}}}},
                                  {"bone_hand", {{{"leftHand", "leftMiddleProximal"}, {"rightHand", "rightMiddleProximal"}}}},
                                  {"bone_shoulder", {{{"leftShoulder", "leftUpperArm"}, {"rightShoulder", "rightUpperArm"}}}},
                                  {"bone_hip", {{{"hips", "leftUpperLeg"}, {"hips", "rightUpperLeg"}}}},
                                  {"bone_upper_leg", {{{"leftUpperLeg", "leftLowerLeg"}, {"rightUpperLeg", "rightLowerLeg"}}}},
                                  {"bone_lower_leg", {{{"leftLowerLeg", "leftFoot"}, {"rightLowerLeg", "rightFoot"}}}},
                                  {"bone_foot", {{{"leftFoot", "leftToes"}, {"rightFoot", "rightToes"}}}},
                                  {"bone_trunk", {{{"hips", "neck"}, {"", ""}}}},
                                  {"bone_neck", {{{"neck", "head"}, {"", ""}}}}};

/** Adds the stretch of one bone to a morph. */
void addStretch(const BodyModel& body, int32_t from, int32_t to, ShapeMorph& morph) {
    const Vec3f start = body.joints[size_t(from)].restPosition, bone = body.joints[size_t(to)].restPosition - start;
    const float length2 = glm::dot(bone, bone);
    if (!(length2 > 1e-8f)) return;
    const auto along = [&](const Vec3f& p) { return std::clamp(glm::dot(p - start, bone) / length2, 0.0f, 1.0f); };
    std::vector<bool> inside(body.joints.size(), false);  // joints from `from` to the parent of `to`: their skin lies along the bone
    for (int32_t j = body.joints[size_t(to)].parent; j >= 0; j = body.joints[size_t(j)].parent) {
        inside[size_t(j)] = true;
        if (j == from) break;
    }
    if (!inside[size_t(from)]) return;  // `to` is not below `from`
    std::vector<float> share(body.joints.size(), 0.0f);
    for (size_t j = 0; j < body.joints.size(); ++j) {
        const int32_t parent = body.joints[j].parent;
        if (int32_t(j) == from || parent < 0) continue;
        if (int32_t(j) == to || inside[j])
            share[j] = int32_t(j) == to                                                        ? 1.0f
                       : share[size_t(parent)] > 0 || parent == from || inside[size_t(parent)] ? along(body.joints[j].restPosition)
                                                                                               : 0.0f;
        else if (inside[size_t(parent)] && parent != from)
            share[j] = along(body.joints[j].restPosition);  // joints that branch off along the bone, such as the collars
        else
            share[j] = share[size_t(parent)];
        morph.jointOffsets[j] += priors::kBoneStretch * share[j] * bone;
    }
    for (size_t v = 0; v < body.mesh.restPositions.size(); ++v) {
        float s = 0;
        for (int i = 0; i < 4; ++i) {
            const size_t j = body.mesh.jointIndices[v][i];
            s += float(body.mesh.jointWeights[v][i]) / 255 * (inside[j] ? along(body.mesh.restPositions[v]) : share[j]);
        }
        morph.vertexOffsets[v] += priors::kBoneStretch * s * bone;
    }
}

}  // namespace

BodyModel withBoneMorphs(BodyModel body) {
    for (const Stretch& stretch : kStretches) {
        if (std::any_of(body.morphs.begin(), body.morphs.end(), [&](const ShapeMorph& m) { return m.name == stretch.name; })) continue;
        ShapeMorph morph{stretch.name, -4, 4, std::vector<Vec3f>(body.mesh.restPositions.size(), Vec3f(0)),
                         std::vector<Vec3f>(body.joints.size(), Vec3f(0))};
        bool found = false;
        for (const auto& [fromBone, toBone] : stretch.bones) {
            const int32_t from = findHumanoid(body, fromBone), to = findHumanoid(body, toBone);
            if (!*fromBone || from < 0 || to < 0) continue;
            addStretch(body, from, to, morph);
            found = true;
        }
        if (!found) continue;
        if (const int32_t foot = findHumanoid(body, "leftFoot"); foot >= 0) {  // keep the feet on the floor
            const float lift = morph.jointOffsets[size_t(foot)].y;
            for (Vec3f& o : morph.jointOffsets) o.y -= lift;
            for (Vec3f& o : morph.vertexOffsets) o.y -= lift;
        }
        body.morphs.push_back(std::move(morph));
    }
    return body;
}

}  // namespace dpl
