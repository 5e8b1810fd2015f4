// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/trainable.h"

#include <gtest/gtest.h>

#include <random>

#include "reconstruction/training/trainer/adam.h"
#include "reconstruction/training/trainer/regularisers.h"
#include "tests/gradient/splat/finite_difference.h"

namespace dpl {
namespace {

TEST(Simplex, insideStaysOutsideGoesToTheNearestPoint) {
    EXPECT_EQ(projectToSimplex({0.2f, 0.3f}), Vec2f(0.2f, 0.3f));
    std::mt19937 random(1);
    std::uniform_real_distribution<float> wide(-1.5f, 2.0f), u01(0, 1);
    for (int k = 0; k < 200; ++k) {
        const Vec2f p(wide(random), wide(random)), q = projectToSimplex(p);
        ASSERT_GE(q.x, 0);
        ASSERT_GE(q.y, 0);
        ASSERT_LE(q.x + q.y, 1 + 1e-6f);
        EXPECT_EQ(projectToSimplex(q), q) << "idempotent: a restored run must not move";
        const auto distance = [&](Vec2f o) {  // between barycentric triples
            const Vec3f a(1 - p.x - p.y, p.x, p.y), b(1 - o.x - o.y, o.x, o.y);
            return glm::length(a - b);
        };
        for (int j = 0; j < 50; ++j) {
            Vec2f o(u01(random), u01(random));
            if (o.x + o.y > 1) o = Vec2f(1) - o;
            EXPECT_LE(distance(q), distance(o) + 1e-5f);
        }
    }
}

TEST(TrainableSplats, roundTripThroughAvatarSplatsKeepsTheFloor) {
    SplatData s;
    s.triangleStart = {0, 1, 3};
    s.uv = {{0.2f, 0.3f}, {0.5f, 0.1f}, {0.1f, 0.8f}};
    s.phi = {0.1f, 1.0f, 2.0f};
    s.scaleM = {{0.01f, 0.004f}, {0.002f, 0.001f}, {0.02f, 0.02f}};
    s.opacity = {0.9f, 0.5f, 0.02f};
    s.flags = {0, kSplatSingleFace, kSplatCloth};
    s.sh.assign(9, 0.25f);
    Jobs jobs(1);
    const float floors[2] = {0.003f, 0.0015f};
    TrainableSplats t = TrainableSplats::fromSplatData(s, floors);
    t.activateAll(jobs);
    const SplatData back = t.toSplatData();
    EXPECT_EQ(back.uv, s.uv);
    EXPECT_NEAR(back.scaleM[0].x, 0.01f, 1e-6f);
    EXPECT_NEAR(back.scaleM[1].y, 0.0015f, 3e-5f) << "below its floor: the floor";
    EXPECT_NEAR(back.opacity[1], 0.5f, 1e-6f);
    EXPECT_EQ(t.triangle, (std::vector<uint32_t>{0, 1, 1}));
}

TEST(Adam, rowsWithoutGradientStayAndStepsAreBounded) {
    AdamRows adam;
    adam.resize(3, 8);
    std::vector<float> values(24, 1.0f), gradients(24, 1e-7f);
    const std::vector<float> rate(8, 0.01f);
    const std::vector<uint8_t> active{1, 0, 1};
    adam.update(0, 3, active, gradients, rate, values);
    EXPECT_NEAR(values[0], 0.99f, 1e-6f) << "the first step is the rate whatever the gradient's size";
    EXPECT_EQ(values[8], 1.0f);
    EXPECT_EQ(adam.steps[1], 0u);
}

TEST(Adam, uniformKeepsTheDirection) {
    AdamUniform adam;
    std::vector<Vec3f> value(2, Vec3f(0));
    adam.update(std::vector<Vec3f>{{4, 2, 0}, {1, 0, -1}}, 0.1f, value);
    EXPECT_NEAR(value[0].x, -0.1f, 1e-6f);
    EXPECT_NEAR(value[0].y, -0.05f, 1e-6f);
    EXPECT_NEAR(value[1].x, -0.025f, 1e-6f);
    EXPECT_NEAR(value[1].z, 0.025f, 1e-6f);
}

TEST(Regularisers, splatGradientIsTheDerivativeOfTheValue) {
    TrainableSplats t;
    t.resize(4, 0);
    t.triangle = {0, 0, 1, 1};
    t.sizeFloorM = {0.002f, 0.0f};
    t.indexTriangles(2);
    const float logs[4][2] = {{-4.0f, -6.8f}, {-3.0f, -3.2f}, {-6.5f, -3.5f}, {-5.5f, -5.6f}};
    for (uint32_t i = 0; i < 4; ++i) t.rows[i * t.stride + kRowLogScale1] = logs[i][0], t.rows[i * t.stride + kRowLogScale2] = logs[i][1];
    t.activate(0, 4);
    const std::vector<float> size{0.01f, 0.012f};
    const std::vector<uint8_t> active(4, 1);
    const RegulariserWeights w;
    std::vector<float> rows(4 * t.stride, 0.0f);
    addSplatRegularisers(t, size, active, w, 0, 4, rows);
    std::vector<double> x, analytic;
    for (uint32_t i = 0; i < 4; ++i)
        for (uint32_t k = 0; k < 2; ++k) x.push_back(logs[i][k]), analytic.push_back(rows[i * t.stride + kRowLogScale1 + k]);
    const auto numeric = test::differences(
        x,
        [&](const auto& y) {
            TrainableSplats m = t;
            for (uint32_t i = 0; i < 8; ++i) m.rows[i / 2 * t.stride + kRowLogScale1 + i % 2] = float(y[i]);
            m.activate(0, 4);
            return splatRegulariserValue(m, size, active, w);
        },
        1e-3);
    test::expectGradients(analytic, numeric, 5e-3, "log scales");  // rounding of float values at a step of 1e-3
}

TEST(Regularisers, meshGradientIsTheDerivativeOfTheValue) {
    const std::vector<Vec3f> rest{{0, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}, {0.1f, 0.1f, 0.02f}};
    const std::vector<Triangle> triangles{{0, 1, 2}, {1, 3, 2}};
    const MeshRegulariser r(rest, triangles);
    std::vector<double> x;
    for (const Vec3f& p : rest) x.insert(x.end(), {p.x * 1.9, p.y * 0.3 + 0.01, p.z + 0.03 * p.x});
    RegulariserWeights w;
    w.edgeRatio = 1, w.laplacian = 1;
    const auto place = [](const std::vector<double>& y) {
        std::vector<Vec3f> p;
        for (size_t i = 0; i < y.size(); i += 3) p.push_back(Vec3f(y[i], y[i + 1], y[i + 2]));
        return p;
    };
    std::vector<Vec3f> g(4, Vec3f(0));
    EXPECT_GT(r.run(place(x), w, 1, g), 0);
    const auto numeric = test::differences(
        x, [&](const auto& y) { return r.run(place(y), w, 1, {}); }, 1e-4);
    std::vector<double> analytic;
    for (const Vec3f& v : g) analytic.insert(analytic.end(), {v.x, v.y, v.z});
    test::expectGradients(analytic, numeric, 5e-3, "vertices");  // rounding of float positions at a step of 1e-4
    EXPECT_EQ(r.run(rest, w, 1, {}), 0);
}

}  // namespace
}  // namespace dpl
