// SPDX-License-Identifier: Apache-2.0
// Skeletons without a single known name: what files leave out or add, and the bones that are found all the same.
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "sdk/avatar/humanoid.h"
#include "tests/unit/avatar/rigs.h"

namespace dpl {
namespace {

using Skeleton = std::vector<JointData>;

/** The skeleton without the joints whose bone `drops`; their children hang from the next joint above. */
Skeleton lacking(const Skeleton& from, const std::function<bool(const std::string&)>& drops) {
    Skeleton out;
    std::vector<int> place(from.size(), -1);
    for (size_t j = 0; j < from.size(); ++j) {
        int above = from[j].parent;
        while (above >= 0 && place[size_t(above)] < 0) above = from[size_t(above)].parent;
        if (drops(from[j].humanoidBone)) continue;
        place[j] = int(out.size());
        out.push_back(from[j]);
        out.back().parent = above < 0 ? -1 : place[size_t(above)];
    }
    return out;
}

bool has(const std::string& bone, const std::vector<const char*>& parts) {
    return std::any_of(parts.begin(), parts.end(), [&](const char* part) { return bone.find(part) != std::string::npos; });
}
bool isFinger(const std::string& bone) {
    return has(bone, {"Proximal", "Intermediate", "Distal"});
}

/** With end sites, as BVH files have them, `share` as long as the bone before. */
Skeleton withEnds(Skeleton rig, float share) {
    std::vector<bool> isLeaf(rig.size(), true);
    for (const JointData& joint : rig)
        if (joint.parent >= 0) isLeaf[size_t(joint.parent)] = false;
    for (size_t j = 0; j < isLeaf.size(); ++j) {
        if (!isLeaf[j]) continue;
        const Vec3f bone = rig[j].restPosition - rig[size_t(rig[j].parent)].restPosition;
        rig.push_back({rig[j].name + " end", int32_t(j), rig[j].restPosition + share * bone, {}});
    }
    return rig;
}

/** A joint halfway along each long bone of the limbs: in line, or beside it as a leaf. */
Skeleton withTwists(const Skeleton& from, bool inLine) {
    Skeleton out;
    std::vector<int32_t> place(from.size(), -1);
    std::vector<bool> done(from.size(), false);
    for (size_t j = 0; j < from.size(); ++j) {
        const int32_t parent = from[j].parent;
        int32_t above = parent < 0 ? -1 : place[size_t(parent)];
        if (parent >= 0 && !done[size_t(parent)] &&
            has(from[size_t(parent)].humanoidBone, {"UpperArm", "LowerArm", "UpperLeg", "LowerLeg"})) {
            done[size_t(parent)] = true;
            out.push_back({"twist", above, 0.5f * (from[size_t(parent)].restPosition + from[j].restPosition), {}});
            if (inLine) above = int32_t(out.size() - 1);
        }
        place[j] = int32_t(out.size());
        out.push_back(from[j]);
        out.back().parent = above;
    }
    return out;
}

/** A chain of joints that hangs from a bone. */
Skeleton with(Skeleton rig, const char* bone, const Vec3f& first, const Vec3f& step, int count) {
    int32_t above = int32_t(test::jointOf(rig, bone));
    const Vec3f start = rig[size_t(above)].restPosition + first;
    for (int i = 0; i < count; ++i) {
        rig.push_back({"more", above, start + float(i) * step, {}});
        above = int32_t(rig.size() - 1);
    }
    return rig;
}

void expectFound(const char* what, Skeleton rig) {
    std::vector<std::string> right;
    for (const JointData& joint : rig) right.push_back(isFinger(joint.humanoidBone) ? "" : joint.humanoidBone);  // names alone tell fingers
    for (size_t j = 0; j < rig.size(); ++j) {
        const bool end = rig[j].name.ends_with(" end");
        rig[j].humanoidBone.clear();
        rig[j].name = end ? rig[size_t(rig[j].parent)].name + " end" : "Bone" + std::to_string(j);
    }
    const auto found = humanoidBones(rig);
    for (size_t j = 0; j < rig.size(); ++j) EXPECT_EQ(found[j], right[j]) << what << ", joint " << j;
}

TEST(LimbsByShape, peopleWithoutNamesAreRecognised) {
    const Skeleton a = test::personRig(0.8f), t = test::personRig(0, 0);
    const Skeleton handless = lacking(a, isFinger);
    expectFound("T-pose", t);
    expectFound("A-pose", a);
    expectFound("T-pose, ends", withEnds(t, 0.4f));
    expectFound("no fingers", handless);
    for (const float share : {0.1f, 0.4f, 0.8f}) expectFound("no fingers, ends", withEnds(handless, share));
    for (const auto& [what, parts] : {std::pair("no toes", std::vector<const char*>{"Toes"}),
                                      {"no shoulders", {"Shoulder"}},
                                      {"no neck", {"neck"}},
                                      {"one spine", {"chest", "upperChest"}},
                                      {"no shoulders, toes, neck", {"Shoulder", "Toes", "neck"}}})
        for (const Skeleton& rig : {a, handless}) {
            const auto fewer = lacking(rig, [&, wanted = parts](const std::string& bone) { return has(bone, wanted); });
            expectFound(what, fewer);
            expectFound((std::string(what) + ", ends").c_str(), withEnds(fewer, 0.3f));
        }
    for (const bool inLine : {true, false})
        for (const Skeleton& rig : {a, handless}) {
            expectFound(inLine ? "twists in line" : "twists beside", withTwists(rig, inLine));
            expectFound(inLine ? "twists in line, ends" : "twists beside, ends", withEnds(withTwists(rig, inLine), 0.4f));
        }
}

TEST(LimbsByShape, whatElseHangsFromAPersonDoesNotConfuse) {
    const Skeleton a = test::personRig(0.8f);
    Skeleton above = a;
    for (JointData& joint : above) ++joint.parent;
    above.insert(above.begin(), {"root", -1, Vec3f(0), {}});
    expectFound("a root on the floor", above);
    Skeleton skirt = a, pigtails = a;
    for (const float side : {1.0f, -1.0f}) {
        pigtails = with(pigtails, "head", {side * 0.08f, 0, -0.1f}, {0, -0.1f, 0}, 4);
        for (const float z : {0.1f, -0.1f}) skirt = with(skirt, "hips", {side * 0.15f, -0.15f, z}, {0, -0.15f, 0}, 4);
    }
    expectFound("a skirt", skirt);
    expectFound("pigtails", pigtails);
    expectFound("a tail", with(a, "hips", {0, 0, -0.15f}, {0, -0.05f, -0.15f}, 6));
    expectFound("a sword", with(a, "rightHand", {-1, 0, 0}, {0, 0, 0}, 1));
    expectFound("a staff of three joints", with(a, "leftHand", {0.4f, 0, 0}, {0.4f, 0, 0}, 3));
    std::mt19937 random(1);
    std::normal_distribution<float> noise(0, 0.01f);
    Skeleton crooked = a;
    for (JointData& joint : crooked) joint.restPosition += Vec3f(noise(random), noise(random), noise(random));
    expectFound("a person measured to a centimetre", crooked);
}

TEST(LimbsByShape, whatIsNoPersonIsLeftAlone) {
    Skeleton chain, star;
    for (int j = 0; j < 40; ++j) {
        chain.push_back({"link", j - 1, Vec3f(0, 0.1f * float(j), 0), {}});
        star.push_back({"ray", j == 0 ? -1 : 0, Vec3f(std::cos(float(j)), std::sin(float(j)), 0), {}});
    }
    for (const Skeleton& rig : {chain, star})
        for (const std::string& bone : humanoidBones(rig)) EXPECT_EQ(bone, "");
}

}  // namespace
}  // namespace dpl
