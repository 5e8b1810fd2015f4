// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/limb.h"

#include <gtest/gtest.h>

namespace dpl {
namespace {

using Limb = std::array<Vec3f, 3>;

Limb moved(const Limb& at, const std::array<Quatf, 2>& turns) {
    const Vec3f middle = at[0] + turns[0] * (at[1] - at[0]);
    return {at[0], middle, middle + turns[1] * (at[2] - at[1])};
}

TEST(Limb, reachesEveryTargetWithinItsLengthAndKeepsThePlaneOfItsBend) {
    const Limb leg = {Vec3f(0.1f, 0.9f, 0), Vec3f(0.12f, 0.5f, 0.08f), Vec3f(0.1f, 0.1f, -0.02f)};
    for (const Vec3f& by : {Vec3f(0, 0.1f, 0), Vec3f(0.05f, 0.02f, -0.1f), Vec3f(-0.03f, 0, 0.15f), Vec3f(0)}) {
        const Limb now = moved(leg, reachWith(leg, leg[2] + by, {0, 0, 1}));
        EXPECT_LT(glm::length(now[2] - (leg[2] + by)), 1e-5f);
        EXPECT_NEAR(glm::length(now[1] - now[0]), glm::length(leg[1] - leg[0]), 1e-5f);
        EXPECT_GT(now[1].z - 0.5f * (now[0].z + now[2].z), 0.0f) << "the knee stays in front";
    }
}

TEST(Limb, aStraightLimbBendsToTheSideThatIsAskedFor) {
    const Limb leg = {Vec3f(0, 0.8f, 0), Vec3f(0, 0.4f, 0), Vec3f(0, 0, 0)};
    const Limb now = moved(leg, reachWith(leg, {0, 0.1f, 0}, {0, 0, 1}));
    EXPECT_LT(glm::length(now[2] - Vec3f(0, 0.1f, 0)), 1e-5f);
    EXPECT_GT(now[1].z, 0.1f);
}

TEST(Limb, pointsAtWhatIsOutOfReachAndStandsStillWithoutLength) {
    const Limb leg = {Vec3f(0, 0.8f, 0), Vec3f(0, 0.4f, 0.01f), Vec3f(0, 0, 0)};
    const Limb now = moved(leg, reachWith(leg, {0, -5, 0}, {0, 0, 1}));
    EXPECT_NEAR(now[2].y, 0, 1e-3);
    EXPECT_NEAR(now[2].x, 0, 1e-5);
    for (const Quatf& q : reachWith({Vec3f(0), Vec3f(0), Vec3f(0)}, {1, 1, 1}, {0, 0, 1})) EXPECT_EQ(q, Quatf(1, 0, 0, 0));
    for (const Quatf& q : reachWith(leg, leg[0], {0, 0, 1})) EXPECT_EQ(q, Quatf(1, 0, 0, 0));
}

}  // namespace
}  // namespace dpl
