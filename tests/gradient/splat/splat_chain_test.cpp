// SPDX-License-Identifier: Apache-2.0
// backwardSplat and finishTriangle in double against central differences of the projection of one splat, one test per branch.
#include <random>

#include "reconstruction/training/trainer/backward_chain.h"
#include "tests/gradient/splat/finite_difference.h"
#include "tests/unit/splat/bound_forward.h"

namespace dpl::test {
namespace {

// With h = 1e-6, central differences have a truncation error of 1e-10 and a rounding error of 1e-10, both relative.
constexpr double kStep = 1e-6, kRelative = 2e-6;
constexpr uint32_t kDegree = 3;

struct Case {
    Camerad camera;
    double kappa = 0.3;
    Vec3d rest[3] = {{0, 0, 0}, {0.11, 0.01, 0.02}, {0.03, 0.09, -0.01}};
    Vec3d now[3] = {{0, 0, 0}, {0.12, 0, 0.02}, {0.02, 0.1, -0.01}};  // the triangle at rest that stretch is measured from
    Vec3d posed[3] = {{-0.04, -0.03, 1.5}, {0.07, -0.05, 1.56}, {0.0, 0.08, 1.47}};
    Vec2d uv{0.25, 0.35};
    double phi = 0.7;
    Vec2d logScale{std::log(0.012), std::log(0.006)};
    double opacity = 0.8;
    bool singleFace = false;
    std::vector<double> sh;
    std::vector<double> lossWeight;  // of x, y, conic A, B, C, projected opacity, r, g, b

    Case() {
        camera.widthPx = 96, camera.heightPx = 128, camera.fx = 140, camera.fy = 150, camera.cx = 47, camera.cy = 65;
        camera.viewFromWorldRotation = Mat3d(glm::mat3_cast(Quatd(0.99, 0.05, -0.1, 0.08) / glm::length(Quatd(0.99, 0.05, -0.1, 0.08))));
        camera.viewFromWorldTranslation = {0.02, -0.03, 0.1};
        std::mt19937 random(7);
        std::normal_distribution<double> normal;
        for (uint32_t i = 0; i < shCoefficientCount(kDegree) * 3; ++i) sh.push_back(0.05 * normal(random));
        lossWeight = {0.3, -0.2, 1.1, -0.7, 0.9, 2.0, 0.8, -1.3, 0.6};
    }
};

/** Packs uv, φ, ln s, opacity, sh, nine posed coordinates. */
std::vector<double> pack(const Case& c) {
    std::vector<double> x{c.uv.x, c.uv.y, c.phi, c.logScale.x, c.logScale.y, c.opacity};
    x.insert(x.end(), c.sh.begin(), c.sh.end());
    for (const Vec3d& v : c.posed) x.insert(x.end(), {v.x, v.y, v.z});
    return x;
}

Case unpack(Case c, const std::vector<double>& x) {
    c.uv = {x[0], x[1]}, c.phi = x[2], c.logScale = {x[3], x[4]}, c.opacity = x[5];
    std::copy_n(x.begin() + 6, c.sh.size(), c.sh.begin());
    for (int k = 0; k < 3; ++k)
        for (int a = 0; a < 3; ++a) c.posed[k][a] = x[6 + c.sh.size() + size_t(k * 3 + a)];
    return c;
}

RestTriangle<double> bindOf(const Case& c) {
    return restTriangle(c.rest[0], c.rest[1], c.rest[2]);
}
RestTriangle<double> nowOf(const Case& c) {
    return restTriangle(c.now[0], c.now[1], c.now[2]);
}

TriangleFrame<double> frameOf(const Case& c) {
    return drawnTriangle(bindOf(c), nowOf(c), c.posed[0], c.posed[1], c.posed[2]);
}

BoundForward<double> forwardOf(const Case& c) {
    BoundSplat<double> splat;
    splat.uv = c.uv, splat.phi = c.phi, splat.scaleM = glm::exp(c.logScale), splat.opacity = c.opacity;
    splat.singleFace = c.singleFace, splat.shDegree = kDegree, splat.sh = c.sh.data();
    return projectBoundSplat(c.camera, frameOf(c), splat, c.kappa);
}

double forward(const Case& c) {
    const BoundForward<double> f = forwardOf(c);
    if (!f.visible) return 0;
    const ForwardRecord<double>& r = f.record;
    const double out[9] = {f.centrePx.x, f.centrePx.y, r.conicA, r.conicB, r.conicC, f.opacity, f.colour.x, f.colour.y, f.colour.z};
    double loss = 0;
    for (int i = 0; i < 9; ++i) loss += c.lossWeight[size_t(i)] * out[i];
    return loss;
}

std::vector<double> backward(const Case& c) {
    const TriangleFrame<double> frame = frameOf(c);
    SplatParameters<double> p;
    p.uv = c.uv, p.opacity = c.opacity, p.singleFace = c.singleFace, p.shDegree = kDegree;
    p.sh = c.sh.data();
    ScreenGradient<double> s;
    const auto& w = c.lossWeight;
    s.x = w[0], s.y = w[1], s.conicA = w[2], s.conicB = w[3], s.conicC = w[4], s.opacity = w[5], s.colour = {w[6], w[7], w[8]};
    ParameterGradient<double> g;
    TriangleGradient<double> triangle;
    backwardSplat(backwardViewOf(c.camera), frame, p, forwardOf(c).record, s, g, triangle);
    Vec3d corner[3];
    finishTriangle(frame, bindOf(c), nowOf(c), triangle, corner);
    std::vector<double> x{g.uv.x, g.uv.y, g.phi, g.logScale.x, g.logScale.y, g.opacity};
    x.insert(x.end(), g.sh, g.sh + c.sh.size());
    for (const Vec3d& v : corner) x.insert(x.end(), {v.x, v.y, v.z});
    return x;
}

std::vector<double> slice(const std::vector<double>& x, size_t begin, size_t end) {
    return {x.begin() + long(begin), x.begin() + long(end)};
}

/** Each parameter group against its own scale, so that a small group cannot hide behind a large one. */
void check(const Case& c, double relative = kRelative, double step = kStep) {
    const std::vector<double> analytic = backward(c), numeric = differences(
                                                          pack(c), [&](const auto&x) { return forward(unpack(c, x)); }, step);
    const size_t sh = 6 + c.sh.size();
    const std::tuple<const char*, size_t, size_t> groups[] = {{"uv", 0, 2},      {"phi", 2, 3}, {"log scale", 3, 5},
                                                              {"opacity", 5, 6}, {"sh", 6, sh}, {"vertices", sh, sh + 9}};
    for (const auto& [name, begin, end] : groups) expectGradients(slice(analytic, begin, end), slice(numeric, begin, end), relative, name);
}

TEST(SplatChain, visibleSplat) {
    check(Case());
}

TEST(SplatChain, mirroredSplatHasNegativeDeterminant) {
    Case c;
    std::swap(c.posed[1], c.posed[2]);
    check(c);
}

TEST(SplatChain, clampedSlopes) {
    Case c;  // far to the left and below, where the Jacobian clamps x/z and y/z
    for (Vec3d& v : c.posed) v += Vec3d(-1.4, 1.6, 0);
    const Vec3d view = c.camera.toView(c.posed[0]);
    const JacobianClamp<double> limit(c.camera);
    ASSERT_LT(view.x / view.z, limit.minX);
    ASSERT_GT(view.y / view.z, limit.maxY);
    check(c);
}

TEST(SplatChain, partiallyOpenGate) {
    Case c;
    c.singleFace = true;
    // Turn the triangle to cosθ = 0.05, where the gate is half open.
    const Vec3d eye = c.camera.eye(), centre = (c.posed[0] + c.posed[1] + c.posed[2]) / 3.0;
    const Vec3d toEye = glm::normalize(eye - centre), side = glm::normalize(glm::cross(toEye, Vec3d(0, 1, 0)));
    const Vec3d normal = glm::normalize(0.05 * toEye + side), t1 = glm::normalize(glm::cross(Vec3d(0, 1, 0), normal)),
                t2 = glm::cross(normal, t1);
    c.posed[0] = centre - 0.05 * t1 - 0.04 * t2, c.posed[1] = centre + 0.06 * t1 - 0.03 * t2, c.posed[2] = centre + 0.07 * t2;
    const auto frame = frameOf(c);
    const double gate = singleFaceGate(frame.normal, splatCentre(frame, c.uv), eye);
    ASSERT_GT(gate, 0.2);
    ASSERT_LT(gate, 0.8);
    check(c);
}

TEST(SplatChain, compensationAtItsFloor) {
    Case c;  // edge-on and tiny: √(det B²/det Σ') is below 0.005
    c.logScale = {std::log(2e-4), std::log(1e-4)};
    check(c);
}

TEST(SplatChain, nearFadePartlyOpen) {
    Case c;
    for (Vec3d& v : c.posed) v = {v.x * 0.1, v.y * 0.1, v.z - 1.5};
    const double z = c.camera.toView(c.posed[0]).z;
    ASSERT_GT(z, kNearM);
    ASSERT_LT(z, kNearFadeEndM);
    c.logScale -= std::log(10.0);
    check(c, 1e-5, 1e-7);  // ten times nearer, so derivatives of third order are a thousand times larger
}

TEST(SplatChain, needleStaysFinite) {
    Case c;
    c.logScale = {std::log(0.2), std::log(2e-4)};
    check(c, 1e-4, 1e-6);  // the finite difference is the inaccurate side (docs/reference/projection.md)
}

/** A triangle before the camera whose F has these singular values, with the larger one at an angle in the plane. */
Case stretchedCase(double largest, double smallest) {
    Case c;
    const Mat3d turn = glm::mat3_cast(glm::normalize(Quatd(0.95, 0.1, -0.2, 0.15)));
    const RestTriangle<double> now = nowOf(c);
    const Vec3d t1 = now.frame[0], t2 = now.frame[1], along = std::cos(0.4) * t1 + std::sin(0.4) * t2,
                across = std::cos(0.4) * t2 - std::sin(0.4) * t1;
    for (int k = 0; k < 3; ++k) {
        const Vec3d e = c.now[k] - c.now[0];
        c.posed[k] = Vec3d(-0.04, -0.03, 1.5) + turn * (largest * glm::dot(e, along) * along + smallest * glm::dot(e, across) * across);
    }
    return c;
}

TEST(SplatChain, stretchBelowAtAndBeyondItsBounds) {
    // within; beyond each bound; beyond both; in the fade of wide and of narrow triangles
    const std::pair<double, double> beside[] = {{1.6, 0.6}, {1.9, 0.8}, {1.2, 0.4}, {2.4, 0.3}, {3.4, 0.7}, {1.5, 0.15}, {3.6, 0.2}};
    for (const auto& [largest, smallest] : beside) {
        SCOPED_TRACE(largest);
        const Case c = stretchedCase(largest, smallest);
        const TriangleFrame<double> frame = frameOf(c);
        EXPECT_EQ(frame.bounded, largest > kStretchHigh || smallest < kStretchLow);
        EXPECT_EQ(frame.shown<1, largest> kStretchFade || smallest < kSqueezeFade);
        check(c, 1e-5);  // singular values down to 0.15 raise the third derivative
    }
    // At a bound the slope is continuous and the second derivative is not, so the difference is off by half a step times it.
    for (const auto& [largest, smallest] : {std::pair<double, double>{kStretchHigh, 0.8}, {1.2, kStretchLow}, {kStretchFade, 0.8}}) {
        SCOPED_TRACE(largest);
        check(stretchedCase(largest, smallest), 1e-4);
    }
}

TEST(SplatChain, equalStretchesHaveAGradient) {
    for (const double stretch : {0.3, 1.0, 2.2, 3.3}) {
        SCOPED_TRACE(stretch);
        check(stretchedCase(stretch, stretch), 1e-5);
        check(stretchedCase(stretch * (1 + 1e-5), stretch), 1e-4);  // where the quotient of differences would cancel
    }
}

TEST(SplatChain, rigidMotionHasNoEffectTogetherWithTheCamera) {
    // Moving the triangle rigidly is the same as moving the camera. So the sum and the torque of the corner gradients must equal the
    // gradients with respect to the camera's translation and rotation.
    Case c;
    const std::vector<double> g = backward(c);
    const size_t at = 6 + c.sh.size();
    Vec3d force(0), torque(0);
    for (size_t k = 0; k < 3; ++k) {
        const Vec3d gk(g[at + k * 3], g[at + k * 3 + 1], g[at + k * 3 + 2]);
        force += gk, torque += glm::cross(c.posed[k], gk);
    }
    const auto moved = [&](const std::vector<double>& x) {
        Case m = c;
        const Vec3d w(x[0], x[1], x[2]);
        const double angle = glm::length(w);
        const Mat3d turn = angle > 0 ? glm::mat3_cast(glm::angleAxis(angle, w / angle)) : Mat3d(1);
        // Moves the camera so that view coordinates are the same as if world points were rotated by `turn` and shifted by x[3..5].
        m.camera.viewFromWorldRotation = c.camera.viewFromWorldRotation * turn;
        m.camera.viewFromWorldTranslation = c.camera.viewFromWorldRotation * Vec3d(x[3], x[4], x[5]) + c.camera.viewFromWorldTranslation;
        return forward(m);
    };
    expectGradients({torque.x, torque.y, torque.z, force.x, force.y, force.z}, differences(std::vector<double>(6, 0.0), moved, kStep), 1e-5,
                    "camera");
}

TEST(SplatChain, clampedColourOnlyPassesGradientsThatPullItBack) {
    Case c;
    std::fill(c.sh.begin(), c.sh.end(), 0.0);
    c.sh[0] = 3.0;  // red far above 1
    c.lossWeight = {0, 0, 0, 0, 0, 0, 1.0, 0.5, 0};
    EXPECT_NEAR(backward(c)[6], kShC0, 1e-12) << "descent lowers red: straight through";
    c.lossWeight[6] = -1.0;
    EXPECT_EQ(backward(c)[6], 0) << "descent would raise red further above 1";
    EXPECT_NEAR(backward(c)[7], 0.5 * kShC0, 1e-12) << "green is inside the range";
}

}  // namespace
}  // namespace dpl::test
