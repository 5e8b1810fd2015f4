// SPDX-License-Identifier: Apache-2.0
// FrameCache alone, on the null backend: who owns a target, which frames are kept, and that the cache submits nothing.
#include <gtest/gtest.h>

#include <cstdio>

#include "sdk/backend/null/null_backend.h"
#include "sdk/format/splat_codec.h"
#include "sdk/render/frame_cache.h"
#include "tests/unit/render/tube_avatar.h"

namespace dpl {
namespace {

struct CacheSetup {
    std::shared_ptr<NullRecord> record = std::make_shared<NullRecord>();
    std::unique_ptr<Backend> backend = std::move(*createNullBackend(record, {}));
    AvatarStore store{*backend};
    std::vector<uint64_t> freed;
    FrameCache cache{*backend, store, [this](const RecordedFrame& frame) { freed.push_back(frame.key); }};

    RenderAvatarId add() {
        const auto tube = std::make_shared<const AvatarData>(makeTube({.splatsPerTriangle = 2, .rings = 6}));
        const RenderAvatarId id = *store.begin(std::move(*store.prepareAvatar(tube, *codeSplats(tube->mesh, tube->splats))));
        EXPECT_TRUE(store.finishUpload(id));
        return id;
    }
    RecordedFrame* own(SceneSet& set, const FrameShape& shape) {
        return *cache.frame(set, shape, [&](const TargetDesc& desc) { return FrameTarget::create(*backend, desc); });
    }
};

constexpr FrameShape kShape{.widthPx = 32, .heightPx = 16, .views = 1};

TEST(FrameCache, recordsIntoATargetOfTheCallerAndSubmitsNothing) {
    CacheSetup s;
    SceneSet& set = **s.cache.sceneSet(std::vector{s.add()});
    TargetId lent;
    const auto frame = s.cache.frame(set, kShape, [&](const TargetDesc& desc) -> Result<FrameTarget> {
        EXPECT_EQ(desc.widthPx, 32u);
        lent = *s.backend->createTarget(desc);
        return FrameTarget::lent(lent);
    });
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ((*frame)->ids.target, lent);
    EXPECT_EQ(s.record->liveFrames, kFramesInFlight);
    EXPECT_EQ(s.record->runs, 0u);
    s.cache.remove(set.members[0]);
    EXPECT_EQ(s.record->liveFrames, 0u);
    EXPECT_EQ(s.record->liveTargets, 1u) << "the caller's target stays";
    s.backend->destroyTarget(lent);
}

TEST(FrameCache, destroysATargetThatItWasGiven) {
    CacheSetup s;
    SceneSet& set = **s.cache.sceneSet(std::vector{s.add()});
    s.own(set, kShape);
    EXPECT_EQ(s.record->liveTargets, 1u);
    s.cache.remove(set.members[0]);
    EXPECT_EQ(s.record->liveTargets, 0u);
}

TEST(FrameCache, asksForNoTargetWhereTilesFill) {
    CacheSetup s;
    SceneSet& set = **s.cache.sceneSet(std::vector{s.add()});
    FrameShape shape = kShape;
    shape.fill = Fill::Tiles;
    const auto frame = s.cache.frame(set, shape, [&](const TargetDesc&) -> Result<FrameTarget> { return fail(Code::Internal, "asked"); });
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_FALSE((*frame)->ids.target);
    EXPECT_TRUE((*frame)->ids.tilePixels);
}

TEST(FrameCache, keepsTheShapesDrawnLastAndTellsOfTheOthers) {
    CacheSetup s;
    SceneSet& set = **s.cache.sceneSet(std::vector{s.add()});
    std::vector<uint64_t> keys;
    for (uint32_t width = 8; width < 13; ++width) {
        FrameShape shape = kShape;
        shape.widthPx = width;
        RecordedFrame* frame = s.own(set, shape);
        frame->lastUse = width;
        keys.push_back(frame->key);
    }
    EXPECT_EQ(s.freed, std::vector{keys[0]});
    EXPECT_EQ(set.frames.size(), 4u);
}

TEST(FrameCache, keepsEveryAvatarAloneAndTheFourLargerSetsDrawnLast) {
    CacheSetup s;
    std::vector<RenderAvatarId> ids;
    for (int k = 0; k < 4; ++k) ids.push_back(s.add());
    std::vector<uint32_t> numbers;
    for (const RenderAvatarId id : ids) numbers.push_back((*s.cache.sceneSet(std::vector{id}))->number);
    const auto pairOf = [&](size_t a, size_t b) { return (*s.cache.sceneSet(std::vector{ids[a], ids[b]}))->number; };
    const uint32_t first = pairOf(0, 1);
    EXPECT_EQ(pairOf(0, 1), first);
    EXPECT_NE(pairOf(1, 0), first) << "the order counts: the first one owns the frame";
    pairOf(1, 2), pairOf(2, 3);
    EXPECT_NE(s.cache.find(first), nullptr);
    pairOf(3, 0);
    EXPECT_EQ(s.cache.find(first), nullptr);
    for (const uint32_t number : numbers) EXPECT_NE(s.cache.find(number), nullptr);
    for (const RenderAvatarId id : ids) s.cache.remove(id), s.store.remove(id);
    EXPECT_EQ(s.record->liveBuffers, 0u);
}

TEST(AvatarStore, anotherStoreTakesOverTheSubjectsUnderTheirNumbers) {
    CacheSetup lost, anew;
    const RenderAvatarId gone = lost.add(), stays = lost.add();
    lost.store.remove(gone);
    const Status added = anew.store.addAll(lost.store);
    ASSERT_TRUE(added) << added.error().message;
    EXPECT_EQ(anew.store.find(gone), nullptr);
    ASSERT_NE(anew.store.find(stays), nullptr);
    EXPECT_EQ(anew.record->liveBuffers, lost.record->liveBuffers);
    EXPECT_EQ(anew.store.at(stays).ids.splatCount, lost.store.at(stays).ids.splatCount);
    EXPECT_GT(anew.add(), stays) << "numbers are not used again";
    lost.store.remove(stays);
    EXPECT_EQ(lost.record->liveBuffers, 0u);
    EXPECT_TRUE(anew.store.at(stays).ids.splats) << "each store has buffers of its own";
}

TEST(AvatarStore, slicesCarryEveryByteOnce) {
    CacheSetup s;
    const auto tube = std::make_shared<const AvatarData>(makeTube({.splatsPerTriangle = 20, .rings = 200, .segments = 64}));
    const RenderAvatarId id = *s.store.begin(std::move(*s.store.prepareAvatar(tube, *codeSplats(tube->mesh, tube->splats))));
    const uint64_t buffers = s.record->liveBuffers, all = s.store.at(id).records->bytes();
    uint64_t bytes = 0, slices = 0;
    UploadSlice slice;
    double share = 0;
    for (; share < 1 && slices < 100; ++slices) {
        const auto next = s.store.continueUpload(id, slice);
        ASSERT_TRUE(next) << next.error().message;
        EXPECT_GE(*next, share);
        share = *next;
        EXPECT_EQ(slice.to.size(), slice.from.size());
        EXPECT_LE(slice.to.size(), kCopiedBytesAFrame);
        EXPECT_TRUE(share < 1 || slice.from.empty());
        bytes += slice.from.size();
    }
    EXPECT_EQ(share, 1);
    EXPECT_EQ(bytes, all);
    EXPECT_GT(slices, all / kCopiedBytesAFrame);
    EXPECT_EQ(s.record->liveBuffers, buffers) << "the staging ring has gone";
    EXPECT_FALSE(s.store.continueUpload(id + 1, slice));
}

TEST(AvatarStore, keepsOneCopyOfWhatItUploads) {
    for (const uint32_t shDegree : {0u, 2u}) {
        CacheSetup s;
        const auto tube =
            std::make_shared<const AvatarData>(makeTube({.splatsPerTriangle = 20, .rings = 80, .segments = 64, .shDegree = shDegree}));
        const RenderAvatarId id = *s.store.begin(std::move(*s.store.prepareAvatar(tube, *codeSplats(tube->mesh, tube->splats))));
        const LoadedSubject& subject = s.store.at(id);
        const size_t triangles = tube->mesh.triangles.size();
        const uint64_t kept = subject.records->bytes(), codes = subject.records->avatar.codes.size() * 4;
        std::printf("%u splats of SH degree %u, %zu triangles: %.2f MB kept, %.1f bytes a splat and %.0f bytes a triangle\n",
                    subject.ids.splatCount, shDegree, triangles, double(kept) * 1e-6, double(codes) / subject.ids.splatCount,
                    double(kept - codes) / double(triangles));
        EXPECT_GT(kept, codes);
        EXPECT_LE(kept, subject.residentBytes) << "no more than the avatar takes";
    }
}

}  // namespace
}  // namespace dpl
