// SPDX-License-Identifier: Apache-2.0
// Level of detail of the software renderer against the referee, at densities from all splats down to one splat a group.
#include "sdk/visibility/detail.h"
#include "apps/reference/reference_detail.h"
#include "sdk/avatar/posed_mesh.h"
#include "sdk/format/splat_codec.h"
#include "sdk/format/splat_detail.h"
#include "tests/reference/compare_renderers.h"
#include "tests/reference/random_avatar.h"
#include "tests/reference/splat_room.h"

namespace dpl {
namespace {

struct DetailSubject {
    AvatarData avatar;
    CodedSplats coded;
    Pose pose;
    Cameraf camera;

    explicit DetailSubject(uint32_t seed, uint32_t splatsPerTriangle = 12)
        : avatar(randomAvatar(seed, 10, splatsPerTriangle, seed % 4)), pose(randomPose(avatar, seed)) {
        avatar.joints[1].humanoidBone = seed == 1 ? "spine" : seed == 2 ? "leftIndexProximal" : "head";
        coded = *codeSplats(avatar.mesh, avatar.splats);
        measureDetail(avatar, coded);
        avatar.splats = decodeSplats(coded, avatar.mesh.triangles.size());
        camera = lookAt({1.7f * std::sin(float(seed)), 1 + 0.3f * float(seed % 3), 1.7f * std::cos(float(seed))}, {0, 1, 0}, 150 + 7 * seed,
                        200 - 9 * seed, 180);
    }
    double perM2() const {  // density of all splats
        double area = 0;
        for (const SplatChunk& c : coded.chunks)
            for (uint32_t k = 0; k < c.splatCount; ++k) area += double(coded.groups[2 * size_t(&c - coded.chunks.data()) + k / 128].areaM2);
        return double(coded.count()) / area;
    }
    SplatImage draw(const SplatDetail& detail, uint32_t threads = 2, uint32_t* visible = nullptr) const {
        Jobs jobs(threads);
        PosedMesh mesh;
        const ClothLimits cloth(avatar.joints, avatar.mesh, avatar.correctives);
        mesh.pose({avatar.joints, avatar.mesh, avatar.correctives, {}, nullptr, {}, &cloth}, pose, jobs);
        SplatEngine engine(jobs);
        SplatImage image;
        engine.project(coded, mesh.frames(), camera, avatar.kappaPx2, avatar.compensated, 1, detail);
        engine.bin();
        if (visible) *visible = engine.visibleCount();
        engine.blend(image, {.cloth = true, .depth = true});
        return image;
    }
};

TEST(Detail, agreesWithTheRefereeAtEveryDensity) {
    for (uint32_t seed = 1; seed <= 4; ++seed) {
        const DetailSubject s(seed);
        const ReferenceScene full = sceneOf(s.avatar, s.pose);
        const ReferenceImage all =
            renderReference(full, referenceCamera(s.camera), {.kappaPx2 = s.avatar.kappaPx2, .compensated = s.avatar.compensated});
        uint32_t drawnBefore = 0;
        for (const double share : {0.004, 0.03, 0.14, 0.19, 0.45, 0.7}) {
            ReferenceScene scene = full;
            SplatDetail detail{float(s.perM2() * share), 1};
            detail.shShare = detailShShare(float(share));
            reduceReference(scene, s.avatar, s.coded, double(detail.perM2));
            const ReferenceImage want =
                renderReference(scene, referenceCamera(s.camera), {.kappaPx2 = s.avatar.kappaPx2, .compensated = s.avatar.compensated});
            ASSERT_GT(coverage(want.alpha), 0.1);
            EXPECT_LT(compareImages(all.rgb, want.rgb).psnrDb, 75) << "nothing was left out";
            uint32_t drawn = 0;
            const SplatImage image = s.draw(detail, 2, &drawn);
            expectSameImage(formatText("detail {}, avatar {}", share, seed).c_str(), image, want,
                            88);  // as without level of detail; measured 92 and more
            EXPECT_EQ(image.rgb, s.draw(detail, 3).rgb) << "on three threads";
            EXPECT_GT(drawn, drawnBefore);
            drawnBefore = drawn;
        }
    }
}

TEST(Detail, atFullDensityBytesAreThoseWithout) {
    const DetailSubject s(2);
    float smallest = INFINITY;
    for (const SplatGroup& g : s.coded.groups)
        if (g.areaM2 > 0) smallest = std::min(smallest, g.areaM2);
    const SplatImage without = s.draw({}), with = s.draw({1 / smallest * 1.01f, 1});
    EXPECT_EQ(without.rgb, with.rgb);
    EXPECT_EQ(without.alpha, with.alpha);
    EXPECT_FALSE(without.rgb == s.draw({0.5f / smallest, 1}).rgb);
}

/** While the density falls in small steps, the picture changes little, and less for smaller steps. */
TEST(Detail, followsTheDensityWithoutSteps) {
    const DetailSubject s(3);
    const auto largestChange = [&](double ratio, double from, double to) {
        double largest = 0;
        std::vector<float> before;
        for (double share = from; share > to; share *= ratio) {
            const SplatImage image = s.draw({float(s.perM2() * share), detailShShare(float(share))});
            double change = 0;
            for (size_t i = 0; i < before.size(); ++i) change = std::max(change, std::abs(double(image.rgb[i]) - double(before[i])));
            largest = std::max(largest, change);
            before = image.rgb;
        }
        return largest;
    };
    const double coarse = largestChange(0.98, 1.05, 0.3), fine = largestChange(0.995, 1.05, 0.7);
    std::printf("largest change of a value: %.4f in steps of 2 %%, %.4f in steps of 0.5 %%\n", coarse, fine);
    EXPECT_GT(coarse, 0.002);
    EXPECT_LT(coarse, 0.1);  // measured 0.053; a splat that vanished in one step would change pixels by up to its opacity
    EXPECT_LT(fine, 0.6 * coarse);
}

/** A room seen from inside, at a level of detail. */
struct Room {
    StaticSplatData splats;
    PackedSplats packed;
    GeneralDetailSubject subject;

    explicit Room(uint32_t seed, uint32_t count = 9000) : splats(splatRoom(seed, count)) {
        const std::vector<uint32_t> order = spatialOrder(splats.position);
        packed = PackedSplats(splats, order), subject = GeneralDetailSubject(measureGroups(splats, order), splats.count());
    }
    static Cameraf camera(float aside = 0) { return lookAt({0.3f + aside, 0.2f, 3}, {0, 0, 0}, 170, 130, 110); }
    SplatImage draw(std::span<const Cameraf> views, float perPixel, uint32_t threads = 2, uint32_t* visible = nullptr) {
        Jobs jobs(threads);
        SplatEngine engine(jobs);
        SplatImage image;
        subject.look(views);
        engine.project(packed, {}, views[0], splats.kappaPx2, false, 1, {subject.detail(perPixel), subject.groups()});
        engine.bin();
        if (visible) *visible = engine.visibleCount();
        engine.blend(image, {.cloth = true, .depth = true});
        return image;
    }
    std::vector<float> shares(const Cameraf& view, float perPixel) {
        subject.look({&view, 1});
        const GeneralDetail detail = subject.detail(perPixel);
        std::vector<float> out;
        for (const GeneralGroup& g : subject.groups()) {
            const float pixelM = detail.pixelM(g.middle, g.reach);
            out.push_back(keptShare(perPixel, g.detail.areaM2 / (pixelM * pixelM)));
        }
        return out;
    }
};

TEST(Detail, ofGeneralSplatsAgreesWithTheRefereeNearAndFar) {
    for (uint32_t seed = 1; seed <= 3; ++seed) {
        Room room(seed, 9000 + 37 * seed);                                               // the last group is not full
        const Cameraf views[2] = {Room::camera(), Room::camera(seed == 2 ? -0.5f : 0)};  // the finer of two views decides
        const ReferenceImage all = renderReference(room.splats, referenceCamera(views[0]));
        uint32_t drawnBefore = 0;
        for (const double perPixel : {0.003, 0.02, 0.06, 0.2}) {
            const ReferenceImage want = renderReference(reducedSplats(room.splats, {views[0], views[1]}, perPixel),
                                                        referenceCamera(views[0]), {.compensated = false});
            ASSERT_GT(coverage(want.alpha), 0.9);
            EXPECT_LT(compareImages(all.rgb, want.rgb).psnrDb, 60) << "nothing was left out";
            uint32_t drawn = 0;
            const SplatImage image = room.draw(views, float(perPixel), 2, &drawn);
            expectSameImage(formatText("{} splats a pixel, room {}", perPixel, seed).c_str(), image, want, 80);
            EXPECT_EQ(image.rgb, room.draw(views, float(perPixel), 3).rgb) << "on three threads";
            EXPECT_GT(drawn, drawnBefore);
            drawnBefore = drawn;
        }
        const std::vector<float> shares = room.shares(views[0], 0.1f);
        EXPECT_EQ(std::ranges::max(shares), 1) << "near by";
        EXPECT_LT(std::ranges::min(shares), 0.3f) << "far away";
    }
}

TEST(Detail, ofGeneralSplatsAtFullDensityBytesAreThoseWithout) {
    Room room(5, 9005);
    const Cameraf view = Room::camera();
    const SplatImage without = room.draw({&view, 1}, INFINITY);
    EXPECT_EQ(without.rgb, drawSoftware(room.splats, view).rgb);
    EXPECT_EQ(without.rgb, room.draw({&view, 1}, 1e6f).rgb);
    EXPECT_EQ(without.rgb, room.draw({&view, 1}, std::numeric_limits<float>::max()).rgb);
    EXPECT_FALSE(without.rgb == room.draw({&view, 1}, 0.1f).rgb);
}

/** While the camera walks through the room, the picture changes little, and less for shorter steps. */
TEST(Detail, ofGeneralSplatsFollowsTheCameraWithoutSteps) {
    Room room(4);
    // Only level of detail sees the moving camera. The picture is always drawn from one camera, so all changes come from level of detail.
    const Cameraf seen = Room::camera();
    const auto largestChange = [&](float stepM, int steps) {
        double largest = 0;
        std::vector<float> before;
        for (int k = 0; k < steps; ++k) {
            Jobs jobs(2);
            SplatEngine engine(jobs);
            SplatImage image;
            const Cameraf from = lookAt({0.3f, 0.2f, 3 - stepM * float(k)}, {0, 0, -8}, 170, 130, 110);
            room.subject.look({&from, 1});
            engine.project(room.packed, {}, seen, room.splats.kappaPx2, false, 1, {room.subject.detail(0.05f), room.subject.groups()});
            engine.bin();
            engine.blend(image);
            for (size_t i = 0; i < before.size(); ++i) largest = std::max(largest, std::abs(double(image.rgb[i]) - double(before[i])));
            before = image.rgb;
        }
        return largest;
    };
    const double coarse = largestChange(0.04f, 20), fine = largestChange(0.01f, 80);
    std::printf("largest change of a value: %.4f in steps of 4 cm, %.4f in steps of 1 cm\n", coarse, fine);
    EXPECT_GT(coarse, 0.004);
    EXPECT_LT(coarse, 0.03);  // measured 0.009
    EXPECT_LT(fine, 0.5 * coarse);
}

}  // namespace
}  // namespace dpl
