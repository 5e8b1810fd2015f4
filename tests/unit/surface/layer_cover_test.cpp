// SPDX-License-Identifier: Apache-2.0
#include "sdk/surface/layer_cover.h"

#include <gtest/gtest.h>

#include "tests/unit/surface/dressed.h"

namespace dpl::test {
namespace {

class LayerCoverTest : public ::testing::Test {
protected:
    LayerCover below(DressedLayer layer, std::initializer_list<DressedLayer> hidden = {}) const {
        std::vector<uint8_t> leftOut(avatar_.mesh.triangles.size(), 0), carries;
        for (const DressedLayer h : hidden)
            std::fill_n(leftOut.begin() + avatar_.mesh.layers[h].firstTriangle, avatar_.mesh.layers[h].triangleCount, uint8_t(1));
        for (size_t t = 0; t < avatar_.mesh.triangles.size(); ++t)
            carries.push_back(avatar_.splats.triangleStart[t + 1] > avatar_.splats.triangleStart[t]);
        return coverBelow(avatar_.mesh, layer, carries, leftOut);
    }
    const AvatarData avatar_ = dressed();
};

TEST_F(LayerCoverTest, measuresWhatWouldShow) {
    EXPECT_NEAR(below(kTop).shownM2, 0.5, 1e-6);
    EXPECT_EQ(below(kTop).bareM2, 0);
    EXPECT_NEAR(below(kSkirt).shownM2, 0.5, 1e-6);
    EXPECT_GT(below(kSkirt).bareM2, 0.2);  // a square beside one with splats counts as covered
    EXPECT_EQ(below(kScarf).shownM2, 0);
}

TEST_F(LayerCoverTest, looksAtTheNextLayerThatIsThere) {
    EXPECT_NEAR(below(kCoat).shownM2, 1, 1e-6);
    EXPECT_EQ(below(kCoat).bareM2, 0);
    EXPECT_GT(below(kCoat, {kSkirt}).bareM2, 0.2);
    EXPECT_EQ(below(kCoat, {kBody, kTop, kSkirt}).shownM2, 0);
}

TEST_F(LayerCoverTest, doesNotTakeTheInsideOfALayerForWhatLiesBelow) {
    EXPECT_EQ(below(kBody).shownM2, 0);
    AvatarData turned = dressed();
    for (size_t t = 0; t < 32; ++t) std::swap(turned.mesh.triangles[t].y, turned.mesh.triangles[t].z);  // the body faces away
    const std::vector<uint8_t> carries(turned.mesh.triangles.size(), 1);
    EXPECT_EQ(coverBelow(turned.mesh, kTop, carries, {}).shownM2, 0);
}

}  // namespace
}  // namespace dpl::test
