// SPDX-License-Identifier: Apache-2.0
// glTF clips: joints with arbitrary axes under a rotated and scaled armature give the motion that a viewer would show.
#include <gtest/gtest.h>

#include <random>

#include "sdk/avatar/rig.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/glb_builder.h"
#include "sdk/motion/clip.h"
#include "sdk/motion/motion.h"
#include "sdk/motion/retarget.h"
#include "tests/package/tiny_avatar.h"
#include "tests/unit/avatar/rigs.h"

namespace dpl {
namespace {

using test::jointOf;
using test::personRig;

constexpr float kArmatureScale = 0.01f;

Json xyzw(const Quatf& q) {
    return {q.x, q.y, q.z, q.w};
}
Json xyz(const Vec3f& v) {
    return {v.x, v.y, v.z};
}

/** personRig as glTF nodes. Every joint has a random rest rotation; an armature above converts z-up centimetres to y-up metres. Two keys:
 *  rest; and the left elbow bent by `bend` (in axes parallel to the world at rest) with the pelvis moved by 0.5 m along z. */
std::vector<uint8_t> rolledGlb(const std::vector<JointData>& rig, const Quatf& bend) {
    std::mt19937 random(7);
    std::normal_distribution<float> normal;
    const Quatf armature = glm::angleAxis(-glm::half_pi<float>(), Vec3f(1, 0, 0));
    std::vector<Quatf> world;
    for (size_t j = 0; j < rig.size(); ++j)
        world.push_back(glm::normalize(Quatf(normal(random), normal(random), normal(random), normal(random))));
    GlbBuilder glb;
    glb.root = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", {0}}}}}};
    Json nodes = Json::array();
    nodes.push_back({{"name", "Armature"},
                     {"rotation", xyzw(armature)},
                     {"scale", {kArmatureScale, kArmatureScale, kArmatureScale}},
                     {"children", Json::array()}});
    const size_t elbow = jointOf(rig, "leftLowerArm");
    Json channels = Json::array(), samplers = Json::array();
    const uint32_t times =
        (glb.addAccessor(glb.addView(std::vector<float>{0, 1}), kGltfF32, "SCALAR", 2).update({{"min", {0}}, {"max", {1}}}),
         glb.lastAccessor());
    const auto animate = [&](size_t joint, const char* path, const std::vector<float>& values, const char* type) {
        glb.addAccessor(glb.addView(values), kGltfF32, type, 2);
        samplers.push_back({{"input", times}, {"output", glb.lastAccessor()}});
        channels.push_back({{"sampler", samplers.size() - 1}, {"target", {{"node", joint + 1}, {"path", path}}}});
    };
    for (size_t j = 0; j < rig.size(); ++j) {
        const int32_t parent = rig[j].parent;
        const Quatf above = parent < 0 ? armature : world[size_t(parent)];
        const Vec3f offset = (rig[j].restPosition - (parent < 0 ? Vec3f(0) : rig[size_t(parent)].restPosition)) / kArmatureScale;
        const Vec3f local = glm::conjugate(above) * offset;
        const Quatf rest = glm::conjugate(above) * world[j];
        nodes.push_back({{"name", rig[j].name}, {"translation", xyz(local)}, {"rotation", xyzw(rest)}, {"children", Json::array()}});
        nodes[size_t(parent + 1)]["children"].push_back(j + 1);
        if (j == 0) {
            const Vec3f moved = local + glm::conjugate(above) * Vec3f(0, 0, 0.5f / kArmatureScale);
            animate(0, "translation", {local.x, local.y, local.z, moved.x, moved.y, moved.z}, "VEC3");
        }
        if (j == elbow) {
            const Quatf bent = glm::conjugate(above) * bend * world[j];
            animate(j, "rotation", {rest.x, rest.y, rest.z, rest.w, bent.x, bent.y, bent.z, bent.w}, "VEC4");
        }
    }
    for (Json& node : nodes)
        if (node["children"].empty()) node.erase("children");
    glb.root["nodes"] = nodes;
    glb.root["animations"] = {{{"name", "bend"}, {"samplers", samplers}, {"channels", channels}}};
    return glb.finish([](std::string&, std::span<const uint8_t>) {});
}

TEST(GltfMotion, rolledJointsUnderAScaledArmatureMoveAsShown) {
    const auto rig = personRig(0.8f);
    const Quatf bend = glm::angleAxis(1.0f, glm::normalize(Vec3f(0.2f, -1, 0.3f)));
    const auto bytes = rolledGlb(rig, bend);
    const auto motion = readMotion(bytes, "rolled.glb");
    ASSERT_TRUE(motion) << motion.error().message;
    ASSERT_EQ(motion->joints.size(), rig.size() + 1) << "the armature is a joint too";
    ASSERT_EQ(motion->keyCount(), 2u);
    std::vector<Quatf> rotations;
    std::vector<Vec3f> positions;
    motionAt(*motion, 0, rotations, positions);
    const auto at = [&](const std::string& name) {  // the reader may use any order with parents first
        for (size_t j = 0; j < motion->joints.size(); ++j)
            if (motion->joints[j].name == name) return positions[j];
        ADD_FAILURE() << name;
        return Vec3f(1e9f);
    };
    for (const JointData& joint : rig) EXPECT_LT(glm::length(at(joint.name) - joint.restPosition), 1e-4f) << joint.name;
    motionAt(*motion, 1, rotations, positions);
    const size_t elbow = jointOf(rig, "leftLowerArm"), hand = jointOf(rig, "leftHand");
    const Vec3f expected = rig[elbow].restPosition + bend * (rig[hand].restPosition - rig[elbow].restPosition) + Vec3f(0, 0, 0.5f);
    EXPECT_LT(glm::length(at(rig[hand].name) - expected), 1e-4f) << "float rounding through 100-fold scales";

    const auto clip = retarget(*motion, rig);
    ASSERT_TRUE(clip) << clip.error().message;
    const Pose pose = samplePose(*clip, rig, 1.0);
    EXPECT_GT(std::abs(glm::dot(pose.localRotations[elbow], bend)), 0.99999f) << "the same rig gets the same turn back";
    EXPECT_NEAR(pose.rootTranslation.z, 0.5f, 1e-3f);
}

TEST(GltfMotion, anAvatarsOwnFileIsAMotion) {
    AvatarData avatar = test::tinyAvatar();
    sortSplats(avatar);
    const auto bytes = writeAvatar(avatar);
    ASSERT_TRUE(bytes) << bytes.error().message;
    const auto motion = readGltfMotion(*bytes, "tiny.glb");
    ASSERT_TRUE(motion) << motion.error().message;
    EXPECT_EQ(motion->name, "turn");
    EXPECT_FLOAT_EQ(motion->timesS.back(), 1.0f);
    const auto none = readGltfMotion(*bytes, "tiny.glb", {{}, 5});
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().code, Code::NotFound);
    EXPECT_NE(none.error().message.find("'turn'"), std::string::npos) << none.error().message;
}

TEST(GltfMotion, truncationsAreErrors) {
    const auto bytes = rolledGlb(personRig(0), Quatf(1, 0, 0, 0));
    for (size_t size = 0; size < bytes.size(); size += 101) EXPECT_FALSE(readMotion(std::span(bytes).first(size), "cut.glb"));
}

}  // namespace
}  // namespace dpl
