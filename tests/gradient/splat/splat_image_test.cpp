// SPDX-License-Identifier: Apache-2.0
// The trainer's whole backward pass (float, SIMD, tiles) against finite differences of a double-precision picture.
#include <array>
#include <random>

#include "reconstruction/training/trainer/backward_correctives.h"
#include "reconstruction/training/trainer/backward_splats.h"
#include "sdk/avatar/posed_mesh.h"
#include "sdk/avatar/scene_light.h"
#include "sdk/format/motion_modes.h"
#include "tests/gradient/splat/double_scene.h"
#include "tests/gradient/splat/finite_difference.h"

namespace dpl::test {
namespace {

// Float forward and backward against differences in double. Rounding of pixel positions (1e-6 relative) and of sums over a few hundred
// pixels gave errors of 3e-5 to 2e-4 of the largest entry of a parameter group.
constexpr double kRelative = 1e-3, kStep = 1e-6;

DoubleScene makeScene(double opacityLogit, uint8_t flags, uint32_t splatCount = 12) {
    DoubleScene s;
    s.joints.resize(3);
    s.joints[1].parent = 0, s.joints[2].parent = 1;
    s.joints[0].restPosition = {0, 0, 0}, s.joints[1].restPosition = {0, 0.1f, 0.01f}, s.joints[2].restPosition = {0.02f, 0.2f, 0};
    s.mesh.restPositions = {{-0.1f, -0.1f, 0}, {0.12f, -0.08f, 0.01f}, {-0.09f, 0.11f, 0.02f}, {0.1f, 0.13f, -0.02f}, {0, 0.3f, 0.03f}};
    // Counter-clockwise seen from the camera, which looks along −Z from +Z (the view rotation below is π about X).
    s.mesh.triangles = {{0, 1, 2}, {1, 3, 2}, {2, 3, 4}};
    s.mesh.jointIndices = {{0, 1, 0, 0}, {0, 1, 2, 0}, {1, 0, 2, 0}, {1, 2, 0, 0}, {2, 1, 0, 0}};
    s.mesh.jointWeights = {{200, 55, 0, 0}, {155, 60, 40, 0}, {120, 75, 60, 0}, {130, 125, 0, 0}, {200, 55, 0, 0}};
    for (const Vec3f& v : s.mesh.restPositions) s.rest.push_back(Vec3d(v) + 0.004 * Vec3d(std::sin(v.x * 90), std::cos(v.y * 70), v.x));
    s.rotations = {glm::normalize(Quatd(0.98, 0.1, 0.15, -0.05)), glm::normalize(Quatd(0.95, -0.2, 0.1, 0.1)),
                   glm::normalize(Quatd(0.97, 0.1, 0, 0.2))};
    s.rootTranslation = {0.01, -0.05, 0.02};
    s.jointTurn.assign(3, Vec3d(0));
    s.sizeFloorM = {0.004, 0.002, 0};
    s.camera.widthPx = 41, s.camera.heightPx = 53, s.camera.fx = 100, s.camera.fy = 104, s.camera.cx = 20.2, s.camera.cy = 30.1;
    s.camera.viewFromWorldRotation = Mat3d(1, 0, 0, 0, -1, 0, 0, 0, -1);
    s.camera.viewFromWorldTranslation = {0, 0, 0.9};
    std::mt19937 random(3);
    std::uniform_real_distribution<double> u01(0, 1);
    std::normal_distribution<double> normal;
    for (uint32_t i = 0; i < splatCount; ++i) {
        s.triangle.push_back(i * 3 / splatCount);
        s.flags.push_back(uint8_t(flags | (i % 2 ? kSplatCloth : 0)));
        double a = u01(random), b = u01(random);
        if (a + b > 1) a = 1 - a, b = 1 - b;
        const double head[6] = {a,
                                b,
                                3 * u01(random),
                                std::log(0.012 + 0.03 * u01(random)),
                                std::log(0.008 + 0.02 * u01(random)),
                                opacityLogit + 0.3 * normal(random)};
        s.rows.insert(s.rows.end(), head, head + 6);
        for (uint32_t k = 0; k < shCoefficientCount(s.shDegree) * 3; ++k) s.rows.push_back(0.25 * normal(random));
    }
    for (size_t i = 0; i < size_t(s.camera.widthPx) * s.camera.heightPx * 5; ++i) s.pixelWeights.push_back(normal(random) + 0.4);
    return s;
}

/** Adds correctives of two modes, two joints and three nodes. Their effect is visible and the brightness stays inside its clamp. */
DoubleScene withCorrectives(DoubleScene s, float reach, float reachOffModes = 1e6f) {
    PoseCorrectiveData& c = s.correctives;
    c.modeCount = 2, c.nodeCount = 3, c.joints = {1, 2}, c.reach = reach, c.reachOffModes = reachOffModes;
    for (int f = 0; f < 12; ++f) c.mean.push_back(0.02f * float(f % 5) - 0.03f);
    for (int f = 0; f < 24; ++f) c.modes.push_back(0.9f * std::sin(1.7f * float(f) + 0.4f));
    c.nodeIndices = {{0, 1, 0, 0}, {1, 0, 2, 0}, {2, 1, 0, 0}, {0, 2, 0, 0}, {1, 2, 0, 0}};
    c.nodeWeights = {{155, 100, 0, 0}, {205, 30, 20, 0}, {200, 55, 0, 0}, {130, 125, 0, 0}, {128, 127, 0, 0}};
    for (int n = 0; n < 6; ++n)
        c.nodes.push_back({0.01f * std::sin(2.3f * float(n)), 0.012f * std::cos(1.9f * float(n)), 0.008f * std::sin(float(n)),
                           0.25f * std::cos(2.9f * float(n))});
    for (const Vec4f& n : c.nodes) s.nodes.insert(s.nodes.end(), {n.x, n.y, n.z, n.w});
    return s;
}

/** Adds three motion modes of the same joints, the last two in a group with a reach. moved, where its smooth step stands: 0 not yet, 0.5
 * half way, 1 done. */
DoubleScene withMotion(DoubleScene s, double moved, float reach = 10) {
    PoseCorrectiveData& c = s.correctives;
    MotionModeData m;
    m.joints = {0, 2}, m.holdsS = {0, 1.5f}, m.lagsS = {0.4f};
    m.still = {{0, 0, 0, 1}, {0.05f, -0.06f, 0, 0.997f}};
    double squares = 0;
    for (size_t j = 0; j < 2; ++j) {
        m.still[j] = glm::normalize(m.still[j]);
        const Quatd still(m.still[j].w, m.still[j].x, m.still[j].y, m.still[j].z);
        const double angle = 2 * std::acos(std::abs(glm::dot(glm::normalize(s.rotations[m.joints[j]]), still)));
        squares += angle * angle;
        m.rangeRad.emplace_back(float(0.5 * angle), j == 0 ? 2.0f : float(0.2 * angle));  // the second has reached its most
    }
    m.movedFromRad = float(std::sqrt(squares) + 0.3 - 0.6 * moved), m.movedToRad = m.movedFromRad + 0.6f;
    if (moved == 1) m.movedFromRad -= 0.5f, m.movedToRad -= 0.5f;
    if (moved == 0) m.movedFromRad += 0.1f, m.movedToRad += 0.1f;
    m.movedFromRad = std::max(m.movedFromRad, 0.0f), m.movedToRad = std::max(m.movedToRad, 0.01f);
    m.groups = {{.columnCount = 1}, {.columnCount = 2, .reach = reach}};
    for (size_t i = 0; i < 3 * m.featureCount(); ++i) m.modes.push_back(0.7f * std::cos(2.1f * float(i) + 1.7f));
    addMotionModes(c, std::move(m));
    for (size_t e = 0; e < c.nodes.size(); ++e)
        if (e % 5 >= 2)
            c.nodes[e] = {0.01f * std::cos(1.3f * float(e)), 0.01f * std::sin(2.9f * float(e)), 0.008f * std::cos(float(e)),
                          0.2f * std::sin(1.7f * float(e))};
    s.nodes.clear();
    for (const Vec4f& n : c.nodes) s.nodes.insert(s.nodes.end(), {n.x, n.y, n.z, n.w});
    return s;
}

/** Adds light from one side, which bends brightness by some tenths and stays inside its bounds. */
DoubleScene withLight(DoubleScene s) {
    s.light.irradiance = {-0.5f, 0.3f, -0.2f, 0.15f, -0.1f, 0.2f, 0.1f, -0.15f};
    s.normals = restVertexNormals(s.mesh);
    return s;
}

struct Analytic {
    std::vector<double> rows, rest, joints, root, nodes;
    std::vector<float> bytes;  // everything, for the thread test
    bool sawCap = false;
    double loss = 0;  // of the float picture
};

/** shares: of the colour gradient of each pixel, for splats of the body and of cloth. */
Analytic backward(const DoubleScene& s, uint32_t threads, const std::array<float, 2>& shares = {1, 1}) {
    Jobs jobs(threads);
    TrainableSplats splats;
    splats.resize(uint32_t(s.triangle.size()), s.shDegree);
    splats.triangle = s.triangle, splats.flags = s.flags;
    splats.sizeFloorM.assign(s.sizeFloorM.begin(), s.sizeFloorM.end());
    for (size_t i = 0; i < s.triangle.size(); ++i)
        for (size_t k = 0; k < s.rowLength(); ++k) splats.rows[i * splats.stride + k] = float(s.rows[i * s.rowLength() + k]);
    splats.indexTriangles(s.mesh.triangles.size());
    splats.activateAll(jobs);

    MeshData mesh = s.mesh;
    const std::vector<RestTriangle<float>> bind = restTriangles(mesh);
    for (size_t v = 0; v < s.rest.size(); ++v) mesh.restPositions[v] = Vec3f(s.rest[v]);
    Pose pose = Pose::rest(s.joints.size());
    for (size_t j = 0; j < s.joints.size(); ++j) pose.localRotations[j] = Quatf(s.rotations[j]);
    pose.rootTranslation = Vec3f(s.rootTranslation);
    pose.before = s.before;
    std::vector<Vec3f> gPosed, gRest;
    PosedMesh posed;
    posed.pose({s.joints, mesh, s.correctives, {bind}, &s.light, s.normals}, pose, jobs);

    const Cameraf camera = s.camera.cast<float>();
    SplatEngine engine(jobs);
    SplatImage image;
    engine.project(splats.view(), posed.frames(), camera, float(s.kappa), /*compensated=*/true, /*record=*/true);
    engine.bin();
    engine.blend(image, {.cloth = true, .depth = false, .recordStops = true});
    ImageGradient gradient;
    gradient.resize(image.widthPx, image.heightPx, true);
    for (size_t i = 0; i < image.alpha.size(); ++i) {
        const double* w = s.pixelWeights.data() + i * 5;
        gradient.red[i] = float(w[0]), gradient.green[i] = float(w[1]), gradient.blue[i] = float(w[2]);
        gradient.alpha[i] = float(w[3]), gradient.cloth[i] = float(w[4]);
        for (size_t kind = 0; kind < 2; ++kind) gradient.colourShare[kind][i] = i % 2 ? shares[kind] : 1.0f;
    }
    PixelBackward pixels(jobs);
    pixels.run(engine, image, gradient);
    SplatBackward backward(jobs);
    backward.run({splats, posed.frames(), {bind}, camera, engine.projected(), engine.forwardRecords(), pixels.sums()}, true);
    std::vector<float> gLight;
    backward.gatherVertices(VertexIncidence(mesh.triangles, s.rest.size()), gPosed, gLight);
    PoseGradient<double> g;
    backwardSceneLight(posed, gLight);
    backwardSkin(mesh, s.joints, posed, gPosed, jobs, gRest, g);
    std::vector<Vec4f> gNodes;
    if (!s.correctives.empty()) {
        gatherNodes(s.correctives, posed.nodes(), gRest, gLight, gNodes);
        addCorrectivePoseGradient(s.correctives, pose, gNodes, g.rotation);
    }

    Analytic out;
    for (size_t i = 0; i < image.alpha.size(); ++i) {
        const double* w = s.pixelWeights.data() + i * 5;
        out.loss += w[0] * image.rgb[i * 3] + w[1] * image.rgb[i * 3 + 1] + w[2] * image.rgb[i * 3 + 2] + w[3] * image.alpha[i] +
                    w[4] * image.cloth[i];
    }
    for (const ProjectedSplat& p : engine.projected()) out.sawCap |= p.opacity > float(kMaxAlpha);
    for (size_t i = 0; i < splats.count(); ++i)
        for (size_t k = 0; k < s.rowLength(); ++k)
            out.rows.push_back(backward.active()[i] ? double(backward.rowGradients()[i * splats.stride + k]) : 0.0);
    for (const Vec3f& v : gRest) out.rest.insert(out.rest.end(), {v.x, v.y, v.z});
    for (const Vec3d& v : g.rotation) out.joints.insert(out.joints.end(), {v.x, v.y, v.z});
    out.root = {g.rootTranslation.x, g.rootTranslation.y, g.rootTranslation.z};
    for (const Vec4f& n : gNodes)
        for (const float k : posed.coefficients()) out.nodes.insert(out.nodes.end(), {k * n.x, k * n.y, k * n.z, k * n.w});
    for (const auto* part : {&out.rows, &out.rest, &out.joints, &out.root, &out.nodes})
        for (double x : *part) out.bytes.push_back(float(x));
    return out;
}

std::vector<double> flat(const std::vector<Vec3d>& v) {
    std::vector<double> x;
    for (const Vec3d& p : v) x.insert(x.end(), {p.x, p.y, p.z});
    return x;
}
Vec3d at(const std::vector<double>& x, size_t i) {
    return {x[i * 3], x[i * 3 + 1], x[i * 3 + 2]};
}

void check(const DoubleScene& s) {
    const Analytic a = backward(s, 2);
    const double loss = renderLoss(s);
    EXPECT_NEAR(a.loss, loss, 1e-3 * std::abs(loss)) << "both sides must look at the same picture";
    const auto numericRows = differences(
        s.rows,
        [&](const auto& x) {
            DoubleScene m = s;
            m.rows = x;
            return renderLoss(m);
        },
        kStep);
    const char* names[] = {"u", "v", "phi", "log s1", "log s2", "opacity logit", "sh"};
    for (size_t k = 0; k < 7; ++k) {  // each column against its own scale
        std::vector<double> analytic, numeric;
        for (size_t i = 0; i < s.triangle.size(); ++i)
            for (size_t c = k; c < (k == 6 ? s.rowLength() : k + 1); ++c) {
                analytic.push_back(a.rows[i * s.rowLength() + c]);
                numeric.push_back(numericRows[i * s.rowLength() + c]);
            }
        expectGradients(analytic, numeric, kRelative, names[k]);
    }
    const auto rest = differences(
        flat(s.rest),
        [&](const auto& x) {
            DoubleScene m = s;
            for (size_t v = 0; v < m.rest.size(); ++v) m.rest[v] = at(x, v);
            return renderLoss(m);
        },
        kStep);
    expectGradients(a.rest, rest, kRelative, "rest vertices");
    const auto joints = differences(
        flat(s.jointTurn),
        [&](const auto& x) {
            DoubleScene m = s;
            for (size_t j = 0; j < m.joints.size(); ++j) m.jointTurn[j] = at(x, j);
            return renderLoss(m);
        },
        kStep);
    expectGradients(a.joints, joints, kRelative, "joint rotations");
    const auto root = differences(
        {0, 0, 0},
        [&](const auto& x) {
            DoubleScene m = s;
            m.rootShift = at(x, 0);
            return renderLoss(m);
        },
        kStep);
    expectGradients(a.root, root, kRelative, "root translation");
    if (s.correctives.empty()) return;
    const auto nodes = differences(
        s.nodes,
        [&](const auto& x) {
            DoubleScene m = s;
            m.nodes = x;
            return renderLoss(m);
        },
        kStep);
    const char* components[] = {"node offset x", "node offset y", "node offset z", "node brightness"};
    for (size_t c = 0; c < 4; ++c) {
        std::vector<double> analytic, numeric;
        for (size_t i = c; i < nodes.size(); i += 4) analytic.push_back(a.nodes[i]), numeric.push_back(nodes[i]);
        expectGradients(analytic, numeric, kRelative, components[c]);
    }
}

TEST(SplatImageGradient, translucentSplats) {
    check(makeScene(0.0, 0));
}
TEST(SplatImageGradient, singleFaceSplats) {
    check(makeScene(0.0, kSplatSingleFace));
}

TEST(SplatImageGradient, poseCorrectives) {
    check(withCorrectives(makeScene(0.0, 0), 10));
}
TEST(SplatImageGradient, poseCorrectivesOffTheirModes) {
    check(withCorrectives(makeScene(0.0, 0), 0.3f, 0.1f));
}
TEST(SplatImageGradient, poseCorrectivesBeyondTheirReach) {
    check(withCorrectives(makeScene(0.0, kSplatSingleFace), 0.3f));
}

TEST(SplatImageGradient, lightOfTheScene) {
    const DoubleScene s = withLight(makeScene(0.0, 0));
    DoubleScene unlit = s;
    unlit.light = {}, unlit.normals.clear();
    EXPECT_GT(std::abs(renderLoss(s) - renderLoss(unlit)), 0.01 * std::abs(renderLoss(s))) << "the case would prove nothing";
    check(s);
}
TEST(SplatImageGradient, lightOfTheSceneAndPoseCorrectives) {
    check(withLight(withCorrectives(makeScene(0.0, kSplatSingleFace), 10)));
}
TEST(SplatImageGradient, boundedLightStopsItsOwnGradient) {
    DoubleScene s = withLight(makeScene(0.0, 0));
    for (float& c : s.light.irradiance) c *= 8;  // some vertices lie at a bound of the irradiance, or at one of the brightness
    s.light.irradiance[1] = 3.9f;
    check(s);
}

TEST(SplatImageGradient, motionModesHalfWay) {
    check(withMotion(withCorrectives(makeScene(0.0, 0), 10), 0.5));
}
TEST(SplatImageGradient, motionModesThatHaveMovedBesideModesThatFade) {
    check(withMotion(withCorrectives(makeScene(0.0, 0), 0.3f, 0.1f), 1));
}
TEST(SplatImageGradient, motionModesBeyondTheirReach) {
    check(withMotion(withCorrectives(makeScene(0.0, 0), 10), 0.5, 0.1f));
}
TEST(SplatImageGradient, motionModesThatHoldMoreThanThePoseAsks) {
    DoubleScene s = withMotion(withCorrectives(makeScene(0.0, 0), 10), 0.5);
    s.before.held[3] = 0.8;  // "has moved" and the first joint, in the hold of 1.5 s
    s.before.held[4] = 0.9;
    check(s);
}
TEST(SplatImageGradient, motionModesThatLagBehindThePose) {
    DoubleScene s = withMotion(withCorrectives(makeScene(0.0, 0), 10), 0.5);
    s.before.earlier[0] = 0.6;
    for (size_t i = 0; i < 12; ++i) s.before.lagged[i] = 0.1 * std::cos(1.1 * double(i));
    check(s);
}
TEST(SplatImageGradient, motionModesThatHaveNotMovedYet) {
    check(withMotion(withCorrectives(makeScene(0.0, kSplatSingleFace), 10), 0));
}

TEST(SplatImageGradient, cappedAlphaStopsItsOwnGradient) {
    DoubleScene s = makeScene(7.4, 0);
    for (size_t i = 0; i < s.triangle.size(); ++i)
        s.rows[i * s.rowLength() + 3] = std::log(0.095), s.rows[i * s.rowLength() + 4] = std::log(0.075);
    EXPECT_TRUE(backward(s, 1).sawCap) << "large opaque splats reach α = 0.99";
    check(s);
}

TEST(SplatImageGradient, eachKindTakesItsShareOfColour) {
    const DoubleScene s = makeScene(0.0, 0);
    const Analytic whole = backward(s, 2), shared = backward(s, 2, {0.25f, 0});
    std::array<Analytic, 2> scaled;  // by pictures whose colour counts less in every other pixel
    for (size_t kind = 0; kind < 2; ++kind) {
        DoubleScene m = s;
        for (size_t i = 1; i < m.pixelWeights.size() / 5; i += 2)
            for (size_t c = 0; c < 3; ++c) m.pixelWeights[i * 5 + c] *= kind == 0 ? 0.25 : 0;
        scaled[kind] = backward(m, 2);
    }
    constexpr size_t kOpacity = 5, kSh = 6;
    double changed = 0;
    for (size_t i = 0; i < s.triangle.size(); ++i) {
        const size_t row = i * s.rowLength();
        const Analytic& expected = scaled[s.flags[i] & kSplatCloth ? 1 : 0];
        EXPECT_EQ(shared.rows[row + kOpacity], whole.rows[row + kOpacity]) << "opacity still answers for the whole pixel";
        for (size_t k = kSh; k < s.rowLength(); ++k) {
            EXPECT_NEAR(shared.rows[row + k], expected.rows[row + k], 1e-5 * (1 + std::abs(expected.rows[row + k]))) << i << ", " << k;
            changed = std::max(changed, std::abs(shared.rows[row + k] - whole.rows[row + k]));
        }
    }
    EXPECT_GT(changed, 1e-2);
}

TEST(SplatImageGradient, behindTheCameraIsZero) {
    DoubleScene s = makeScene(0.0, 0);
    s.camera.viewFromWorldTranslation = {0, 0, -2};
    const Analytic a = backward(s, 1);
    for (float g : a.bytes) EXPECT_EQ(g, 0);
    EXPECT_EQ(renderLoss(s), 0);
}

TEST(SplatImageGradient, sameBytesOnOneTwoThreeThreads) {
    const DoubleScene s = makeScene(0.0, kSplatSingleFace, 900);
    const Analytic one = backward(s, 1), two = backward(s, 2), three = backward(s, 3);
    EXPECT_EQ(one.bytes, two.bytes);
    EXPECT_EQ(one.bytes, three.bytes);
    EXPECT_GT(*std::max_element(one.bytes.begin(), one.bytes.end()), 0);
}

}  // namespace
}  // namespace dpl::test
