// SPDX-License-Identifier: Apache-2.0
// The software renderer against the referee on random meshes, splats, poses and views.
#include "sdk/avatar/posed_mesh.h"
#include "sdk/format/splat_codec.h"
#include "tests/reference/compare_renderers.h"
#include "tests/reference/random_avatar.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl {
namespace {

// Required of the product: 50 dB. Measured: 120 dB and more; 93 dB where one pixel flips across the 1/255 cut-off. A renderer that loses a
// row of pixels at tile edges measured 60 to 82 dB, so the bar is above that.
constexpr double kSoftwareBarDb = 88;

TEST(SoftwareVsReference, randomAvatarsPosesAndViews) {
    for (uint32_t seed = 1; seed <= 6; ++seed) {
        const AvatarData avatar = randomAvatar(seed, 8, 4, seed % 4);
        const Pose pose = randomPose(avatar, seed);
        const Vec3f eye(1.7f * std::sin(float(seed)), 1 + 0.3f * float(seed % 3), 1.7f * std::cos(float(seed)));
        const Cameraf camera = lookAt(eye, {0, 1, 0}, 150 + 7 * seed, 200 - 9 * seed, 180);
        const ReferenceScene scene = sceneOf(avatar, pose);
        const ReferenceImage reference = renderReference(scene, referenceCamera(camera));
        ASSERT_GT(coverage(reference.alpha), 0.1);
        expectSameImage(("avatar " + std::to_string(seed)).c_str(), drawSoftware(scene, camera), reference, kSoftwareBarDb);
    }
}

/** Draws with the float correctives and skinning of sdk/avatar, as the product does. */
SplatImage drawPosed(const AvatarData& avatar, const Pose& pose, const Cameraf& camera, PosedMesh& mesh) {
    Jobs jobs(2);
    const std::vector<RestTriangle<float>> bind = restTriangles(avatar.mesh);
    const ClothLimits cloth(avatar.joints, avatar.mesh, avatar.correctives);
    mesh.pose({avatar.joints, avatar.mesh, avatar.correctives, {bind}, &avatar.light, {}, &cloth}, pose, jobs);
    SplatEngine engine(jobs);
    const EngineInput splats(sceneOf(avatar, pose));
    SplatImage image;
    engine.project(splats.view(), mesh.frames(), camera, avatar.kappaPx2, avatar.compensated);
    engine.bin();
    engine.blend(image, {.cloth = true, .depth = true});
    return image;
}

TEST(SoftwareVsReference, correctivesMoveAndLightTheSurface) {
    struct Case {
        const char* name;
        test::CorrectiveOptions options;
        bool beyondReach, offTheModes;  // which of the two limits shortens the coefficients
    };
    const Case cases[] = {
        {"correctives, short pose", {.light = 0.2f, .reach = 100}, false, false},
        {"correctives, beyond reach", {.modes = 7, .light = 0.8f, .reach = 0.6f}, true, false},
        {"correctives, light clamped", {.modes = 2, .nodes = 30, .light = 2, .reach = 3}, false, false},
        {"correctives, off the modes", {.offsetM = 0.08f, .light = 1.6f, .reach = 100, .reachOffModes = 0.6f}, false, true}};
    double darkest = 1, brightest = 1;
    uint32_t seed = 0;
    for (const Case& c : cases) {
        ++seed;
        const AvatarData avatar = test::withCorrectives(randomAvatar(seed, 8, 4, seed % 4), seed + 10, c.options);
        const Pose pose = randomPose(avatar, seed);
        const Cameraf camera = lookAt({1.2f, 1.2f, -1.2f}, {0, 1, 0}, 150 + 7 * seed, 200 - 9 * seed, 180);
        const ReferenceScene scene = sceneOf(avatar, pose);
        const ReferenceImage reference = renderReference(scene, referenceCamera(camera));
        ASSERT_GT(coverage(reference.alpha), 0.1);
        PosedMesh mesh;
        expectSameImage(c.name, drawPosed(avatar, pose, camera, mesh), reference, kSoftwareBarDb);

        double positionError = 0, lightError = 0, farthest = 0;
        AvatarData plain = avatar;
        plain.correctives = {};
        const std::vector<glm::dvec3> uncorrected = referenceSkin(plain, pose);
        for (size_t v = 0; v < scene.posed.size(); ++v) {
            positionError = std::max(positionError, glm::length(glm::dvec3(mesh.positions()[v]) - scene.posed[v]));
            lightError = std::max(lightError, std::abs(double(mesh.light()[v]) - scene.light[v]));
            farthest = std::max(farthest, glm::length(uncorrected[v] - scene.posed[v]));
            darkest = std::min(darkest, scene.light[v]), brightest = std::max(brightest, scene.light[v]);
        }
        std::printf("%-34s moved up to %.1f mm; error of positions %.1e m, of light %.1e\n", "", farthest * 1e3, positionError, lightError);
        EXPECT_GT(farthest, 0.005);
        EXPECT_LT(positionError, 2e-6);  // a few float roundings at 1 to 2 m
        EXPECT_LT(lightError, 5e-6);
        const auto length = [](const std::vector<double>& k) {
            double squares = 0;
            for (const double x : k) squares += x * x;
            return std::sqrt(squares);
        };
        PoseCorrectiveData onlyReach = avatar.correctives, unlimited = avatar.correctives;
        onlyReach.reachOffModes = 1e6f;
        unlimited.reach = unlimited.reachOffModes = 1e6f;
        const double free = length(referenceCoefficients(unlimited, pose).k);
        EXPECT_EQ(free > avatar.correctives.reach, c.beyondReach) << c.name << ": " << free;
        EXPECT_EQ(length(referenceCoefficients(avatar.correctives, pose).k) < 0.99 * length(referenceCoefficients(onlyReach, pose).k),
                  c.offTheModes)
            << c.name;
        // Without correctives the picture differs clearly, so the comparison above says something.
        EXPECT_LT(compareImages(renderReference(plain, pose, referenceCamera(camera)).rgb, reference.rgb).psnrDb, 35);
    }
    EXPECT_EQ(darkest, 0.2);
    EXPECT_EQ(brightest, 3.0);
}

TEST(SoftwareVsReference, randomStaticSplatsOfEveryShDegree) {
    for (uint32_t degree = 0; degree <= 3; ++degree) {
        const StaticSplatData splats = randomStaticSplats(degree + 1, 1500, degree);
        const Cameraf camera = lookAt({0.7f, 0.4f, -2.f}, {0, 0, 0}, 211, 173, 200);
        const ReferenceImage reference = renderReference(splats, referenceCamera(camera));
        ASSERT_GT(coverage(reference.alpha), 0.1);
        expectSameImage(("static, SH " + std::to_string(degree)).c_str(), drawSoftware(splats, camera), reference, kSoftwareBarDb);
    }
}

TEST(SoftwareVsReference, staticSplatsWithAnEnergyPreservingLowPass) {
    const StaticSplatData splats = randomStaticSplats(6, 1500, 1);
    const Cameraf camera = lookAt({0.7f, 0.4f, -2.f}, {0, 0, 0}, 211, 173, 200);
    const ReferenceImage reference = renderReference(splats, referenceCamera(camera), {.compensated = true});
    ASSERT_GT(coverage(reference.alpha), 0.1);
    EXPECT_LT(compareImages(renderReference(splats, referenceCamera(camera)).rgb, reference.rgb).psnrDb, 45)
        << "compensation has no effect in this case";
    Jobs jobs(2);
    SplatEngine engine(jobs);
    SplatImage image;
    engine.project(PackedSplats(splats), {}, camera, splats.kappaPx2, true);
    engine.bin();
    engine.blend(image, {.cloth = true, .depth = true});
    expectSameImage("static, compensated", image, reference, kSoftwareBarDb);
}

SplatImage drawFourSamples(const ReferenceScene& scene, const Cameraf& camera, uint32_t threads = 2) {
    Jobs jobs(threads);
    SplatEngine engine(jobs);
    const EngineInput input(scene);
    SplatImage image;
    engine.project(PackedSplats(input.view()), input.frames, camera, float(kKappaPx2), true, kCoverageSamples);
    engine.bin();
    engine.blend(image, {.cloth = true, .depth = true});
    return image;
}

TEST(SoftwareVsReference, fourSamplesAPixelAtHalfAndAQuarterOfTheSize) {
    for (const float size : {0.5f, 0.25f}) {
        for (uint32_t seed = 1; seed <= 6; ++seed) {
            const AvatarData avatar = randomAvatar(seed, 8, 4, seed % 4);
            const Vec3f eye(1.7f * std::sin(float(seed)), 1 + 0.3f * float(seed % 3), 1.7f * std::cos(float(seed)));
            const Cameraf camera = lookAt(eye, {0, 1, 0}, 150 + 7 * seed, 200 - 9 * seed, 180).scaled(size);
            const ReferenceScene scene = sceneOf(avatar, randomPose(avatar, seed));
            const ReferenceImage reference = renderReference(scene, referenceCamera(camera), {.fourSamples = true});
            ASSERT_GT(coverage(reference.alpha), 0.1);
            EXPECT_LT(compareImages(renderReference(scene, referenceCamera(camera)).rgb, reference.rgb).psnrDb, kSoftwareBarDb - 30)
                << "one sample gives the same picture, so this case tests nothing";
            const SplatImage image = drawFourSamples(scene, camera);
            expectSameImage(("four samples, x" + std::to_string(size).substr(0, 4) + ", avatar " + std::to_string(seed)).c_str(), image,
                            reference, kSoftwareBarDb);
            EXPECT_EQ(image.rgb, drawFourSamples(scene, camera, 3).rgb) << "on three threads";
        }
    }
}

TEST(SoftwareVsReference, sameBytesOnAnyThreadCount) {
    const AvatarData avatar = randomAvatar(3, 40, 4);
    const ReferenceScene scene = sceneOf(avatar, randomPose(avatar, 3));
    const Cameraf camera = lookAt({1, 1.2f, 1}, {0, 1, 0}, 250, 190, 200);
    const SplatImage one = drawSoftware(scene, camera, 1);
    EXPECT_GT(coverage(one.alpha), 0.1);
    for (uint32_t threads = 2; threads <= 3; ++threads) {
        const SplatImage many = drawSoftware(scene, camera, threads);
        EXPECT_EQ(one.rgb, many.rgb);
        EXPECT_EQ(one.alpha, many.alpha);
        EXPECT_EQ(one.cloth, many.cloth);
        EXPECT_EQ(one.depthM, many.depthM);
    }
}

// Avatars and general splats added to one picture are sorted and blended as one set of splats.
TEST(SoftwareVsReference, setsThatAreAddedToOnePictureAreSortedTogether) {
    const AvatarData avatars[2] = {randomAvatar(70, 30, 40, 1),
                                   randomAvatar(71, 12, 16, 2)};  // one has more splats than a block of projection, one fewer
    StaticSplatData cloud = randomStaticSplats(5, 300, 3);
    for (Vec3f& p : cloud.position) p.y += 1;
    const Cameraf camera = lookAt({0.9f, 1.2f, 1.1f}, {0, 1, 0}, 150, 130, 120);
    Jobs jobs(2);
    SplatEngine engine(jobs);
    std::vector<ReferenceGaussian> all;
    for (int repeat = 0; repeat < 2; ++repeat) {  // first with growing buffers, then with warm ones
        all.clear();
        for (int k = 0; k < 2; ++k) {
            const CodedSplats coded = *codeSplats(avatars[k].mesh, avatars[k].splats);
            AvatarData decoded = avatars[k];
            decoded.splats = decodeSplats(coded, decoded.mesh.triangles.size());
            const ReferenceScene scene = sceneOf(decoded, randomPose(decoded, uint32_t(k)));
            const EngineInput input(scene);
            if (k == 0)
                engine.project(coded, input.frames, camera, float(kKappaPx2), true);
            else
                engine.add(coded, input.frames, camera, float(kKappaPx2), true);
            for (const ReferenceBoundSplat& s : scene.splats) {
                all.push_back(referenceGaussian(scene, s));
                all.back().shDegree = scene.shDegree;
            }
        }
        engine.add(PackedSplats(cloud), {}, camera, float(kKappaPx2), true);
        for (uint32_t i = 0; i < cloud.count(); ++i) all.push_back(referenceGaussian(cloud, i));
        engine.bin();
    }
    EXPECT_GT(avatars[0].splats.count(), 4096u);
    SplatImage image;
    engine.blend(image, {.cloth = true, .depth = true});
    expectSameImage("three sets", image, renderReference(all, referenceCamera(camera)), 75);
}

// Chunks whose splats all face away are skipped. Decoding must continue at the right chunk after them.
TEST(SoftwareVsReference, wholeChunksThatAreSkippedLeaveTheNextOnesRight) {
    AvatarData a = randomAvatar(60, 24, 16, 0);  // 1,536 splats a ring; half of them, three chunks, face away
    for (uint32_t i = 0; i < a.splats.count(); ++i) {
        a.splats.scaleM[i] *= 0.02f * float(1 + 3 * (i / 256 % 5));  // so that chunks differ in range
        a.splats.flags[i] = kSplatSingleFace;
    }
    auto coded = codeSplats(a.mesh, a.splats, false);
    ASSERT_TRUE(coded) << coded.error().message;
    a.splats = decodeSplats(*coded, a.mesh.triangles.size());
    const ReferenceScene scene = sceneOf(a, Pose::rest(2));
    const EngineInput input(scene);
    for (const float azimuth : {0.f, 1.6f, 3.1f, 4.7f}) {
        const Cameraf camera = lookAt({1.6f * std::sin(azimuth), 1, 1.6f * std::cos(azimuth)}, {0, 1, 0}, 150, 130, 120);
        Jobs jobs(2);
        SplatEngine engine(jobs);
        SplatImage image;
        engine.project(*coded, input.frames, camera, float(kKappaPx2), true);
        engine.bin();
        engine.blend(image, {.cloth = true, .depth = true});
        EXPECT_LT(engine.decodedBytes(), 13u * 9 * coded->count() / 10) << "nothing was skipped";
        expectSameImage("skipped chunks", image, renderReference(scene, referenceCamera(camera)),
                        75);  // two splats at one depth may swap: 78 dB
    }
}

// The renderer keeps codes and decodes only what a view needs. The picture must equal that of all decoded splats.
TEST(SoftwareVsReference, codedSplatsDrawWhatTheyDecodeTo) {
    for (uint32_t round = 0; round < 8; ++round) {
        AvatarData a = randomAvatar(40 + round, 12, 16, round % 4);
        for (Vec2f& s : a.splats.scaleM) s *= 0.2f;  // about the size of its triangle, as on a person
        const uint32_t stride = (a.splats.shDegree + 1) * (a.splats.shDegree + 1) * 3;
        for (uint32_t i = 9; round >= 4 && i < a.splats.count(); ++i)
            std::copy_n(&a.splats.sh[i % 9 * stride + 3], stride - 3, &a.splats.sh[i * stride + 3]);  // nine distinct rows
        auto coded = codeSplats(a.mesh, a.splats, round >= 4);
        ASSERT_TRUE(coded) << coded.error().message;
        EXPECT_EQ(coded->shIndex.empty(), round < 4 || a.splats.shDegree == 0);
        a.splats = decodeSplats(*coded, a.mesh.triangles.size());
        const ReferenceScene scene = sceneOf(a, randomPose(a, round));
        const EngineInput input(scene);
        const Cameraf camera = lookAt({0.9f * std::sin(float(round)), 1.1f, 0.9f * std::cos(float(round))}, {0.1f * float(round % 3), 1, 0},
                                      150, 130, round % 2 ? 500 : 120);
        Jobs jobs(2);
        SplatEngine engine(jobs), plain(jobs);
        SplatImage image, all;
        engine.project(*coded, input.frames, camera, float(kKappaPx2), true);
        engine.bin();
        engine.blend(image, {.cloth = true, .depth = true});
        plain.project(input.view(), input.frames, camera, float(kKappaPx2));
        plain.bin();
        plain.blend(all);
        expectSameImage(("coded, round " + std::to_string(round)).c_str(), image, renderReference(scene, referenceCamera(camera)), 80);
        EXPECT_NEAR(double(engine.visibleCount()), double(plain.visibleCount()), 1) << "one splat may stand at the edge of 1/255";
        EXPECT_GT(plain.visibleCount(), 20u);
        for (size_t i = 0; i < engine.projected().size(); ++i)
            ASSERT_NEAR(engine.projected()[i].opacity, plain.projected()[i].opacity, 1e-2) << "splat " << i;
        // Deciding reads one or five bytes a splat; decoding reads all bytes of packed groups with a visible splat.
        const uint64_t n = coded->count(),
                       each = 13 + (coded->shIndex.empty() ? 0 : 2) + (a.splats.shDegree ? shEntryBytes(a.splats.shDegree) : 0);
        EXPECT_GE(engine.decidedBytes(), n / 16);
        EXPECT_LE(engine.decidedBytes(), 5 * n);
        EXPECT_GE(engine.decodedBytes(), plain.visibleCount() * each);
        EXPECT_LE(engine.decodedBytes(), n * each);
        if (round % 2) {
            EXPECT_LT(engine.decodedBytes(), n * each * 3 / 4) << "most of it is out of this view";
        }
    }
}

}  // namespace
}  // namespace dpl
