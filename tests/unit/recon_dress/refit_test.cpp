// SPDX-License-Identifier: Apache-2.0
// Open half spheres as garments on a sphere as the body: pushed out of it and to the right side of each other, and still smooth.
#include "reconstruction/output/dress/refit.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace dpl {
namespace {

constexpr float kBodyRadiusM = 0.2f;

SurfaceMesh sphere(float radius) {
    SampleGrid grid;
    for (auto* axis : {&grid.xs, &grid.ys, &grid.zs}) appendSamples(*axis, -0.3f, 0.3f, 0.02f);
    const auto field = [&](const Vec3f& p) { return glm::length(p) - radius; };
    Jobs jobs(1);
    return remesh(marchField(field, grid, jobs), field, {[](const Vec3f&) { return 0.02f; }, 3}, jobs);
}

SurfaceMesh upperHalf(float radius) {
    SurfaceMesh whole = sphere(radius);
    std::erase_if(whole.triangles, [&](const Triangle& t) { return whole.positions[t.x].y < 0; });
    return withoutUnused(whole);
}

struct Pushed {
    float low = 1e9f, high = 0;  // distance from the centre, metres
    float roughestM = 0;         // difference of that distance along an edge
    uint32_t inside = 0;
};

Pushed push(SurfaceMesh garment, std::vector<GarmentCover> below, std::vector<GarmentCover> above, bool tucked) {
    const SurfaceMesh body = sphere(kBodyRadiusM);
    const ClosestSurface surface(body.positions, body.triangles);
    const size_t count = garment.positions.size();
    const Obstacles obstacles{surface, std::move(below), std::move(above), std::vector<uint8_t>(count, tucked)};
    const auto inside = pushOut(obstacles, std::vector<float>(count, 0.004f), garment);
    EXPECT_TRUE(bool(inside));
    Pushed out;
    out.inside = inside ? *inside : UINT32_MAX;
    for (const Vec3f& p : garment.positions) out.low = std::min(out.low, glm::length(p)), out.high = std::max(out.high, glm::length(p));
    for (const Triangle& t : garment.triangles)
        for (int k = 0; k < 3; ++k) {
            const float step = glm::length(garment.positions[t[k]]) - glm::length(garment.positions[t[(k + 1) % 3]]);
            out.roughestM = std::max(out.roughestM, std::abs(step));
        }
    return out;
}

TEST(PushOut, aGarmentInsideTheBodyComesOutAndStaysSmooth) {
    SurfaceMesh garment = upperHalf(kBodyRadiusM + 0.01f);
    for (Vec3f& p : garment.positions)
        if (p.x > 0) p *= 1 - 0.15f * p.x / kBodyRadiusM;  // one side sinks in, by up to 3 cm
    const Pushed out = push(garment, {}, {}, false);
    EXPECT_EQ(out.inside, 0u);
    EXPECT_GT(out.low, kBodyRadiusM + 0.003f);  // the body's flat triangles lie up to 0.3 mm inside its sphere
    EXPECT_LT(out.high, kBodyRadiusM + 0.02f);
    EXPECT_LT(out.roughestM, 0.004f);
}

TEST(PushOut, garmentsTakeTheirSideOfOthers) {
    const std::vector<GarmentCover> other{GarmentCover(upperHalf(kBodyRadiusM + 0.02f))};
    const Pushed over = push(upperHalf(kBodyRadiusM + 0.015f), other, {}, false);
    EXPECT_GT(over.high, kBodyRadiusM + 0.022f);
    const Pushed under = push(upperHalf(kBodyRadiusM + 0.025f), {}, other, false);
    EXPECT_LT(under.low, kBodyRadiusM + 0.018f);
    EXPECT_EQ(under.inside, 0u);
    const Pushed tucked = push(upperHalf(kBodyRadiusM + 0.015f), other, {}, true);
    EXPECT_LT(tucked.high, kBodyRadiusM + 0.016f);
}

TEST(PushOut, theBodyComesBeforeAGarmentThatIsTooTight) {
    const std::vector<GarmentCover> tight{GarmentCover(upperHalf(kBodyRadiusM + 0.001f))};
    const Pushed out = push(upperHalf(kBodyRadiusM + 0.01f), {}, tight, false);
    EXPECT_EQ(out.inside, 0u);
    EXPECT_GT(out.low, kBodyRadiusM + 0.003f);
}

}  // namespace
}  // namespace dpl
