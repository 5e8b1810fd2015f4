// SPDX-License-Identifier: Apache-2.0
// Hard cases of drawing. Each expects agreement with the referee, and some of them an empty picture.
#include "tests/reference/compare_renderers.h"
#include "tests/reference/random_avatar.h"

namespace dpl {
namespace {

/** One right triangle with legs of 0.1 m at rest, and its posed corners. */
ReferenceScene oneTriangle(const glm::dvec3& v0, const glm::dvec3& v1, const glm::dvec3& v2) {
    ReferenceScene scene;
    scene.rest = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}};
    scene.posed = {v0, v1, v2};
    scene.triangles = {{0, 1, 2}};
    return scene;
}

ReferenceBoundSplat splat(double s1, double s2, double phi = 0.4, double opacity = 0.9) {
    return {0, {0.3, 0.3}, phi, {s1, s2}, opacity, 0, {0.5, -0.3, 0.2}};
}

ReferenceImage check(const char* name, const ReferenceScene& scene, const Cameraf& camera, double psnrDb = kBarDb) {
    ReferenceImage reference = renderReference(scene, referenceCamera(camera));
    expectSameImage(name, drawSoftware(scene, camera), reference, psnrDb);
    return reference;
}

ReferenceScene flatTriangle() {
    return oneTriangle({0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0});
}

TEST(HardCases, nearPlane) {
    // A line of splats whose depths cross the near plane and the near fade.
    StaticSplatData s = randomStaticSplats(9, 60, 0);
    for (uint32_t i = 0; i < s.count(); ++i)
        s.position[i] = {0.003f * float(i) - 0.09f, 0, 0.02f + 0.003f * float(i)}, s.scaleM[i] = Vec3f(0.004f);
    Cameraf camera;
    camera.widthPx = 160, camera.heightPx = 120, camera.fx = camera.fy = 100, camera.cx = 80, camera.cy = 60;
    const ReferenceImage reference = renderReference(s, referenceCamera(camera));
    ASSERT_GT(coverage(reference.alpha), 0.01);
    expectSameImage("near plane", drawSoftware(s, camera), reference, kBarDb);
}

TEST(HardCases, cameraTenCentimetresFromTheChest) {
    const AvatarData avatar = randomAvatar(21, 10, 6);
    const ReferenceScene scene = sceneOf(avatar, Pose::rest(2));
    const ReferenceImage image = check("10 cm from the chest", scene, lookAt({0, 1, 0.6f}, {0, 1, 0}, 160, 140, 150));
    EXPECT_GT(coverage(image.alpha), 0.9);
}

TEST(HardCases, splatLargerThanTheScreen) {
    ReferenceScene scene = flatTriangle();
    scene.splats = {splat(5, 3), splat(0.02, 0.01)};
    EXPECT_GT(coverage(check("larger than the screen", scene, lookAt({0.03f, 0.03f, 1}, {0.03f, 0.03f, 0}, 120, 90, 100)).alpha), 0.99);
}

TEST(HardCases, splatOfTenMicrometres) {
    ReferenceScene scene = flatTriangle();
    scene.splats = {splat(1e-5, 1e-5), splat(1e-3, 1e-3)};
    // Compensation makes a splat of 0.01 px fainter than 1/255, also at its floor of 0.005.
    check("1e-5 m", scene, lookAt({0.03f, 0.03f, 1}, {0.03f, 0.03f, 0}, 60, 60, 1000));
    scene.splats.resize(1);
    EXPECT_GT(
        coverage(check("1e-5 m, seen from 2 cm per 100 px", scene, lookAt({0.03f, 0.03f, 0.2f}, {0.03f, 0.03f, 0}, 60, 60, 20000)).alpha),
        0.0005);
}

TEST(HardCases, needlesOfRatioThousand) {
    ReferenceScene scene = flatTriangle();
    for (int i = 0; i < 12; ++i) scene.splats.push_back(splat(0.05, 5e-5, 0.26 * i, 0.95));
    EXPECT_GT(coverage(check("needles, 100 px", scene, lookAt({0.03f, 0.03f, 1}, {0.03f, 0.03f, 0}, 200, 200, 2000)).alpha, 0.004), 0.01);
    EXPECT_GT(coverage(check("needles, 1000 px", scene, lookAt({0.03f, 0.03f, 0.5f}, {0.03f, 0.03f, 0}, 400, 300, 10000)).alpha, 0.004),
              0.01);
}

TEST(HardCases, edgeOnDiscs) {
    for (const float lift : {0.f, 1e-4f, 1e-2f, 0.1f}) {
        ReferenceScene scene = flatTriangle();
        scene.splats = {splat(0.02, 0.01), splat(0.01, 0.02, 1.2)};
        check("edge-on discs", scene, lookAt({0.03f, 1, lift}, {0.03f, 0.03f, 0.f}, 100, 80, 900));
    }
}

TEST(HardCases, opposedGateFromBehindDrawsNothing) {
    ReferenceScene scene = flatTriangle();
    scene.splats = {splat(0.02, 0.01)};
    scene.splats[0].flags = kSplatSingleFace;
    const Cameraf front = lookAt({0.03f, 0.03f, 1}, {0.03f, 0.03f, 0}, 80, 80, 300),
                  behind = lookAt({0.03f, 0.03f, -1}, {0.03f, 0.03f, 0}, 80, 80, 300);
    EXPECT_GT(coverage(check("single face, front", scene, front).alpha), 0.01);
    EXPECT_EQ(coverage(check("single face, behind", scene, behind).alpha, 0), 0);
    for (const float height : {0.02f, 0.05f, 0.09f, 0.12f})  // inside the gate's ramp
        check("single face, grazing", scene, lookAt({0.03f, 1, height}, {0.03f, 0.03f, 0.f}, 80, 80, 1200));
}

TEST(HardCases, degenerateTrianglesDrawNothing) {
    const Cameraf camera = lookAt({0.03f, 0.03f, 1}, {0.03f, 0.03f, 0}, 80, 80, 300);
    ReferenceScene zeroPosed = oneTriangle({0, 0, 0}, {0.1, 0, 0}, {0.05, 0, 0});
    ReferenceScene sliver = oneTriangle({0, 0, 0}, {1, 0, 0}, {0.5, 0.5e-4, 0});  // aspect 2e4
    ReferenceScene zeroRest = flatTriangle();
    zeroRest.rest[2] = zeroRest.rest[1];
    for (ReferenceScene* scene : {&zeroPosed, &sliver, &zeroRest}) {
        scene->splats = {splat(0.02, 0.01)};
        EXPECT_EQ(coverage(check("degenerate triangle", *scene, camera).alpha, 0), 0);
        EXPECT_EQ(coverage(drawSoftware(*scene, camera).alpha, 0), 0);
    }
}

TEST(HardCases, invertedAndThinTriangles) {
    const Cameraf camera = lookAt({0.03f, 0.03f, 1}, {0.03f, 0.03f, 0}, 80, 80, 300);
    ReferenceScene inverted = oneTriangle({0, 0, 0}, {0, 0.1, 0}, {0.1, 0, 0});
    inverted.splats = {splat(0.02, 0.01)};
    EXPECT_GT(coverage(check("inverted, double-sided", inverted, camera).alpha), 0.01);
    inverted.splats[0].flags = kSplatSingleFace;
    EXPECT_EQ(coverage(check("inverted, single face", inverted, camera).alpha, 0), 0);
    ReferenceScene thin = oneTriangle({0, 0, 0}, {0.5, 0, 0}, {0.25, 1e-4, 0});  // aspect 5e3, posed as at rest
    thin.rest = thin.posed;
    thin.splats = {splat(0.02, 0.01)};
    EXPECT_GT(coverage(check("aspect 5e3", thin, lookAt({0.225f, 3e-5f, 1}, {0.225f, 3e-5f, 0}, 80, 80, 300)).alpha), 0.001);
}

TEST(HardCases, overstretchedTrianglesAreBoundedAndFade) {
    // What a splat of 1 cm covers where its triangle is stretched and squeezed, seen at 3 px a centimetre.
    const auto covers = [](double along, double across) {
        ReferenceScene scene = oneTriangle({0, 0, 0}, {0.1 * along, 0, 0}, {0, 0.1 * across, 0});
        scene.splats = {splat(0.01, 0.01, 0.0)};
        const glm::vec3 centre(0.03 * along, 0.03 * across, 0);
        return coverage(check("stretched", scene, lookAt(centre + glm::vec3(0, 0, 1), centre, 160, 160, 300)).alpha, 0.02);
    };
    const double rest = covers(1, 1);
    EXPECT_NEAR(covers(1.6, 1) / rest, 1.6, 0.1) << "within the bounds it follows";
    EXPECT_NEAR(covers(2.9, 1) / rest, kStretchHigh + kStretchHighRoom * 0.8, 0.1) << "beyond, it nears 2";
    EXPECT_LT(covers(3.5, 1), covers(2.9, 1)) << "it fades";
    EXPECT_EQ(covers(4.01, 1), 0);
    EXPECT_EQ(covers(40, 1), 0);
    EXPECT_GT(covers(1, 0.3) / rest, 0.38) << "a splat that is squeezed keeps a part of its width";
    EXPECT_GT(covers(1, 0.1), 0);
    EXPECT_LT(covers(1, 0.02), 0.1 * rest) << "until it fades";
    for (const auto& [along, across] : {std::pair(2.5, 0.3), {3.3, 0.2}, {2.0, 2.0}, {0.3, 0.3}, {3.2, 3.2}})
        EXPECT_GT(covers(along, across), 0);
}

TEST(HardCases, overstretchedAvatar) {
    // Two joints that part by half a metre: the triangles between them are stretched up to eight times.
    AvatarData avatar = randomAvatar(33, 12, 4);
    for (auto& weights : avatar.mesh.jointWeights) weights = weights.x > 127 ? glm::u8vec4(255, 0, 0, 0) : glm::u8vec4(0, 255, 0, 0);
    avatar.joints[1].restPosition = {0.6f, 1.1f, 0};
    Pose pose = Pose::rest(2);
    pose.localRotations[1] = glm::angleAxis(0.8f, Vec3f(0, 0, 1));
    const ReferenceScene scene = sceneOf(avatar, pose);
    size_t bounded = 0, gone = 0;
    for (const TriangleFrame<float>& frame : EngineInput(scene).frames) bounded += frame.bounded, gone += !frame.valid;
    EXPECT_GT(bounded, 20u);
    EXPECT_GT(gone, 0u);
    EXPECT_GT(coverage(check("torn", scene, lookAt({0.3f, 1, 1.8f}, {0, 1, 0}, 150, 150, 160)).alpha), 0.05);
}

TEST(HardCases, opposingBlendOfTwoJoints) {
    // Where two joints half a turn apart have equal weights, skinning collapses vertices onto the axis.
    AvatarData avatar = randomAvatar(31, 8, 4);
    Pose pose = Pose::rest(2);
    pose.localRotations[1] = glm::angleAxis(3.14159265f, Vec3f(0, 1, 0));
    EXPECT_GT(coverage(check("joint at pi", sceneOf(avatar, pose), lookAt({0.3f, 1, 1.8f}, {0, 1, 0}, 150, 150, 160)).alpha), 0.05);
    pose.localRotations[1] = glm::angleAxis(6.2831853f, Vec3f(0, 1, 0));
    EXPECT_GT(coverage(check("joint at 2 pi", sceneOf(avatar, pose), lookAt({0.3f, 1, 1.8f}, {0, 1, 0}, 150, 150, 160)).alpha), 0.05);
}

TEST(HardCases, opaqueLayersStopTheBlend) {
    StaticSplatData s = randomStaticSplats(41, 400, 0);
    for (uint32_t i = 0; i < s.count(); ++i)
        s.position[i].x *= 0.2f, s.position[i].y *= 0.2f, s.scaleM[i] = Vec3f(0.3f), s.opacity[i] = 1.f;
    const Cameraf camera = lookAt({0, 0, -3}, {0, 0, 0}, 100, 90, 100);
    const ReferenceImage reference = renderReference(s, referenceCamera(camera));
    EXPECT_GT(*std::max_element(reference.alpha.begin(), reference.alpha.end()), 0.9999);
    expectSameImage("alpha to 1, T to 0", drawSoftware(s, camera), reference, kBarDb);
}

TEST(HardCases, hundredThousandEqualDepthKeys) {
    StaticSplatData s = randomStaticSplats(51, 100000, 0, 0.004f);
    for (Vec3f& p : s.position) p.z = 0;
    Cameraf camera;  // looks along +z, so every depth is exactly 2
    camera.widthPx = 128, camera.heightPx = 96, camera.fx = camera.fy = 120, camera.cx = 64, camera.cy = 48;
    camera.viewFromWorldTranslation = {0, 0, 2};
    const ReferenceImage reference = renderReference(s, referenceCamera(camera));
    ASSERT_GT(coverage(reference.alpha), 0.3);
    expectSameImage("1e5 equal keys", drawSoftware(s, camera), reference, kBarDb);
}

TEST(HardCases, emptyOneSplatOneTriangleOnePixel) {
    ReferenceScene scene = flatTriangle();
    const Cameraf camera = lookAt({0.03f, 0.03f, 1}, {0.03f, 0.03f, 0}, 50, 50, 300),
                  pixel = lookAt({0.03f, 0.03f, 1}, {0.03f, 0.03f, 0}, 1, 1, 30);
    EXPECT_EQ(coverage(check("empty", scene, camera).alpha, 0), 0);
    scene.splats = {splat(0.02, 0.03)};
    EXPECT_GT(coverage(check("one splat", scene, camera).alpha), 0.01);
    EXPECT_GT(coverage(check("one pixel", scene, pixel).alpha, 0.01), 0.5);
}

TEST(HardCases, offAxisFrustum) {
    const AvatarData avatar = randomAvatar(61, 8, 4);
    Cameraf camera = lookAt({0.5f, 1.2f, 1.6f}, {0, 1, 0}, 150, 130, 140);
    camera.cx = 20.3f, camera.cy = 100.7f, camera.fy = 170;
    EXPECT_GT(coverage(check("off-axis frustum", sceneOf(avatar, randomPose(avatar, 2)), camera).alpha), 0.05);
}

TEST(HardCases, clampedJacobianOutsideTheImage) {
    ReferenceScene scene = oneTriangle({1.2, 0, 0}, {1.2, 0.1, 0}, {1.2, 0, 0.1});  // far to the side, its tail reaches into the image
    scene.splats = {splat(0.4, 0.3, 0.4, 0.99)};
    EXPECT_GT(coverage(check("clamped Jacobian", scene, lookAt({0, 0, 1}, {0, 0, 0}, 100, 100, 70)).alpha, 0.004), 0.01);
}

TEST(HardCases, largeTarget) {
    ReferenceScene scene = flatTriangle();
    scene.splats = {splat(0.02, 0.01)};
    const Cameraf camera = lookAt({0.03f, 0.03f, 1}, {0.03f, 0.03f, 0}, 4096, 2048, 2000);
    EXPECT_GT(coverage(check("4096 x 2048", scene, camera).alpha), 1e-4);
}

}  // namespace
}  // namespace dpl
