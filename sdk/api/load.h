// SPDX-License-Identifier: Apache-2.0
// Loads: files that become avatars, on a thread of the library or on that of the caller. Internal to sdk/api.
//
//   Waiting ─► Decoding ─► Uploading ─► Ready      Failed follows on any of the first three
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <span>
#include <thread>

#include "sdk/api/api_state.h"
#include "sdk/core/task.h"

namespace dpl::api {

enum class LoadState : uint8_t { Waiting, Decoding, Uploading, Ready, Failed };

/** The object behind a DplLoad. One thread runs it (runLoad); others ask, cancel and finish. */
struct Load {
    std::shared_ptr<Context> context;
    std::span<const uint8_t> bytes;
    std::string file;                       // its name for warnings; empty: unknown
    void (*release)(void* user) = nullptr;  // called once, when `bytes` are not needed any more
    void* user = nullptr;
    Task task;

    std::mutex mutex;  // guards what follows. Locked after the mutexes of the context
    std::condition_variable changed;
    LoadState state = LoadState::Waiting;
    bool finishing = false;          // somebody waits: upload with submissions, and do not wait for frames or for a new device
    Error error;                     // of a load that failed
    std::shared_ptr<Avatar> avatar;  // of a load that is ready

    Load() = default;
    Load(const Load&) = delete;
    Load& operator=(const Load&) = delete;
    ~Load() { releaseBytes(); }
    void releaseBytes() {
        if (release && !released_.exchange(true)) release(user);
    }

private:
    std::atomic<bool> released_{false};
};

HandleTable<Load>& loads();

/** Loads on the calling thread. Afterwards the load is ready, or has failed. */
void runLoad(Load& load) noexcept;

/** Takes the load out of the queue of its context. False: it has begun, or it is not in the queue. */
bool takenBack(Load& load);

/** Makes the load a matter of haste and waits for its end. The avatar, or the error. */
Result<std::shared_ptr<Avatar>> finishLoad(const std::shared_ptr<Load>& load);

/** The thread that runs the loads of a context, one after the other. */
class Loader {
public:
    Loader() : thread_([this] { run(); }) {}
    /** Cancels all loads and waits until the one at hand has noticed. */
    ~Loader();
    Loader(const Loader&) = delete;
    Loader& operator=(const Loader&) = delete;

    /** release: see Load. Nothing is released if this throws. */
    void add(std::shared_ptr<Load> load, void (*release)(void* user));
    /** Takes back a load whose turn has not come. False: it was not waiting. */
    bool takeBack(const Load& load);

private:
    void run();

    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<std::shared_ptr<Load>> waiting_;
    std::shared_ptr<Load> atHand_;
    bool stop_ = false;
    std::thread thread_;  // last: it uses all of the above
};

}  // namespace dpl::api
