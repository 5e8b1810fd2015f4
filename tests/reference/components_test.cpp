// Components that are left out show nothing: against the double reference, over rigs, poses, correctives, lenses and places of the camera.
#include "sdk/avatar/components.h"

#include <gtest/gtest.h>

#include <bit>

#include "sdk/avatar/pose_correctives.h"
#include "sdk/format/splat_codec.h"
#include "tests/reference/corrective_cases.h"
#include "tests/reference/reference_renderer.h"

namespace dpl {
namespace {

/** What is drawn of it is what its codes say. */
struct Subject {
    AvatarData avatar;
    CodedSplats coded;
    ComponentMap map;
    Components components;

    Subject(uint32_t seed, bool corrected, bool overshooting) : avatar(randomPerson(seed, corrected, overshooting)) {
        const size_t triangles = avatar.mesh.triangles.size();
        coded = *codeSplats(avatar.mesh, avatar.splats);
        avatar.splats = decodeSplats(coded, triangles);
        map = componentsOf(avatar);
        components = Components(avatar, map, reachOfTriangles(coded, triangles));
    }
};

/** Bits of the components of which the referee sees a splat's box or, in front of the eye, a vertex. */
uint32_t seenByReferee(const Subject& s, const ReferenceScene& scene, const Cameraf& view, double growth) {
    const ReferenceCamera camera = referenceCamera(view);
    uint32_t bits = 0;
    for (ReferenceBoundSplat splat : scene.splats) {
        splat.scaleM *= growth;
        const ReferenceFootprint f = projectReference(referenceGaussian(scene, splat), camera);
        if (!f.visible || !(splat.opacity > 1.0 / 255)) continue;
        const double level = 2 * std::log(255 * splat.opacity);
        const glm::dvec2 reach(std::sqrt(level * f.covariance[0][0]), std::sqrt(level * f.covariance[1][1]));
        if (f.centrePx.x + reach.x > 0 && f.centrePx.y + reach.y > 0 && f.centrePx.x - reach.x < camera.widthPx && f.centrePx.y - reach.y < camera.heightPx) bits |= 1u << s.map.ofTriangle[splat.triangle];
    }
    for (size_t v = 0; v < scene.posed.size(); ++v) {
        const glm::dvec3 p = camera.rotation * scene.posed[v] + camera.translation;
        const double x = camera.fx * p.x / p.z + camera.cx, y = camera.fy * p.y / p.z + camera.cy;
        if (p.z > 0.05 && x >= 0 && y >= 0 && x <= camera.widthPx && y <= camera.heightPx && s.map.ofVertex[v] != ~0u) bits |= s.map.ofVertex[v];
    }
    return bits;
}

Cameraf anyView(std::mt19937& random, const Vec3f& middle) {
    std::uniform_real_distribution<float> uniform(0, 1);
    const auto around = [&](float reach) { return reach * Vec3f(2 * uniform(random) - 1, 2 * uniform(random) - 1, 2 * uniform(random) - 1); };
    const Vec3f eye = middle + around(2.5f);
    Cameraf c = lookAt(eye, eye + around(1) + 0.4f * (middle - eye), 200, 150, 40 + 400 * uniform(random) * uniform(random));
    c.cx += 80 * (uniform(random) - 0.5f), c.cy += 80 * (uniform(random) - 0.5f);
    return c;
}

TEST(Components, whatIsLeftOutShowsNothing) {
    std::mt19937 random(11);
    uint32_t left = 0, leftOfMild = 0, empty = 0, emptyOfMild = 0, shown = 0, wrong = 0;
    for (uint32_t seed = 0; seed < 8; ++seed) {
        const Subject subject(seed + 1, seed % 2 == 1, seed % 4 >= 2);
        ASSERT_GE(subject.components.count(), 3u);
        const std::vector<Pose> poses = correctivePoses(subject.avatar.joints.size(), seed);
        for (size_t p = 0; p < poses.size(); ++p) {
            const Pose& pose = poses[p];
            const bool mild = p < 5;   // joints turned by 0.2 at most: later ones tear the blob apart, and its bounds with it
            std::vector<Mat3x4f> worldFromRest;
            std::vector<float> coefficients;
            jointTransforms(subject.avatar.joints, pose, worldFromRest);
            if (!subject.avatar.correctives.empty()) correctiveCoefficients(subject.avatar.correctives, pose, coefficients);
            const ReferenceScene scene = sceneOf(subject.avatar, pose);
            const Vec3f middle = worldFromRest[0] * Vec4f(0, 1, 0, 1);
            for (int round = 0; round < 12; ++round) {
                const Cameraf views[2] = {anyView(random, middle), anyView(random, middle)};
                const size_t viewCount = round % 4 == 0 ? 2 : 1;
                const float growth = round % 3 == 0 ? 2.5f : 1.0f;
                uint32_t seen = 0;
                for (size_t v = 0; v < viewCount; ++v) seen |= seenByReferee(subject, scene, views[v], double(growth));
                const uint32_t unseen = subject.components.unseen(worldFromRest, coefficients, {views, viewCount}, float(kKappaPx2), growth);
                ASSERT_EQ(unseen & ~subject.components.all(), 0u);
                wrong += uint32_t(std::popcount(unseen & seen));
                if (mild) leftOfMild += uint32_t(std::popcount(unseen)), emptyOfMild += subject.components.count() - uint32_t(std::popcount(seen));
                left += uint32_t(std::popcount(unseen)), shown += uint32_t(std::popcount(seen)), empty += subject.components.count() - uint32_t(std::popcount(seen));
            }
        }
    }
    std::printf("[ COMPONENTS] %u shown, %u not, %u of these left out; of mild poses %u of %u\n", shown, empty, left, leftOfMild, emptyOfMild);
    EXPECT_EQ(wrong, 0u);
    EXPECT_GT(shown, 500u);
    EXPECT_GT(leftOfMild, emptyOfMild / 3) << "a bound that never leaves anything out is sound and useless";
}

TEST(Components, aPersonOutOfViewIsLeftOutAndOneInViewIsNot) {
    const Subject subject(3, true, false);
    const Pose pose = Pose::rest(subject.avatar.joints.size());
    std::vector<Mat3x4f> worldFromRest;
    jointTransforms(subject.avatar.joints, pose, worldFromRest);
    const auto unseen = [&](const Vec3f& eye, const Vec3f& target) {
        const Cameraf view = lookAt(eye, target, 200, 150, 150);
        return subject.components.unseen(worldFromRest, {}, {&view, 1}, float(kKappaPx2), 1);
    };
    EXPECT_EQ(unseen({0, 1, 3}, {0, 1, 0}), 0u);
    EXPECT_EQ(unseen({0, 1, 3}, {0, 1, 6}), subject.components.all()) << "behind";
    EXPECT_EQ(unseen({0, 1, 3}, {4, 1, 2}), subject.components.all()) << "to the left";
    EXPECT_EQ(unseen({0, 1, 3}, {0, 7, 2}), subject.components.all()) << "below";
}

// Numbers that say nothing leave nothing out: what is drawn then is for the renderer to decide.
TEST(Components, nothingIsLeftOutForNumbersThatSayNothing) {
    Subject subject(4, false, false);
    const Pose pose = Pose::rest(subject.avatar.joints.size());
    std::vector<Mat3x4f> worldFromRest;
    jointTransforms(subject.avatar.joints, pose, worldFromRest);
    const Cameraf view = lookAt({0, 1, 3}, {0, 1, 6}, 200, 150, 150);
    ASSERT_NE(subject.components.unseen(worldFromRest, {}, {&view, 1}, float(kKappaPx2), 1), 0u);
    for (Mat3x4f& m : worldFromRest) m[3] = Vec3f(NAN);
    EXPECT_EQ(subject.components.unseen(worldFromRest, {}, {&view, 1}, float(kKappaPx2), 1), 0u);
    subject.avatar.mesh.jointWeights[5].x += 1;
    EXPECT_EQ(Components(subject.avatar, subject.map, reachOfTriangles(subject.coded, subject.map.ofTriangle.size())).count(), 0u) << "weights that do not add up";
}

}  // namespace
}  // namespace dpl
