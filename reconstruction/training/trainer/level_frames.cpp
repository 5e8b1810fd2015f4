// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/level_frames.h"

#include <mutex>

namespace dpl {
namespace {

uint64_t bytesOf(const LevelFrame& f) {
    return f.rgb.size() + f.mask.size() + f.cloth.size() + f.shown.size() + f.unsure.size() + f.behind.size();
}

}  // namespace

float LevelFrames::scaleOf(uint32_t frame) const {
    const float first = coarsestScale(frames_[frame]);
    return last_ > 0 ? first + (1 - first) * float(index_) / float(last_) : 1.0f;
}

Result<LevelFrame> LevelFrames::make(uint32_t frame) const {
    DPL_TRY(const auto picture, checkedPicture(frames_[frame]));
    LevelFrame made = makeLevelFrame(frames_[frame], *picture, scaleOf(frame), clothLabels_, index_ == last_);
    made.name = TargetName{frame, index_};
    return made;
}

Status LevelFrames::select(int index, int last, std::span<const uint32_t> used) {
    if (index == index_) return {};
    index_ = index, last_ = last;
    kept_.assign(frames_.size(), std::nullopt);
    keptBytes_ = 0;
    passingFrame_.reset(), passing_ = {};
    std::mutex mutex;  // of all below
    Status failed;
    bool full = false;
    jobs_.forBlocks(used.size(), [&](size_t i, uint32_t) {
        {
            const std::lock_guard lock(mutex);
            if (full || !failed) return;
        }
        Result<LevelFrame> made = make(used[i]);
        const std::lock_guard lock(mutex);
        if (!made) {
            failed = made.error();
            return;
        }
        const uint64_t bytes = bytesOf(*made);
        full = full || keptBytes_ + bytes > boundBytes_;
        if (full) return;
        keptBytes_ += bytes;
        kept_[used[i]] = std::move(*made);
    });
    if (!failed) index_ = -1;
    return failed;
}

Result<const LevelFrame*> LevelFrames::at(uint32_t frame) {
    if (kept_[frame]) return &*kept_[frame];
    if (passingFrame_ != frame) {
        passingFrame_.reset();
        DPL_TRY(passing_, make(frame));
        passingFrame_ = frame;
    }
    return &passing_;
}

}  // namespace dpl
