// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/init.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/recon_trainer/toy_scene.h"

namespace dpl::test {
namespace {

/** Splats of each triangle, drawn around by the toy scene's cameras. shownLabel: label of every pixel; 0: pictures without labels. */
std::vector<uint32_t> splatsPerTriangle(const MeshData& mesh, Jobs& jobs, std::span<const uint8_t> labels = {}, uint8_t shownLabel = 0) {
    const CoOptimiseInput scene = toyScene(jobs);
    const std::vector<TrainFrame> frames = shownLabel == 0 ? scene.frames : labelled(scene.frames, shownLabel);
    const TriangleSight sight = *triangleSight({scene.joints, mesh, labels, frames}, jobs);
    InitSettings init;
    init.splatCount = 6000, init.shDegree = 0;
    const auto flags = triangleFlags(mesh.restPositions, mesh.triangles, {}, {}, init);
    const TrainableSplats splats = *initialSplats({scene.joints, mesh, labels, frames}, flags, sight, init, 1, jobs);
    std::vector<uint32_t> count(mesh.triangles.size(), 0);
    for (const uint32_t t : splats.triangle) ++count[t];
    return count;
}

TEST(InitialSplats, bodyBelowClothesHasNoneAndClothesAreCovered) {
    Jobs jobs(2);
    const MeshData mesh = dressedBall(0);
    const auto count = splatsPerTriangle(mesh, jobs);
    const size_t body = mesh.layers[0].triangleCount;
    EXPECT_EQ(std::count_if(count.begin(), count.begin() + long(body), [](uint32_t n) { return n > 0; }), 0);
    for (size_t t = body; t < count.size(); ++t) ASSERT_GT(count[t], 0u) << "garment triangle " << t;
}

TEST(InitialSplats, bodyNearAHemHasSplats) {
    Jobs jobs(2);
    const size_t open = 500;
    const MeshData mesh = dressedBall(open);
    const auto count = splatsPerTriangle(mesh, jobs);
    const size_t body = mesh.layers[0].triangleCount;
    EXPECT_GT(count[body - open / 2], 0u) << "bare skin below the hem";
    EXPECT_EQ(count[0], 0u) << "the pole at the other end is covered";
}

TEST(InitialSplats, bodyWherePicturesShowClothesHasNone) {
    Jobs jobs(2);
    const MeshData mesh = dressedBall(500);
    constexpr uint8_t kBody = 1, kCloth = 2;
    std::vector<uint8_t> labels(mesh.triangles.size(), kCloth);
    const size_t body = mesh.layers[0].triangleCount;
    std::fill_n(labels.begin(), body, kBody);
    const auto bodySplats = [&](uint8_t shown) {
        const auto count = splatsPerTriangle(mesh, jobs, labels, shown);
        return std::count_if(count.begin(), count.begin() + long(body), [](uint32_t n) { return n > 0; });
    };
    EXPECT_EQ(bodySplats(kCloth), 0) << "the open patch shows cloth in every picture: the posed garment lies elsewhere than the true one";
    EXPECT_GT(bodySplats(kBody), 100) << "bare skin";
    EXPECT_EQ(bodySplats(3), bodySplats(kBody)) << "what has no layer of its own is painted on the body";
}

TEST(TriangleSight, pixelsHereAndThereAreNotSeen) {
    Jobs jobs(2);
    const CoOptimiseInput scene = toyScene(jobs);
    const auto seenBelow = [&](uint32_t step) {  // pictures whose masks show one pixel in step² of their lower halves
        std::vector<TrainFrame> frames = scene.frames;
        for (TrainFrame& frame : frames) {
            FramePicture picture = **frame.picture.get();
            for (uint32_t y = picture.mask.heightPx / 2; y < picture.mask.heightPx; ++y)
                for (uint32_t x = 0; x < picture.mask.widthPx; ++x)
                    if (x % step != 0 || y % step != 0) picture.mask.pixels[y * picture.mask.widthPx + x] = 0;
            frame.picture = std::make_shared<const FramePicture>(std::move(picture));
        }
        const TriangleSight sight = *triangleSight({scene.joints, scene.mesh, {}, frames}, jobs);
        size_t seen = 0;
        for (size_t t = 0; t < sight.seen.size(); ++t) {
            const Triangle& corner = scene.mesh.triangles[t];
            float highest = -1;
            for (int c = 0; c < 3; ++c) highest = std::max(highest, scene.mesh.restPositions[corner[c]].y);
            if (highest < -0.08f) seen += sight.seen[t];
        }
        return seen;
    };
    EXPECT_GT(seenBelow(1), 60u);
    EXPECT_LT(seenBelow(8), 5u);
}

TEST(TriangleSight, onePictureIsEnough) {
    Jobs jobs(2);
    const CoOptimiseInput scene = toyScene(jobs);
    const auto seen = triangleSight({scene.joints, scene.mesh, {}, std::span(scene.frames.data(), 1)}, jobs)->seen;
    EXPECT_GT(std::count(seen.begin(), seen.end(), uint8_t(1)), long(seen.size()) / 4) << "most of what faces it";
}

TEST(InitialSplats, oneLayerKeepsItsUnseenTriangles) {
    Jobs jobs(2);
    MeshData mesh = dressedBall(0);
    mesh.layers = {{"body", "body", 0, uint32_t(mesh.restPositions.size()), 0, uint32_t(mesh.triangles.size())}};
    const auto count = splatsPerTriangle(mesh, jobs);
    EXPECT_GT(*std::min_element(count.begin(), count.end()), 0u);
}

TEST(InitialSplats, unseenSplatsTakeTheColourOfTheirNeighbours) {
    Jobs jobs(2);
    const CoOptimiseInput scene = toyScene(jobs);
    std::vector<TrainFrame> front;  // these cameras do not see the back of the ball
    for (const TrainFrame& frame : scene.frames)
        if (frame.camera.eye().z > 0.5) front.push_back(frame);
    ASSERT_FALSE(front.empty());
    for (TrainFrame& frame : front) {  // a picture that is red above and blue below
        FramePicture picture = **frame.picture.get();
        for (size_t i = 0; i < picture.mask.pixels.size(); ++i) {
            const bool above = i / frame.camera.widthPx < frame.camera.heightPx / 2;
            picture.image.pixels[i * 3] = above ? 255 : 0, picture.image.pixels[i * 3 + 1] = 0,
                                     picture.image.pixels[i * 3 + 2] = above ? 0 : 255;
        }
        frame.picture = std::make_shared<const FramePicture>(std::move(picture));
    }
    const TriangleSight sight = *triangleSight({scene.joints, scene.mesh, {}, front}, jobs);
    ASSERT_GT(std::count(sight.seen.begin(), sight.seen.end(), uint8_t(0)), 20);
    InitSettings init;
    init.splatCount = 3000, init.shDegree = 0;
    const auto flags = triangleFlags(scene.mesh.restPositions, scene.mesh.triangles, {}, {}, init);
    const TrainableSplats splats = *initialSplats({scene.joints, scene.mesh, {}, front}, flags, sight, init, 1, jobs);
    size_t checked = 0;
    for (uint32_t i = 0; i < splats.count(); ++i) {
        const Triangle& t = scene.mesh.triangles[splats.triangle[i]];
        const Vec3f p = (scene.mesh.restPositions[t.x] + scene.mesh.restPositions[t.y] + scene.mesh.restPositions[t.z]) / 3.0f;
        if (sight.seen[splats.triangle[i]] || std::abs(p.y) < 0.13f) continue;
        const float* sh = splats.rows.data() + i * splats.stride + kRowSh;
        EXPECT_GT(p.y > 0 ? sh[0] - sh[2] : sh[2] - sh[0], 1.0f) << "splat " << i << " at height " << p.y;
        ++checked;
    }
    EXPECT_GT(checked, 30u);
}

}  // namespace
}  // namespace dpl::test
