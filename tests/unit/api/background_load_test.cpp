// SPDX-License-Identifier: Apache-2.0
// Loads in the background on contexts that own their renderer: the CPU, and Vulkan. They end as dplLoadAvatar ends, can be cancelled at
// any time, and leave nothing behind.
#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <string_view>
#include <utility>

#include "tests/unit/api/api_fixture.h"
#include "tests/unit/api/background_load.h"

namespace dpl::test {
namespace {

class BackgroundLoadTest : public testing::TestWithParam<DplRenderer> {
protected:
    void SetUp() override {
        dplSetLogCallback([](void*, DplLogLevel, const char*) {}, nullptr);
        const DplContextInfo info{sizeof info, GetParam(), 1, 0, DPL_FILL_QUADS, nullptr};
        const DplResult made = dplCreateContext(&info, &context_);
        if (made == DPL_ERROR_UNSUPPORTED) GTEST_SKIP() << dplGetLastError();
        ASSERT_EQ(made, DPL_OK) << dplGetLastError();
        tiny_ = tinyFile();
    }
    void TearDown() override {
        EXPECT_EQ(dplDestroyContext(context_), DPL_OK);
        dplSetLogCallback(nullptr, nullptr);
    }
    std::vector<uint8_t> picture(DplAvatar avatar) {
        const DplCamera camera = frontCamera();
        std::vector<uint8_t> pixels(size_t(camera.widthPx) * camera.heightPx * 4);
        const DplImage image{sizeof image, 0, pixels.data(), pixels.size(), 0, nullptr, 0};
        EXPECT_EQ(dplRender(context_, avatar, &camera, 1, &image), DPL_OK) << dplGetLastError();
        return pixels;
    }
    std::vector<uint8_t> pictureOfLoadAvatar(const std::vector<uint8_t>& bytes) {
        DplAvatar avatar = nullptr;
        EXPECT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &avatar), DPL_OK) << dplGetLastError();
        std::vector<uint8_t> pixels = picture(avatar);
        EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
        return pixels;
    }
    uint64_t residentBytes() {
        DplAvatar avatar = nullptr;
        EXPECT_EQ(dplLoadAvatar(context_, tiny_.data(), tiny_.size(), &avatar), DPL_OK) << dplGetLastError();
        DplFrameStats stats{sizeof stats};
        EXPECT_EQ(dplGetFrameStats(avatar, &stats), DPL_OK);
        EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
        return stats.residentBytes;
    }

    DplContext context_ = nullptr;
    std::vector<uint8_t> tiny_;
};

TEST_P(BackgroundLoadTest, endsAsLoadAvatarEnds) {
    for (const auto& bytes : {tiny_, ballOfSplats(20000)}) {
        const std::vector<uint8_t> expected = pictureOfLoadAvatar(bytes);
        EXPECT_GT(std::count_if(expected.begin(), expected.end(), [](uint8_t c) { return c > 20; }), 1000);
        BackgroundLoad load;
        ASSERT_EQ(load.start(context_, bytes), DPL_OK) << dplGetLastError();
        ASSERT_TRUE(load.reaches(DPL_LOAD_READY));
        EXPECT_EQ(load.released(), 1);
        DplAvatar avatar = nullptr;
        EXPECT_EQ(dplFinishLoad(load.handle, nullptr), DPL_ERROR_INVALID_ARGUMENT);
        ASSERT_EQ(dplFinishLoad(load.handle, &avatar), DPL_OK) << dplGetLastError();
        EXPECT_EQ(picture(avatar), expected);
        EXPECT_EQ(dplFinishLoad(load.handle, &avatar), DPL_ERROR_INVALID_ARGUMENT) << "it is gone";
        EXPECT_EQ(dplCancelLoad(load.handle), DPL_ERROR_INVALID_ARGUMENT);
        DplLoadStatus status{sizeof status};
        EXPECT_EQ(dplGetLoadStatus(load.handle, &status), DPL_ERROR_INVALID_ARGUMENT);
        EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
    }
}

TEST_P(BackgroundLoadTest, finishingWaitsInAnyState) {
    const auto ball = ballOfSplats(20000);
    const std::vector<uint8_t> expected = pictureOfLoadAvatar(ball);
    for (const DplLoadState when : {DPL_LOAD_WAITING, DPL_LOAD_DECODING, DPL_LOAD_UPLOADING}) {
        BackgroundLoad first, load;
        ASSERT_EQ(first.start(context_, ball), DPL_OK);
        ASSERT_EQ(load.start(context_, ball), DPL_OK);
        ASSERT_TRUE(load.reaches(when));
        DplAvatar avatar = nullptr;
        ASSERT_EQ(dplFinishLoad(load.handle, &avatar), DPL_OK) << dplGetLastError();
        EXPECT_EQ(load.released(), 1);
        EXPECT_EQ(picture(avatar), expected);
        EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
        EXPECT_EQ(dplCancelLoad(first.handle), DPL_OK);
        EXPECT_TRUE(first.isReleased());
    }
}

TEST_P(BackgroundLoadTest, hostileBytesGiveTheErrorOfLoadAvatar) {
    const auto ball = ballOfSplats(300);
    std::vector<std::vector<uint8_t>> files = {{'x'}, {tiny_.begin(), tiny_.end() - 5}, {ball.begin(), ball.end() - 5}, tiny_, ball};
    files[3][files[3].size() / 2] ^= 1;
    const std::string_view head = "end_header\n";  // behind it: no finite splat
    std::fill(std::search(files[4].begin(), files[4].end(), head.begin(), head.end()) + ptrdiff_t(head.size()), files[4].end(), 0xff);
    for (const auto& bytes : files) {
        DplAvatar avatar = nullptr;
        const DplResult expected = dplLoadAvatar(context_, bytes.data(), bytes.size(), &avatar);
        const std::string sentence = dplGetLastError();
        ASSERT_NE(expected, DPL_OK);
        BackgroundLoad load;
        ASSERT_EQ(load.start(context_, bytes), DPL_OK) << dplGetLastError();
        ASSERT_TRUE(load.reaches(DPL_LOAD_FAILED));
        EXPECT_EQ(load.released(), 1);
        EXPECT_EQ(dplFinishLoad(load.handle, &avatar), expected);
        EXPECT_EQ(avatar, nullptr);
        EXPECT_EQ(std::string(dplGetLastError()), "dplFinishLoad" + sentence.substr(sentence.find(':')));
    }
}

TEST_P(BackgroundLoadTest, cancelledAtAnyTimeItLeavesNothing) {
    const auto ball = ballOfSplats(60000);
    const uint64_t before = residentBytes();
    for (int round = 0; round < 24; ++round) {
        BackgroundLoad load;
        ASSERT_EQ(load.start(context_, round % 2 ? ball : tiny_), DPL_OK);
        ASSERT_TRUE(load.reachesShare(float(round / 2) / 11));
        ASSERT_EQ(dplCancelLoad(load.handle), DPL_OK) << dplGetLastError();
        const std::clock_t start = std::clock();
        EXPECT_TRUE(load.isReleased());
        const double cpuS = double(std::clock() - start) / CLOCKS_PER_SEC;  // of this process alone
        EXPECT_LT(cpuS, 2) << "round " << round;                            // 0.225 s for 500,000 splats were measured
        EXPECT_EQ(dplCancelLoad(load.handle), DPL_ERROR_INVALID_ARGUMENT);
    }
    EXPECT_EQ(dplCancelLoad(nullptr), DPL_OK);
    BackgroundLoad last;  // loads run one after the other: when it is ready, the cancelled ones have gone
    ASSERT_EQ(last.start(context_, tiny_), DPL_OK);
    ASSERT_TRUE(last.reaches(DPL_LOAD_READY));
    EXPECT_EQ(dplCancelLoad(last.handle), DPL_OK);
    EXPECT_EQ(residentBytes(), before);
}

TEST_P(BackgroundLoadTest, manyLoadsRunInTheirOrderWhileFramesGoOn) {
    const auto ball = ballOfSplats(3000);
    const std::vector<uint8_t> expected = pictureOfLoadAvatar(tiny_);
    DplAvatar shown = nullptr;
    ASSERT_EQ(dplLoadAvatar(context_, tiny_.data(), tiny_.size(), &shown), DPL_OK);
    std::array<BackgroundLoad, 16> many;
    for (size_t i = 0; i < many.size(); ++i) ASSERT_EQ(many[i].start(context_, i % 2 ? ball : tiny_), DPL_OK);
    while (many.back().state() < DPL_LOAD_READY) {
        EXPECT_EQ(picture(shown), expected);
        DplLoadState before = DPL_LOAD_READY;
        for (auto load = many.rbegin(); load != many.rend(); ++load) {  // from the last: they may get on meanwhile
            const DplLoadState state = load->state();
            EXPECT_GE(state, load == many.rbegin() || before == DPL_LOAD_WAITING ? DPL_LOAD_WAITING : DPL_LOAD_READY);
            before = state;
        }
    }
    std::vector<DplAvatar> avatars(many.size());
    for (size_t i = 0; i < many.size(); ++i) ASSERT_EQ(dplFinishLoad(many[i].handle, &avatars[i]), DPL_OK) << dplGetLastError();
    EXPECT_EQ(picture(avatars[14]), expected);
    for (const DplAvatar avatar : avatars) EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
    EXPECT_EQ(dplDestroyAvatar(shown), DPL_OK);
}

TEST_P(BackgroundLoadTest, destroyingTheContextEndsItsLoads) {
    const auto ball = ballOfSplats(60000);
    for (const float share : {0.0f, 0.1f, 0.6f}) {
        const DplContextInfo info{sizeof info, GetParam(), 1, 0, DPL_FILL_QUADS, nullptr};
        DplContext context = nullptr;
        ASSERT_EQ(dplCreateContext(&info, &context), DPL_OK);
        BackgroundLoad ready, atHand, waiting;
        ASSERT_EQ(ready.start(context, tiny_), DPL_OK);
        ASSERT_TRUE(ready.reaches(DPL_LOAD_READY));
        ASSERT_EQ(atHand.start(context, ball), DPL_OK);
        ASSERT_EQ(waiting.start(context, ball), DPL_OK);
        ASSERT_TRUE(atHand.reachesShare(share));
        ASSERT_EQ(dplDestroyContext(context), DPL_OK);
        EXPECT_EQ(waiting.released(), 1);
        EXPECT_EQ(atHand.released(), 1);
        DplAvatar avatar = nullptr;
        EXPECT_EQ(waiting.state(), DPL_LOAD_FAILED);
        EXPECT_EQ(dplFinishLoad(waiting.handle, &avatar), DPL_ERROR_INVALID_ARGUMENT);
        EXPECT_NE(std::string(dplGetLastError()).find("destroyed"), std::string::npos) << dplGetLastError();
        EXPECT_EQ(dplCancelLoad(atHand.handle), DPL_OK);
        BackgroundLoad late;
        EXPECT_EQ(late.start(context, tiny_), DPL_ERROR_INVALID_ARGUMENT);
        EXPECT_EQ(late.released(), 0) << "nothing was started";
        ASSERT_EQ(dplFinishLoad(ready.handle, &avatar), DPL_OK) << "an avatar outlives its context";
        EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
    }
}

TEST_P(BackgroundLoadTest, aMemoryLimitLowersDetailInsteadOfFailing) {
    const auto ball = ballOfSplats(20000);
    const std::vector<uint8_t> whole = pictureOfLoadAvatar(ball);
    const auto load = [&](uint64_t limit, DplAvatarInfo& info, uint64_t& resident) {
        const DplContextInfo how{sizeof how, GetParam(), 1, 0, DPL_FILL_QUADS, nullptr};
        EXPECT_EQ(dplDestroyContext(std::exchange(context_, nullptr)), DPL_OK);
        EXPECT_EQ(dplCreateContext(&how, &context_), DPL_OK);
        EXPECT_EQ(dplSetMemoryLimit(context_, limit), DPL_OK);
        BackgroundLoad background;
        EXPECT_EQ(background.start(context_, ball), DPL_OK);
        DplAvatar avatar = nullptr;
        const DplResult loaded = dplFinishLoad(background.handle, &avatar);
        if (loaded != DPL_OK) return loaded;
        info = {}, info.structSize = sizeof info;
        EXPECT_EQ(dplGetAvatarInfo(avatar, &info), DPL_OK);
        DplFrameStats stats{};
        stats.structSize = sizeof stats;
        EXPECT_EQ(dplGetFrameStats(avatar, &stats), DPL_OK);
        resident = stats.residentBytes;
        EXPECT_EQ(info.fileSplatCount, 20000u);
        EXPECT_EQ(info.fileShDegree, 3u);
        const std::vector<uint8_t> pixels = picture(avatar);
        double sum = 0;
        for (size_t i = 0; i < pixels.size(); ++i) sum += std::pow(double(pixels[i]) - double(whole[i]), 2);
        const double psnrDb = 10 * std::log10(255.0 * 255 * double(pixels.size()) / std::max(sum, 1e-9));
        std::printf("limit %8llu: %8llu bytes, %5u splats of SH degree %u, %.1f dB\n", (unsigned long long)limit,
                    (unsigned long long)resident, info.splatCount, info.shDegree, psnrDb);
        EXPECT_GT(psnrDb, 18) << "the same ball";
        EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
        return loaded;
    };
    DplAvatarInfo info{}, leaner{};
    uint64_t all = 0, resident = 0;
    ASSERT_EQ(load(0, info, all), DPL_OK) << dplGetLastError();
    EXPECT_EQ(info.splatCount, 20000u);
    EXPECT_EQ(info.shDegree, 3u);
    uint64_t before = all;
    for (const double part : {0.8, 0.5, 0.3, 0.15}) {
        const auto limit = uint64_t(double(all) * part);
        ASSERT_EQ(load(limit, leaner, resident), DPL_OK) << dplGetLastError();
        EXPECT_LE(resident, limit);
        EXPECT_LE(resident, before);
        EXPECT_TRUE(leaner.shDegree < info.shDegree || leaner.splatCount < info.splatCount || resident == before);
        EXPECT_TRUE(leaner.splatCount == 20000 || leaner.shDegree == 0) << "bands go first";
        info = leaner, before = resident;
    }
    EXPECT_LT(leaner.splatCount, 20000u);
    EXPECT_EQ(load(1000, leaner, resident), DPL_ERROR_OUT_OF_MEMORY);
    const std::string sentence = dplGetLastError();
    EXPECT_NE(sentence.find("limit of 1000 (dplSetMemoryLimit)"), std::string::npos) << sentence;
    EXPECT_NE(sentence.find("1/16"), std::string::npos) << sentence;
    EXPECT_EQ(dplSetMemoryLimit(nullptr, 0), DPL_ERROR_INVALID_ARGUMENT);
}

TEST_P(BackgroundLoadTest, mistakesAreRefused) {
    DplLoad load = nullptr;
    DplLoadInfo info{sizeof info, tiny_.data(), 0, nullptr, nullptr};
    EXPECT_EQ(dplStartLoad(context_, &info, &load), DPL_ERROR_INVALID_ARGUMENT);
    info.size = tiny_.size(), info.data = nullptr;
    EXPECT_EQ(dplStartLoad(context_, &info, &load), DPL_ERROR_INVALID_ARGUMENT);
    info.data = tiny_.data();
    EXPECT_EQ(dplStartLoad(context_, &info, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplStartLoad(context_, nullptr, &load), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(load, nullptr);
    DplAvatar avatar = nullptr;
    EXPECT_EQ(dplFinishLoad(reinterpret_cast<DplLoad>(context_), &avatar), DPL_ERROR_INVALID_ARGUMENT);
    ASSERT_EQ(dplStartLoad(context_, &info, &load), DPL_OK) << "release may be NULL";
    ASSERT_EQ(dplFinishLoad(load, &avatar), DPL_OK) << dplGetLastError();
    EXPECT_EQ(dplCancelLoad(reinterpret_cast<DplLoad>(avatar)), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
}

INSTANTIATE_TEST_SUITE_P(, BackgroundLoadTest, testing::Values(DPL_RENDERER_SOFTWARE, DPL_RENDERER_VULKAN),
                         [](const auto& test) { return test.param == DPL_RENDERER_SOFTWARE ? "Cpu" : "Vulkan"; });

}  // namespace
}  // namespace dpl::test
