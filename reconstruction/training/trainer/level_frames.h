// SPDX-License-Identifier: Apache-2.0
// The frames of a training run at its current level, within a bound of memory.
#pragma once

#include <optional>

#include "reconstruction/training/trainer/train_images.h"
#include "sdk/core/jobs.h"

namespace dpl {

/** Keeps the frames of a level as far as they fit into the bound. A frame beyond it is made again from its picture each time a step shows
 *  it. What a step sees does not depend on the bound. For use by one thread. */
class LevelFrames {
public:
    /** At full size: all of 174 pictures of 1080 x 1440 in which the person fills half. */
    static constexpr uint64_t kBoundBytes = uint64_t(3) << 29;

    /** `frames` and `jobs` must outlive this. clothLabels: label values that count as cloth. */
    LevelFrames(std::span<const TrainFrame> frames, std::vector<uint8_t> clothLabels, uint64_t boundBytes, Jobs& jobs)
        : frames_(frames), clothLabels_(std::move(clothLabels)), boundBytes_(boundBytes), jobs_(jobs) {}

    /** Goes to level `index` of 0 (coarsest) to `last` (full size), and makes the frames `used` as far as they fit. Errors: a picture
     * cannot be read. */
    Status select(int index, int last, std::span<const uint32_t> used);

    /** A frame at the selected level. Valid until the next call. Errors: its picture cannot be read. */
    Result<const LevelFrame*> at(uint32_t frame);

    /** Size of the frame at the selected level, of its full size. */
    float scaleOf(uint32_t frame) const;

    /** Bytes of the frames that are kept, at most the bound. */
    uint64_t keptBytes() const { return keptBytes_; }

private:
    Result<LevelFrame> make(uint32_t frame) const;

    std::span<const TrainFrame> frames_;
    const std::vector<uint8_t> clothLabels_;
    const uint64_t boundBytes_;
    Jobs& jobs_;
    int index_ = -1, last_ = 0;
    std::vector<std::optional<LevelFrame>> kept_;  // one a frame
    uint64_t keptBytes_ = 0;
    LevelFrame passing_;  // the last one that is not kept
    std::optional<uint32_t> passingFrame_;
};

}  // namespace dpl
