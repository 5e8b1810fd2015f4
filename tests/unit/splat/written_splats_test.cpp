// SPDX-License-Identifier: Apache-2.0
// The rows that PosedSplatWriter writes by SIMD against PosedTriangle, one splat at a time, with every instruction set of this machine.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <random>

#include "sdk/format/splat_codec.h"
#include "sdk/splat/posed_splats.h"

namespace dpl::test {
namespace {

using Numbers = std::map<SplatNumbers, std::vector<float>>;
constexpr SplatNumbers kAll[] = {SplatNumbers::Position, SplatNumbers::Rotation, SplatNumbers::Scale, SplatNumbers::Covariance,
                                 SplatNumbers::Opacity,  SplatNumbers::Colour,   SplatNumbers::Sh,    SplatNumbers::RotationWxyz};

struct Scene {
    uint32_t shDegree = 0;
    std::vector<TriangleFrame<float>> frames;
    CodedSplats coded;
    SplatData splats;  // as decoded
};

/** Two splats a triangle; triangles look everywhere, some are gone, some splats are needles or round. */
Scene makeScene(uint32_t triangles, uint32_t shDegree) {
    Scene s;
    s.shDegree = shDegree;
    MeshData mesh;
    SplatData splats;
    splats.shDegree = shDegree, splats.triangleStart = {0};
    std::mt19937 random(5 + shDegree);
    std::normal_distribution<float> normal;
    std::uniform_real_distribution<float> uniform(0, 1);
    const auto vector = [&](float size) { return size * Vec3f(normal(random), normal(random), normal(random)); };
    for (uint32_t t = 0; t < triangles; ++t) {
        const float size = 0.03f;
        Vec3f rest[3], corners[3];
        const Vec3f centre = vector(0.5f);
        for (int k = 0; k < 3; ++k) rest[k] = vector(size), corners[k] = centre + vector(size);
        TriangleFrame<float> f = drawnTriangle(restTriangle(rest[0], rest[1], rest[2]), corners[0], corners[1], corners[2]);
        f.light = Vec3f(0.5f) + Vec3f(uniform(random), uniform(random), uniform(random));
        if (t % 13 == 0) f.valid = false;
        s.frames.push_back(f);
        for (int k = 0; k < 3; ++k) mesh.triangles.push_back({}), mesh.restPositions.push_back(rest[k]);
        mesh.triangles.resize(t + 1);
        mesh.triangles[t] = {3 * t, 3 * t + 1, 3 * t + 2};
        for (int k = 0; k < 2; ++k) {
            const float longM = 0.02f * (0.1f + uniform(random));
            splats.uv.push_back({0.5f * uniform(random), 0.5f * uniform(random)});
            splats.phi.push_back(3.1f * uniform(random));
            splats.scaleM.push_back({longM, longM * (t % 5 == 0 ? 0.01f : t % 7 == 0 ? 1.0f : 0.2f + 0.8f * uniform(random))});
            splats.opacity.push_back(0.2f + 0.8f * uniform(random));
            splats.flags.push_back(k ? kSplatSingleFace : 0);
            for (uint32_t c = 0; c < shCoefficientCount(shDegree) * 3; ++c) splats.sh.push_back(0.2f * normal(random));
        }
        splats.triangleStart.push_back(2 * t + 2);
    }
    mesh.layers = {{"body", "body", 0, uint32_t(mesh.restPositions.size()), 0, triangles}};
    auto coded = codeSplats(mesh, splats);
    EXPECT_TRUE(coded) << coded.error().message;
    s.coded = *coded;
    s.splats = decodeSplats(s.coded, triangles);
    return s;
}

struct Request {
    Placement placement;
    std::optional<Vec3f> eye;
    uint32_t shDegree = 0;
};

/** What PosedTriangle says, in the world. */
Numbers expected(const Scene& s, const Request& r) {
    Numbers out;
    const ShRotator rotator;
    const Mat3f turn(r.placement.rotation);
    for (uint32_t t = 0; t + 1 < s.splats.triangleStart.size(); ++t) {
        TriangleFrame<float> f = s.frames[t];
        const float scale = float(r.placement.scale);
        for (Vec3f* corner : {&f.v0, &f.v1, &f.v2}) *corner = Vec3f(r.placement.toWorld(Vec3d(*corner)));
        f.f0 = scale * (turn * f.f0), f.f1 = scale * (turn * f.f1), f.normal = turn * f.normal, f.worldFromRest = turn * f.worldFromRest;
        const PosedTriangle triangle(f);
        for (uint32_t i = s.splats.triangleStart[t]; i < s.splats.triangleStart[t + 1]; ++i) {
            const auto add = [&](SplatNumbers what, const float* numbers, uint32_t count) {
                out[what].insert(out[what].end(), numbers, numbers + count);
            };
            const Vec2f uv = s.splats.uv[i];
            const Vec3f centre = triangle.centre(uv);
            const auto ellipse = triangle.ellipse(Formulas<float>::planeAxes(std::cos(s.splats.phi[i]), std::sin(s.splats.phi[i]),
                                                                             s.splats.scaleM[i].x, s.splats.scaleM[i].y));
            const GaussianAxes axes = triangle.axes(ellipse);
            const Quatf q = axes.rotation;
            const float last[4] = {q.x, q.y, q.z, q.w}, first[4] = {q.w, q.x, q.y, q.z};
            float six[6], sh[48] = {};
            triangle.covariance(ellipse, six);
            const float opacity = s.splats.opacity[i] * triangle.shown(centre, (s.splats.flags[i] & kSplatSingleFace) != 0, r.eye);
            const float* own = &s.splats.sh[i * 3 * shCoefficientCount(s.shDegree)];
            Vec3f colour = shColour(own, 0, Vec3f(0), triangle.light(uv));
            if (r.eye && s.shDegree > 0)
                colour = shColour(own, s.shDegree, glm::transpose(f.worldFromRest) * glm::normalize(centre - *r.eye), triangle.light(uv));
            std::copy_n(own, 3 * shCoefficientCount(std::min(r.shDegree, s.shDegree)), sh);
            rotator.turn(f.worldFromRest, std::min(r.shDegree, s.shDegree)).apply(sh);
            foldLight(triangle.light(uv), std::min(r.shDegree, s.shDegree), sh);
            add(SplatNumbers::Position, &centre.x, 3), add(SplatNumbers::Rotation, last, 4), add(SplatNumbers::Scale, &axes.scaleM.x, 3);
            add(SplatNumbers::Covariance, six, 6), add(SplatNumbers::Opacity, &opacity, 1), add(SplatNumbers::Colour, &colour.x, 3);
            add(SplatNumbers::Sh, sh, numbersOf(SplatNumbers::Sh, r.shDegree)), add(SplatNumbers::RotationWxyz, first, 4);
        }
    }
    return out;
}

/** All columns, each an array of its own; as floats, or as halves that became floats again. */
Numbers written(const Scene& s, const Request& r, bool half, uint64_t& saturated) {
    std::map<SplatNumbers, std::vector<uint8_t>> bytes;
    std::vector<SplatColumn> columns;
    for (const SplatNumbers what : kAll) {
        const size_t row = numbersOf(what, r.shDegree) * (half ? 2 : 4) + 3;  // any alignment
        bytes[what].assign(s.splats.uv.size() * row, 0xAB);
        columns.push_back({what, {bytes[what].data(), row, half}});
    }
    PosedSplatWriter writer;
    Jobs jobs(1);
    EXPECT_EQ(writer.choose(s.coded, SplatDetail()), s.splats.uv.size());
    saturated = writer.write(s.coded, s.frames, r.placement, columns, r.eye, r.shDegree, jobs);
    Numbers out;
    for (const SplatColumn& column : columns) {
        const uint32_t n = numbersOf(column.what, r.shDegree);
        for (size_t i = 0; i < s.splats.uv.size(); ++i) {
            const uint8_t* row = column.to.first + i * column.to.strideBytes;
            for (uint32_t k = 0; k < n; ++k) {
                float number = 0;
                uint16_t bits = 0;
                if (half)
                    std::memcpy(&bits, row + 2 * k, 2), number = floatFromHalf(bits);
                else
                    std::memcpy(&number, row + 4 * k, 4);
                out[column.what].push_back(number);
            }
            for (size_t b = n * (half ? 2 : 4); b < column.to.strideBytes; ++b) EXPECT_EQ(row[b], 0xAB);
        }
    }
    return out;
}

std::vector<Request> requests() {
    Placement placed;
    placed.rotation = glm::mat3_cast(glm::normalize(glm::dquat(0.5, 0.3, -0.7, 0.2))), placed.scale = 1.7,
    placed.translation = {0.2, -0.1, 0.3};
    return {{{}, {}, 3}, {{}, Vec3f(0.4f, 0.2f, 3), 1}, {placed, Vec3f(1, 1, 5), 3}, {placed, {}, 2}};
}

/** Float rounding: of positions and sizes relative, of colours and SH in sums of up to 16 products of about 1; twice what was measured.
 *  A rotation is compared by its covariance, as axes of a round splat may be any. Splats of triangles that are not valid have any shape. */
void expectNear(const Scene& s, const Numbers& want, const Numbers& got, const char* target) {
    SCOPED_TRACE(target);
    const auto shape = [&](size_t i) { return s.frames[i / 2].valid; };
    const auto most = [&](SplatNumbers what, auto&& relative) {
        const auto &a = want.at(what), &b = got.at(what);
        const size_t n = a.size() / s.splats.uv.size();
        double largest = 0;
        for (size_t k = 0; k < a.size(); ++k)
            if (shape(k / n)) largest = std::max(largest, std::abs(double(a[k]) - double(b[k])) / relative(k / n));
        return largest;
    };
    const auto one = [](size_t) { return 1.0; };
    const auto major = [&](size_t i) { return double(want.at(SplatNumbers::Scale)[3 * i]); };
    EXPECT_LT(most(SplatNumbers::Position, one), 1e-6);
    EXPECT_LT(most(SplatNumbers::Scale, major), 1e-6);
    EXPECT_LT(most(SplatNumbers::Covariance, [&](size_t i) { return major(i) * major(i); }), 6e-6);
    EXPECT_LT(most(SplatNumbers::Opacity, one), 1.4e-6);
    EXPECT_LT(most(SplatNumbers::Colour, one), 1e-6);
    EXPECT_LT(most(SplatNumbers::Sh, one), 1.3e-5);
    double worst = 0, apart = 0;
    for (size_t i = 0; i < s.splats.uv.size(); ++i) {
        ASSERT_EQ(got.at(SplatNumbers::Opacity)[i] == 0, want.at(SplatNumbers::Opacity)[i] == 0) << i;
        if (!shape(i)) continue;
        const auto covariance = [&](const Numbers& from) {
            const float *q = &from.at(SplatNumbers::Rotation)[4 * i], *scale = &from.at(SplatNumbers::Scale)[3 * i];
            Mat3d axes = glm::mat3_cast(glm::dquat(q[3], q[0], q[1], q[2]));
            for (int k = 0; k < 3; ++k) axes[k] *= double(scale[k]);
            return axes * glm::transpose(axes);
        };
        const Mat3d a = covariance(want), b = covariance(got);
        for (int c = 0; c < 3; ++c)
            for (int k = 0; k < 3; ++k) worst = std::max(worst, std::abs(a[c][k] - b[c][k]) / (major(i) * major(i)));
        for (size_t k = 0; k < 4; ++k)
            apart = std::max(apart, double(std::abs(got.at(SplatNumbers::Rotation)[4 * i + k] -
                                                    got.at(SplatNumbers::RotationWxyz)[4 * i + (k + 1) % 4])));
    }
    EXPECT_LT(worst, 3e-6);
    EXPECT_EQ(apart, 0);
}

/** Calls `what` with each instruction set that this machine has, by name. */
void withEachTarget(const std::function<void(const char*)>& what) {
    const int64_t supported = hwy::SupportedTargets();
    int tried = 0;
    for (const int64_t target : {int64_t(HWY_SSE4), int64_t(HWY_AVX2), int64_t(HWY_AVX3), int64_t(HWY_NEON)}) {
        if (!(supported & target)) continue;
        hwy::GetChosenTarget().Update(target);
        what(hwy::TargetName(target));
        ++tried;
    }
    hwy::GetChosenTarget().DeInit();  // the next call chooses again
    if (tried == 0) what("the only one");
}

TEST(WrittenSplats, areThoseOfOneAtATime) {
    for (uint32_t degree = 0; degree <= 3; ++degree) {
        const Scene s = makeScene(173, degree);  // no whole number of vectors
        for (const Request& r : requests()) {
            const Numbers want = expected(s, r);
            EXPECT_GT(std::count(want.at(SplatNumbers::Opacity).begin(), want.at(SplatNumbers::Opacity).end(), 0.0f), 20);
            withEachTarget([&](const char* target) {
                uint64_t saturated = 1;
                expectNear(s, want, written(s, r, false, saturated), target);
                EXPECT_EQ(saturated, 0u);
            });
        }
    }
}

TEST(WrittenSplats, halvesAreTheNearestOfTheFloats) {
    const Scene s = makeScene(173, 3);
    Request r = requests()[2];
    r.placement.translation = {90000, 0, -65519};  // beyond the halves, none of them, and at their edge
    r.eye.reset();
    withEachTarget([&](const char* target) {
        SCOPED_TRACE(target);
        uint64_t none = 1, saturated = 0, beyond = 0;
        const Numbers floats = written(s, r, false, none), halves = written(s, r, true, saturated);
        bool small = false;
        for (const SplatNumbers what : kAll)
            for (size_t k = 0; k < floats.at(what).size(); ++k) {
                const float number = floats.at(what)[k];
                ASSERT_EQ(halves.at(what)[k], floatFromHalf(halfFromFloat(std::clamp(number, -kMaxHalf, kMaxHalf))))
                    << int(what) << ' ' << number;
                beyond += std::abs(number) > kMaxHalf, small |= number != 0 && std::abs(number) < 6e-5f;
            }
        EXPECT_EQ(none, 0u);
        EXPECT_EQ(saturated, beyond);
        EXPECT_GT(beyond, s.splats.uv.size());
        EXPECT_TRUE(small) << "no half without a leading one was tried";
    });
}

}  // namespace
}  // namespace dpl::test
