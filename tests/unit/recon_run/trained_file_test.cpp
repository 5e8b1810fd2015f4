// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/trained_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/unit/format/sample_avatars.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl::test {
namespace {

TEST(TrainedFile, givesBackWhatWasTrained) {
    const AvatarData avatar = withCorrectives(layeredAvatar(5, 1), 6, {.reach = 2.5f, .reachOffModes = 0.3f});
    CoOptimiseResult trained;
    trained.splats = avatar.splats, trained.restPositions = avatar.mesh.restPositions, trained.correctives = avatar.correctives;
    trained.poses = {Pose::rest(avatar.joints.size()), Pose::rest(avatar.joints.size())};
    trained.poses[1].rootTranslation = {1, 2, 3};
    trained.curve = {{10, 0.5f, 0.1f, 0.2f, 0.3f, 21, 900}};
    trained.framesUsed = 2;
    const auto path = std::filesystem::temp_directory_path() / ("doppel_trained_" + std::to_string(::getpid()));
    ASSERT_TRUE(writeTrainedFile(trained, path));
    const auto back = readTrainedFile(path, avatar.mesh.triangles.size(), avatar.mesh.restPositions.size(), avatar.joints.size());
    std::filesystem::remove(path);
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->splats.uv, trained.splats.uv);
    EXPECT_EQ(back->splats.sh, trained.splats.sh);
    EXPECT_EQ(back->restPositions, trained.restPositions);
    const PoseCorrectiveData &a = back->correctives, &b = trained.correctives;
    EXPECT_EQ(a.joints, b.joints);
    EXPECT_EQ(a.modes, b.modes);
    EXPECT_EQ(a.nodes, b.nodes);
    EXPECT_EQ(a.reach, b.reach);
    EXPECT_EQ(a.reachOffModes, b.reachOffModes);
    ASSERT_EQ(back->poses.size(), 2u);
    EXPECT_EQ(back->poses[1].rootTranslation, Vec3f(1, 2, 3));
    ASSERT_EQ(back->curve.size(), 1u);
    EXPECT_EQ(back->curve[0].psnr, 21);
}

TEST(TrainedFile, refusesAnotherSubjectsFile) {
    const AvatarData avatar = layeredAvatar(5, 0);
    CoOptimiseResult trained;
    trained.splats = avatar.splats, trained.restPositions = avatar.mesh.restPositions;
    const auto path = std::filesystem::temp_directory_path() / ("doppel_trained_" + std::to_string(::getpid()));
    ASSERT_TRUE(writeTrainedFile(trained, path));
    EXPECT_FALSE(readTrainedFile(path, avatar.mesh.triangles.size(), avatar.mesh.restPositions.size() + 1, avatar.joints.size()));
    std::filesystem::remove(path);
}

}  // namespace
}  // namespace dpl::test
