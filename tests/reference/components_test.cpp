// SPDX-License-Identifier: Apache-2.0
// Component culling against the referee: components that are left out show nothing, for random rigs, poses, correctives, lenses and
// cameras.
#include "sdk/visibility/components.h"

#include <gtest/gtest.h>

#include <bit>

#include "apps/reference/reference_renderer.h"
#include "sdk/avatar/pose_correctives.h"
#include "sdk/format/splat_codec.h"
#include "tests/reference/corrective_cases.h"

namespace dpl {
namespace {

/** An avatar whose splats are those that its codes decode to. */
struct ComponentSubject {
    AvatarData avatar;
    CodedSplats coded;
    ComponentMap map;
    Components components;

    explicit ComponentSubject(AvatarData a) : avatar(std::move(a)) {
        const size_t triangles = avatar.mesh.triangles.size();
        coded = *codeSplats(avatar.mesh, avatar.splats);
        avatar.splats = decodeSplats(coded, triangles);
        map = componentsOf(avatar);
        components = Components(avatar, map, reachOfTriangles(coded, triangles));
    }
};

/** Bits of the components of which the referee has the box of a splat, or a vertex beyond the near plane, in the picture. */
uint32_t seenByReferee(const ComponentSubject& s, const ReferenceScene& scene, const Cameraf& view, double growth) {
    const ReferenceCamera camera = referenceCamera(view);
    uint32_t bits = 0;
    for (ReferenceBoundSplat splat : scene.splats) {
        splat.scaleM *= growth;
        const ReferenceFootprint f = projectReference(referenceGaussian(scene, splat), camera);
        if (!f.visible || !(splat.opacity > 1.0 / 255)) continue;
        const double level = 2 * std::log(255 * splat.opacity);
        const glm::dvec2 reach(std::sqrt(level * f.covariance[0][0]), std::sqrt(level * f.covariance[1][1]));
        if (f.centrePx.x + reach.x > 0 && f.centrePx.y + reach.y > 0 && f.centrePx.x - reach.x < camera.widthPx &&
            f.centrePx.y - reach.y < camera.heightPx)
            bits |= 1u << s.map.ofTriangle[splat.triangle];
    }
    for (size_t v = 0; v < scene.posed.size(); ++v) {
        const glm::dvec3 p = camera.rotation * scene.posed[v] + camera.translation;
        const double x = camera.fx * p.x / p.z + camera.cx, y = camera.fy * p.y / p.z + camera.cy;
        if (p.z > 0.05 && x >= 0 && y >= 0 && x <= camera.widthPx && y <= camera.heightPx && s.map.ofVertex[v] != ~0u)
            bits |= s.map.ofVertex[v];
    }
    return bits;
}

/** A camera at `eye`, turned from `target` in the direction of `towards` by 3 · aside radians: 0 looks at the target, 1 away from it. */
Cameraf viewPast(const Vec3f& target, const Vec3f& eye, const Vec3f& towards, float aside, const Cameraf& lens) {
    const Vec3f at = glm::normalize(target - eye);
    const Vec3f forward =
        glm::normalize(std::cos(3.0f * aside) * at + std::sin(3.0f * aside) * glm::normalize(towards - glm::dot(towards, at) * at));
    Cameraf c = lookAt(eye, eye + forward, lens.widthPx, lens.heightPx, lens.fx);
    c.cx = lens.cx, c.cy = lens.cy;
    return c;
}

struct Case {
    const char* name;
    bool corrected = false, overshooting = false;
    float scale = 1;    // of the splats
    float turnRad = 0;  // of every joint, at random
    float growth = 1;
    bool torn = false;     // every vertex follows one joint alone, so triangles between joints are torn apart
    float correction = 1;  // of the offsets
    bool wide = false;     // views of 136 degrees
    bool expresses = false;
};

// Each view is turned by bisection to the angle at which the referee sees a component just no more. There the bound is tightest.
TEST(Components, whatIsLeftOutShowsNothing) {
    constexpr Case kCases[] = {{"rest"},
                               {"large splats", false, false, 20},
                               {"larger ones, wide lens", false, false, 60, 0, 1, false, 1, true},
                               {"splats off their triangles", false, true, 0.1f},
                               {"turned", false, false, 1, 0.4f},
                               {"torn", false, false, 10, 0.8f, 1, true},
                               {"torn, off their triangles", false, true, 0.1f, 1.2f, 1, true},
                               {"level of detail", false, false, 30, 0, 2.5f},
                               {"correctives", true, false, 1, 0.2f},
                               {"correctives of half a metre", true, false, 0.1f, 0, 1, false, 20},
                               {"large splats on them", true, false, 60, 0, 1, false, 40},
                               {"correctives, off their triangles", true, true, 0.1f, 0.1f, 1, false, 20},
                               {"expressions", false, false, 1, 0.2f, 1, false, 1, false, true},
                               {"expressions beside correctives", true, true, 0.1f, 0.1f, 1, false, 1, false, true}};
    std::mt19937 random(11);
    std::uniform_real_distribution<float> uniform(0, 1);
    std::normal_distribution<float> normal;
    for (const Case& c : kCases) {
        uint32_t edges = 0, left = 0, beyond = 0, wrong = 0;
        for (uint32_t seed = 0; seed < 3; ++seed) {
            AvatarData avatar = randomPerson(seed + 1, c.corrected, c.overshooting);
            for (Vec2f& scale : avatar.splats.scaleM) scale *= c.scale;
            for (Vec4f& node : avatar.correctives.nodes) node = Vec4f(c.correction * Vec3f(node), node.w);
            for (size_t v = 0; c.torn && v < avatar.mesh.jointWeights.size(); ++v) avatar.mesh.jointWeights[v] = glm::u8vec4(255, 0, 0, 0);
            if (c.expresses) avatar = test::withExpressions(std::move(avatar), seed, 6, 0.08f);
            const ComponentSubject subject(std::move(avatar));
            ASSERT_GE(subject.components.count(), 3u);
            Pose pose = Pose::rest(subject.avatar.joints.size());
            for (Quatf& q : pose.localRotations)
                q = glm::angleAxis(c.turnRad * normal(random), glm::normalize(Vec3f(normal(random), normal(random), normal(random))));
            pose.rootTranslation = Vec3f(normal(random), normal(random), normal(random));
            std::vector<Mat3x4f> worldFromRest;
            std::vector<float> coefficients;
            std::vector<Vec4f> nodes;
            jointTransforms(subject.avatar.joints, pose, worldFromRest);
            if (c.expresses) pose.expression = test::randomWeights(random);
            if (c.corrected || c.expresses) correctiveCoefficients(subject.avatar.correctives, pose, coefficients);
            nodes.resize(subject.avatar.correctives.nodeCount);
            addExpression(subject.avatar.expressions, pose.expression, coefficients, nodes);
            const ReferenceScene scene = sceneOf(subject.avatar, pose);
            for (int round = 0; round < 24; ++round) {
                const auto around = [&](float reach) {
                    return reach * Vec3f(2 * uniform(random) - 1, 2 * uniform(random) - 1, 2 * uniform(random) - 1);
                };
                const Vec3f target = Vec3f(scene.posed[random() % scene.posed.size()]),
                            eye = target + (0.3f + 2 * uniform(random)) * glm::normalize(around(1)), towards = around(1);
                Cameraf lens;
                lens.widthPx = 200, lens.heightPx = 150, lens.fx = lens.fy = c.wide ? 40 : 60 + 400 * uniform(random) * uniform(random);
                lens.cx = 100 + 80 * (uniform(random) - 0.5f), lens.cy = 75 + 80 * (uniform(random) - 0.5f);
                const auto seenAt = [&](float aside) {
                    return seenByReferee(subject, scene, viewPast(target, eye, towards, aside, lens), double(c.growth));
                };
                const auto leftAt = [&](float aside) {
                    const Cameraf view = viewPast(target, eye, towards, aside, lens);
                    return subject.components.unseen(worldFromRest, coefficients, {&view, 1}, float(kKappaPx2), c.growth);
                };
                const uint32_t atFirst = seenAt(0), atLast = seenAt(1);
                beyond += subject.components.count() - uint32_t(std::popcount(atLast)), left += uint32_t(std::popcount(leftAt(1)));
                wrong += uint32_t(std::popcount(leftAt(0) & atFirst)) + uint32_t(std::popcount(leftAt(1) & atLast));
                uint32_t candidates = atFirst & ~atLast;
                if (candidates == 0) continue;
                const uint32_t which = 1u << (31 - std::countl_zero(candidates));
                float seen = 0, gone = 1;
                for (int step = 0; step < 10; ++step) (seenAt(0.5f * (seen + gone)) & which ? seen : gone) = 0.5f * (seen + gone);
                wrong += uint32_t(std::popcount(leftAt(seen) & seenAt(seen)));
                ++edges;
            }
        }
        std::printf("[ COMPONENTS] %-34s %2u edges, %3u components turned away from, %3u of them left out\n", c.name, edges, beyond, left);
        EXPECT_EQ(wrong, 0u) << c.name;
        EXPECT_GE(edges, 8u) << c.name;
        EXPECT_GT(left, c.overshooting ? beyond / 16 : beyond / 2)
            << c.name << ": a bound that never leaves anything out is sound and useless";
    }
}

TEST(Components, aPersonOutOfViewIsLeftOutAndOneInViewIsNot) {
    const ComponentSubject subject(randomPerson(3, true, false));
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

TEST(Components, nodesThatArePushedBringAPersonIntoView) {
    const ComponentSubject subject(randomPerson(3, true, false));
    std::vector<Mat3x4f> worldFromRest;
    jointTransforms(subject.avatar.joints, Pose::rest(subject.avatar.joints.size()), worldFromRest);
    const Cameraf view = lookAt({0, 1, 3}, {4, 1, 2}, 200, 150, 150);
    const auto unseen = [&](float pushedM) {
        return subject.components.unseen(worldFromRest, {}, {&view, 1}, float(kKappaPx2), 1, 1, pushedM);
    };
    EXPECT_EQ(unseen(0), subject.components.all());
    EXPECT_EQ(unseen(5), 0u) << "vertices may lie 5 m off";
}

// Transforms that are not finite, and weights that do not sum to 255, leave nothing out.
TEST(Components, nothingIsLeftOutForNumbersThatSayNothing) {
    ComponentSubject subject(randomPerson(4, false, false));
    const Pose pose = Pose::rest(subject.avatar.joints.size());
    std::vector<Mat3x4f> worldFromRest;
    jointTransforms(subject.avatar.joints, pose, worldFromRest);
    const Cameraf view = lookAt({0, 1, 3}, {0, 1, 6}, 200, 150, 150);
    ASSERT_NE(subject.components.unseen(worldFromRest, {}, {&view, 1}, float(kKappaPx2), 1), 0u);
    for (Mat3x4f& m : worldFromRest) m[3] = Vec3f(NAN);
    EXPECT_EQ(subject.components.unseen(worldFromRest, {}, {&view, 1}, float(kKappaPx2), 1), 0u);
    subject.avatar.mesh.jointWeights[5].x += 1;
    EXPECT_EQ(Components(subject.avatar, subject.map, reachOfTriangles(subject.coded, subject.map.ofTriangle.size())).count(), 0u)
        << "weights that do not add up";
}

}  // namespace
}  // namespace dpl
