// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/clothed_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "sdk/core/files.h"
#include "tests/unit/format/sample_avatars.h"

namespace dpl::test {
namespace {

struct ClothedFile : testing::Test {
    const AvatarData avatar = layeredAvatar(5, 0);
    const ClothedMesh clothed{avatar.mesh, std::vector<uint8_t>(avatar.mesh.triangles.size(), 3)};
    const std::filesystem::path path = std::filesystem::temp_directory_path() / ("doppel_clothed_" + std::to_string(::getpid()));
    void TearDown() override { std::filesystem::remove(path); }
};

TEST_F(ClothedFile, givesBackTheLayers) {
    ASSERT_GT(avatar.mesh.layers.size(), 1u);
    ASSERT_TRUE(writeClothedFile(clothed, path));
    const auto back = readClothedFile(path, avatar.joints.size());
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->mesh.restPositions, avatar.mesh.restPositions);
    EXPECT_EQ(back->mesh.triangles, avatar.mesh.triangles);
    EXPECT_EQ(back->mesh.jointWeights, avatar.mesh.jointWeights);
    EXPECT_EQ(back->triangleLabel, clothed.triangleLabel);
    ASSERT_EQ(back->mesh.layers.size(), avatar.mesh.layers.size());
    for (size_t i = 0; i < avatar.mesh.layers.size(); ++i) {
        EXPECT_EQ(back->mesh.layers[i].name, avatar.mesh.layers[i].name);
        EXPECT_EQ(back->mesh.layers[i].role, avatar.mesh.layers[i].role);
        EXPECT_EQ(back->mesh.layers[i].firstTriangle, avatar.mesh.layers[i].firstTriangle);
        EXPECT_EQ(back->mesh.layers[i].vertexCount, avatar.mesh.layers[i].vertexCount);
    }
}

TEST_F(ClothedFile, refusesEveryCutOfItselfAndNamesTheFile) {
    ASSERT_TRUE(writeClothedFile(clothed, path));
    const std::vector<uint8_t> whole = *readFile(path);
    for (size_t size = 0; size < whole.size(); size += 1 + whole.size() / 97) {
        ASSERT_TRUE(writeFileAtomically(path, std::span(whole).first(size)));
        const auto back = readClothedFile(path, avatar.joints.size());
        ASSERT_FALSE(back) << size << " of " << whole.size() << " bytes";
        EXPECT_NE(back.error().message.find(path.string()), std::string::npos) << back.error().message;
    }
}

TEST_F(ClothedFile, refusesAnotherRig) {
    ASSERT_TRUE(writeClothedFile(clothed, path));
    EXPECT_FALSE(readClothedFile(path, 1));
}

TEST_F(ClothedFile, refusesLayersThatDoNotTile) {
    ClothedMesh wrong = clothed;
    wrong.mesh.layers.back().triangleCount -= 1;
    ASSERT_TRUE(writeClothedFile(wrong, path));
    EXPECT_FALSE(readClothedFile(path, avatar.joints.size()));
}

TEST_F(ClothedFile, refusesLabelsThatDoNotFit) {
    ClothedMesh wrong = clothed;
    wrong.triangleLabel.pop_back();
    ASSERT_TRUE(writeClothedFile(wrong, path));
    const auto back = readClothedFile(path, avatar.joints.size());
    ASSERT_FALSE(back);
    EXPECT_NE(back.error().message.find("labels"), std::string::npos) << back.error().message;
}

}  // namespace
}  // namespace dpl::test
