// SPDX-License-Identifier: Apache-2.0
// While one thread loads an avatar, others draw: the context is locked only while the prepared avatar is added.
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "tests/unit/api/api_fixture.h"
#include "tests/unit/wait_until.h"

namespace dpl::test {
namespace {

/** The log callback holds a load at the end of its preparation until the test lets it go. */
class Gate {
public:
    void pass() {
        std::unique_lock lock(mutex_);
        reached_ = true;
        changed_.notify_all();
        timedOut_ = !changed_.wait_for(lock, kPatience, [&] { return open_; });
    }
    bool waitUntilReached() {
        std::unique_lock lock(mutex_);
        return changed_.wait_for(lock, kPatience, [&] { return reached_; });
    }
    void open() {
        std::lock_guard lock(mutex_);
        open_ = true;
        changed_.notify_all();
    }
    bool timedOut() {
        std::lock_guard lock(mutex_);
        return timedOut_;
    }

private:
    std::mutex mutex_;
    std::condition_variable changed_;
    bool reached_ = false, open_ = false, timedOut_ = false;
};

class LoadWhileDrawing : public ApiTest {};

TEST_F(LoadWhileDrawing, framesGoOnWhileALoadPrepares) {
    Gate gate;
    dplSetLogCallback(
        [](void* user, DplLogLevel, const char* text) {
            if (std::string(text).find("prepared 'tiny'") == 0) static_cast<Gate*>(user)->pass();
        },
        &gate);
    const auto bytes = tinyFile();
    DplAvatar loaded = nullptr;
    std::thread loader([&] { EXPECT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &loaded), DPL_OK); });
    EXPECT_TRUE(gate.waitUntilReached()) << "a load logs when it has prepared";
    const DplCamera camera = frontCamera();
    std::vector<uint8_t> pixels;
    const DplImage image = imageFor(camera, pixels);
    for (int frame = 0; frame < 3; ++frame) {
        EXPECT_EQ(dplSetPoseFromClip(avatar_, 0, 0.1 * frame, DPL_TRUE), DPL_OK);
        EXPECT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK);
    }
    gate.open();
    loader.join();
    EXPECT_FALSE(gate.timedOut()) << "the load held the context's lock while it prepared";
    EXPECT_EQ(dplRender(context_, loaded, &camera, 1, &image), DPL_OK) << dplGetLastError();
    EXPECT_EQ(dplDestroyAvatar(loaded), DPL_OK);
    dplSetLogCallback(nullptr, nullptr);
}

TEST_F(LoadWhileDrawing, aContextDestroyedWhileALoadPreparesRefusesTheAvatar) {
    Gate gate;
    dplSetLogCallback(
        [](void* user, DplLogLevel, const char* text) {
            if (std::string(text).find("prepared 'tiny'") == 0) static_cast<Gate*>(user)->pass();
        },
        &gate);
    const DplContextInfo info{sizeof(DplContextInfo), DPL_RENDERER_SOFTWARE, 1};
    DplContext context = nullptr;
    ASSERT_EQ(dplCreateContext(&info, &context), DPL_OK);
    const auto bytes = tinyFile();
    DplAvatar loaded = nullptr;
    std::thread loader([&] {
        EXPECT_EQ(dplLoadAvatar(context, bytes.data(), bytes.size(), &loaded), DPL_ERROR_INVALID_ARGUMENT);
        EXPECT_TRUE(errorSays("destroyed")) << dplGetLastError();
    });
    EXPECT_TRUE(gate.waitUntilReached());
    EXPECT_EQ(dplDestroyContext(context), DPL_OK);
    gate.open();
    loader.join();
    EXPECT_EQ(loaded, nullptr);
    dplSetLogCallback(nullptr, nullptr);
}

TEST_F(LoadWhileDrawing, threadsThatLoadDrawAndDestroyDoNotRace) {
    const auto bytes = tinyFile();
    std::atomic<bool> done{false};
    std::thread loader([&] {
        for (int k = 0; k < 10; ++k) {
            DplAvatar loaded = nullptr;
            EXPECT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &loaded), DPL_OK);
            EXPECT_EQ(dplDestroyAvatar(loaded), DPL_OK);
        }
        done = true;
    });
    const DplCamera camera = frontCamera(16, 16);
    std::vector<uint8_t> pixels;
    const DplImage image = imageFor(camera, pixels);
    do EXPECT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK);
    while (!done);
    loader.join();
}

}  // namespace
}  // namespace dpl::test
