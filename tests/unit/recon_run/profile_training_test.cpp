// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/profile_training.h"

#include <gtest/gtest.h>

#include "tests/unit/must.h"

namespace dpl::test {
namespace {

ProfiledTraining profiled(uint32_t threads, const ProfiledSteps& steps) {
    ReconstructOptions options;
    options.threadCount = threads;
    Progress quiet(Progress::Style::Quiet);
    return must(profileTraining(options, 63, 84, steps, quiet));
}

TEST(ProfileTraining, measuresTheStepsThatItWasAskedForWithAllTheirSplats) {
    const ProfiledTraining made = profiled(2, {.warmUp = 1, .steps = 3, .splats = 4000});
    EXPECT_EQ(made.profile.steps, 3u);
    EXPECT_EQ(made.frames, 12u);
    EXPECT_GE(made.splats, 4000u);  // more, because each triangle begins with at least one
    EXPECT_GT(made.profile.stepMs, 0);
    EXPECT_GT(made.profile.visible, 500) << "the subject is in the picture";
    EXPECT_GT(made.profile.pairs, made.profile.visible);
    EXPECT_GT(made.profile.pixels, 500);
    EXPECT_LE(made.profile.pixels, 63 * 84);
    EXPECT_GT(made.nodes, 0u);
    EXPECT_GT(made.loss, 0);
}

TEST(ProfileTraining, theLossTellsWhetherTwoProgramsComputedTheSame) {
    const ProfiledSteps steps{.warmUp = 0, .steps = 3, .splats = 4000};
    EXPECT_EQ(profiled(3, steps).loss, profiled(1, steps).loss);
}

}  // namespace
}  // namespace dpl::test
