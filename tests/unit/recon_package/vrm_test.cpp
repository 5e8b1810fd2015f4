// SPDX-License-Identifier: Apache-2.0
// The exported VRM: a person in a T-pose whose joints are named, that only its author may use.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <map>

#include "reconstruction/output/package/export_mesh.h"
#include "reconstruction/subject/sample/sample_avatar.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/skinned_gltf.h"
#include "tests/unit/format/glb_parts.h"

namespace dpl {
namespace {

class Vrm : public testing::Test {
protected:
    static void SetUpTestSuite() {
        Jobs jobs;
        avatar_ = makeSampleAvatar(makeSubject(1, jobs), jobs);
    }
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() / ("doppel_vrm_" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }
    Result<std::string> write(const AvatarData& avatar) {
        EXPECT_TRUE(bool(writeFileAtomically(folder_ / "avatar.glb", *writeAvatar(avatar))));
        return exportMesh(
            {.avatar = folder_ / "avatar.glb", .out = folder_ / "person.vrm", .texturePx = 256, .vrmAuthor = std::string("Ada Byron")});
    }

    static AvatarData avatar_;
    std::filesystem::path folder_;
};
AvatarData Vrm::avatar_;

TEST_F(Vrm, standsInATPoseWithItsBonesNamed) {
    const auto line = write(avatar_);
    ASSERT_TRUE(line) << line.error().message;
    const auto bytes = *readFile(folder_ / "person.vrm", 1u << 26);
    const auto read = readSkinnedGltf(bytes);
    ASSERT_TRUE(read) << read.error().message;
    const std::vector<Mat4f> sceneFromNode = read->restTransforms();
    std::map<std::string, Vec3f> at;
    for (size_t n = 0; n < read->nodes.size(); ++n)
        if (const std::string& bone = read->nodes[n].humanoidBone; !bone.empty()) at[bone] = Vec3f(sceneFromNode[n][3]);
    for (const char* bone : {"hips", "spine", "head", "leftFoot", "rightFoot", "leftHand", "rightHand", "leftIndexProximal"})
        EXPECT_TRUE(at.contains(bone)) << bone;
    for (const auto& [side, sign] : {std::pair{std::string("left"), 1.0f}, {std::string("right"), -1.0f}})
        for (const auto& [from, to] : {std::pair{"UpperArm", "LowerArm"}, {"LowerArm", "Hand"}, {"Hand", "MiddleProximal"}}) {
            const Vec3f along = glm::normalize(at[side + to] - at[side + from]);
            EXPECT_GT(along.x * sign, 0.9999f) << side << from;  // joints are on a lattice of 15 µm
        }
    EXPECT_TRUE(read->animations.empty()) << "clips are of the other pose at rest";

    // The mesh follows: nothing of it is farther out than the longest finger, and no hand hangs at the hips.
    float widest = 0, reach = 0;
    for (const auto& [bone, place] : at) reach = std::max(reach, std::abs(place.x));
    for (const SkinnedGltf::Mesh& mesh : read->meshes)
        for (const Vec3f& p : mesh.positions) {
            widest = std::max(widest, std::abs(p.x));
            if (std::abs(p.x) > 0.4f) {
                EXPECT_NEAR(p.y, at["leftHand"].y, 0.15f) << p.x;
            }
        }
    EXPECT_GT(widest, reach);
    EXPECT_LT(widest, reach + 0.05f);
}

TEST_F(Vrm, allowsNothingAndNamesItsAuthor) {
    ASSERT_TRUE(write(avatar_));
    const auto json = test::split(*readFile(folder_ / "person.vrm", 1u << 26)).json;
    const auto& vrm = json["extensions"]["VRMC_vrm"];
    EXPECT_EQ(vrm["specVersion"], "1.0");
    const auto& meta = vrm["meta"];
    EXPECT_EQ(meta["authors"], nlohmann::json::array({"Ada Byron"}));
    EXPECT_EQ(meta["licenseUrl"], "https://vrm.dev/licenses/1.0/");
    EXPECT_EQ(meta["avatarPermission"], "onlyAuthor");
    EXPECT_EQ(meta["commercialUsage"], "personalNonProfit");
    EXPECT_EQ(meta["creditNotation"], "required");
    EXPECT_EQ(meta["modification"], "prohibited");
    for (const char* forbidden : {"allowExcessivelyViolentUsage", "allowExcessivelySexualUsage", "allowPoliticalOrReligiousUsage",
                                  "allowAntisocialOrHateUsage", "allowRedistribution"})
        EXPECT_EQ(meta[forbidden], false) << forbidden;
    EXPECT_EQ(vrm["firstPerson"]["meshAnnotations"].size(), json["meshes"].size());
    for (const auto& annotation : vrm["firstPerson"]["meshAnnotations"])
        EXPECT_TRUE(json["nodes"][annotation["node"].get<size_t>()].contains("mesh"));
}

TEST_F(Vrm, aSkeletonWithoutABoneThatItDemandsEndsInASentence) {
    AvatarData lame = avatar_;
    for (JointData& joint : lame.joints)
        if (joint.humanoidBone == "leftHand") joint.humanoidBone.clear();
    const auto line = write(lame);
    ASSERT_FALSE(line);
    EXPECT_NE(line.error().message.find("no bone 'leftHand', which VRM demands"), std::string::npos) << line.error().message;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "person.vrm"));
}

TEST(WrongMeshExport, saysWhyAVrmCannotBe) {
    const MeshExportOptions good = {.avatar = "a.glb", .out = "a.vrm", .vrmAuthor = std::string("Ada")};
    EXPECT_EQ(wrongMeshExport(good), "");
    const auto with = [&](auto change) {
        MeshExportOptions options = good;
        change(options);
        return wrongMeshExport(options);
    };
    EXPECT_NE(with([](auto& o) { o.out = "a.glb"; }).find("with --vrm the file must end in .vrm"), std::string::npos);
    EXPECT_NE(with([](auto& o) { o.vrmAuthor.reset(); }).find("the file must end in .glb"), std::string::npos);
    EXPECT_NE(with([](auto& o) { o.vrmAuthor = ""; }).find("--author"), std::string::npos);
    EXPECT_NE(with([](auto& o) { o.clip = "walk"; }).find("--clip"), std::string::npos);
    EXPECT_NE(with([](auto& o) { o.compression = "draco"; }).find("--compress"), std::string::npos);
}

}  // namespace
}  // namespace dpl
