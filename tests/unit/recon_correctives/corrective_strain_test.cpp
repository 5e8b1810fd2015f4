// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/correctives/corrective_strain.h"

#include <gtest/gtest.h>

#include "tests/unit/format/sample_avatars.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl::test {
namespace {

/** A small avatar with `value` at every node and mode; if `alternating`, negated at every other node. */
AvatarData withNodes(const Vec4f& value, bool alternating) {
    AvatarData avatar = withCorrectives(layeredAvatar(3, 0), 4);
    for (size_t e = 0; e < avatar.correctives.nodes.size(); ++e)
        avatar.correctives.nodes[e] = alternating && (e / avatar.correctives.modeCount) % 2 ? -value : value;
    return avatar;
}

TEST(CorrectiveStrain, nothingWithoutCorrectives) {
    Jobs jobs(1);
    const CorrectiveStrain stress = correctiveStrain(layeredAvatar(3, 0), jobs);
    EXPECT_EQ(stress.offsetMm, 0);
    EXPECT_EQ(stress.strainPercent, 0);
    EXPECT_EQ(stress.lightPercent, 0);
}

TEST(CorrectiveStrain, oneOffsetEverywhereMovesAndDoesNotStrain) {
    Jobs jobs(1);
    const CorrectiveStrain even = correctiveStrain(withNodes({0.01f, 0, 0, 0.1f}, false), jobs),
                           torn = correctiveStrain(withNodes({0.01f, 0, 0, 0.1f}, true), jobs);
    EXPECT_GT(even.offsetMm, 5);
    EXPECT_LT(even.strainPercent, 1e-2);
    EXPECT_NEAR(even.lightPercent, even.offsetMm, 1e-2 * even.offsetMm) << "10 % of brightness with every 10 mm";
    EXPECT_GT(torn.strainPercent, 10 * even.strainPercent + 1);
}

TEST(CorrectiveStrain, growsWithTheValuesOfTheNodes) {
    Jobs jobs(2);
    const CorrectiveStrain one = correctiveStrain(withNodes({0, 0.01f, 0, 0.05f}, true), jobs),
                           two = correctiveStrain(withNodes({0, 0.02f, 0, 0.1f}, true), jobs);
    EXPECT_NEAR(two.offsetMm, 2 * one.offsetMm, 1e-3 * two.offsetMm);
    EXPECT_NEAR(two.strainPercent, 2 * one.strainPercent, 1e-3 * two.strainPercent);
}

}  // namespace
}  // namespace dpl::test
