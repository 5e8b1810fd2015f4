// SPDX-License-Identifier: Apache-2.0
// For tests of loads in the background: a file that takes several slices to upload, and a load with its bytes.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <vector>

#include "sdk/format/ply.h"
#include "sdk/include/doppel/doppel.h"
#include "tests/unit/wait_until.h"

namespace dpl::test {

/** General splats in a ball in front of frontCamera(), of SH degree 3: 160 bytes of each go to a GPU. */
inline std::vector<uint8_t> ballOfSplats(uint32_t count) {
    StaticSplatData s;
    s.shDegree = 3;
    uint32_t random = 1;
    const auto unit = [&] { return random = random * 1664525u + 1013904223u, float(random >> 8) / float(1 << 24) * 2 - 1; };
    for (uint32_t i = 0; i < count; ++i) {
        s.position.push_back({0.5f * unit(), 1 + 0.5f * unit(), 0.5f * unit()});
        s.rotation.emplace_back(1.0f, 0.0f, 0.0f, 0.0f);
        s.scaleM.push_back(Vec3f(0.01f + 0.005f * unit()));
        s.opacity.push_back(0.5f + 0.4f * unit());
        for (int k = 0; k < 48; ++k) s.sh.push_back((k < 3 ? 1.5f : 0.2f) * unit());
    }
    auto bytes = writePly(s);
    EXPECT_TRUE(bytes) << (bytes ? "" : bytes.error().message);
    return bytes ? *bytes : std::vector<uint8_t>{};
}

/** A load whose bytes belong to it: they vanish when the library releases them. Loads need not be finished or cancelled. */
class BackgroundLoad {
public:
    DplResult start(DplContext context, std::span<const uint8_t> bytes) {
        held_ = new Held{{bytes.begin(), bytes.end()}, released_};
        const DplLoadInfo info{sizeof info, held_->bytes.data(), held_->bytes.size(),
                               [](void* user) {
                                   auto* held = static_cast<Held*>(user);
                                   ++*held->released;
                                   delete held;
                               },
                               held_};
        const DplResult started = dplStartLoad(context, &info, &handle);
        if (started != DPL_OK) delete held_;
        return started;
    }
    /** Checks that the progress is from 0 to 1, has not fallen, and is 1 only when the load is ready. */
    DplLoadState state() {
        DplLoadStatus status{sizeof status};
        EXPECT_EQ(dplGetLoadStatus(handle, &status), DPL_OK) << dplGetLastError();
        EXPECT_GE(status.progress, progress);
        EXPECT_LE(status.progress, 1.0f);
        EXPECT_TRUE(status.state != DPL_LOAD_READY || status.progress == 1);
        progress = status.progress;
        return status.state;
    }
    /** Waits until the load is in this state or beyond. */
    bool reaches(DplLoadState wanted) {
        return waitUntil([&] { return state() >= wanted; });
    }
    /** Waits until that share of the load is done, or the load is over. */
    bool reachesShare(float share) {
        return waitUntil([&] { return state() >= DPL_LOAD_READY || progress >= share; });
    }
    int released() const { return *released_; }
    /** The library gives the bytes back soon after a cancelled load has noticed. */
    bool isReleased() const {
        return waitUntil([&] { return *released_ > 0; }) && *released_ == 1;
    }

    DplLoad handle = nullptr;
    float progress = 0;

private:
    struct Held {
        std::vector<uint8_t> bytes;
        std::shared_ptr<std::atomic<int>> released;
    };
    Held* held_ = nullptr;
    std::shared_ptr<std::atomic<int>> released_ = std::make_shared<std::atomic<int>>(0);
};

}  // namespace dpl::test
