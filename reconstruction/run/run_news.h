// SPDX-License-Identifier: Apache-2.0
// What a run tells those who watch it from another process (docs/formats/progress.md): how far it is, and the avatar so far.
//
//   OUT/progress.json          replaced every two seconds while the run lives
//   OUT/watch/avatar.glb       the avatar so far, while it is trained
//   OUT/watch/held-back.jpg    a picture that training does not see
//
// A thread of its own writes the files. The run does not wait for it, and no result depends on it. What cannot be written is left out.
#pragma once

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/run/time_left.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** For one thread, that of the run, which must not call it after ended(). */
class RunNews {
public:
    static constexpr const char *kProgress = "progress.json", *kFolder = "watch", *kAvatar = "watch/avatar.glb",
                                *kHeldBack = "watch/held-back.jpg";
    static constexpr double kBeatS = 2;
    /** An avatar is shown at most this often, and so seldom that all of its work is below 1 / kShare of the time. */
    static constexpr double kAvatarS = 10, kShare = 150;

    /** Removes what an earlier run left for its watchers, and begins to tell. The folder is there. */
    explicit RunNews(std::filesystem::path outFolder);
    /** Tells a last time and removes what OUT/watch shows. A run that did not say how it ended counts as failed. */
    ~RunNews();
    RunNews(const RunNews&) = delete;
    RunNews& operator=(const RunNews&) = delete;

    /** Which stages this run has, so that it can tell how long it still takes. */
    void plan(const RunSize& size);
    /** A stage begins, by its name in the graph. */
    void stage(std::string_view name);
    /** It is up to date, and took so long in an earlier run. */
    void tookBefore(double seconds);
    /** share: of the stage, 0 to 1. Cheap enough for every step. */
    void doing(double share, std::string_view detail);
    /** Seconds that the stage and the run still take; nothing: not known yet. */
    struct Left {
        std::optional<double> stageS, runS;
    };
    Left left() const;
    /** How well the training fits its pictures so far. */
    struct FitPoint {
        uint32_t step = 0;
        float psnrDb = 0, loss = 0;
    };
    void curve(const std::vector<FitPoint>& points, uint32_t steps);
    /** A picture that training does not see, three channels; a copy of up to kHeldBackPx rows is shown. */
    void heldBack(const std::string& frame, const Picture& picture);
    static constexpr uint32_t kHeldBackPx = 720;

    /** Whether it is time for another avatar(). */
    bool wantsAvatar() const;
    /** The avatar so far. gatherS: what it took the run to gather it, which counts as work for watchers. */
    void avatar(AvatarData avatar, uint32_t step, double gatherS);

    /** The run is over: done; stopped, if the code is Cancelled; or failed with this sentence. */
    void ended(const Status& how);

    /** For any thread of a process that is about to end while its run still works: the run tells that it was stopped. Returns when that is
     *  written, or after kLastWordS on a disk that is slow. Does nothing where no run tells. */
    static void sayStopped();
    static constexpr double kLastWordS = 2;

private:
    using Clock = std::chrono::steady_clock;
    struct Shown {  // an avatar to be written
        AvatarData avatar;
        uint32_t step = 0;
        double gatherS = 0;
    };
    struct Told {
        std::string state = "running", sentence, stage, detail, heldBackFrame;
        double forWatchersS = 0;  // work until now that the run alone would not need
        TimeLeft time;            // of the seconds since start_
        std::vector<FitPoint> curve;
        uint32_t steps = 0, avatarStep = 0, avatarChange = 0;
    };
    void write();
    void stopNow();
    double sinceStartS() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
    void writeProgress();
    void writeAvatarFile(Shown shown);

    const std::filesystem::path out_;
    const Clock::time_point start_ = Clock::now();
    const int64_t startedUnixS_;
    uint64_t beat_ = 0;  // only the thread uses it

    mutable std::mutex mutex_;
    std::condition_variable changed_;
    Told told_;
    std::optional<RunSize> size_;
    std::optional<Shown> shown_;
    std::vector<uint8_t> heldBack_;
    bool writing_ = false, news_ = false, over_ = false, toldLast_ = false;
    Clock::time_point nextAvatar_ = start_;
    std::thread thread_;  // last: it uses all of the above
};

}  // namespace dpl
