// SPDX-License-Identifier: Apache-2.0
// The targets of a training on the device, so that each crosses to it once a level.
#pragma once

#include <vector>

#include "reconstruction/training/trainer/training_engine.h"
#include "sdk/backend/backend.h"

namespace dpl {

/** Keeps those with a name as far as they fit into the bound; the others are written anew for each step. One level at a time. */
class GpuTargets {
public:
    /** The bound: all of 174 pictures of 1080 x 1440 in which the person fills half. */
    static constexpr uint64_t kBoundBytes = uint64_t(13) << 27;

    explicit GpuTargets(Backend& backend) : backend_(backend) {}
    ~GpuTargets();

    /** Leaves the target in `place`, a Device buffer that is large enough. Blocks. Errors: those of the device. */
    Status show(const PictureTarget& target, const std::optional<TargetName>& name, BufferId place);
    /** The buffer that show() filled goes. */
    void forgetPlace();
    void clear();
    /** Bytes that crossed since the last call. */
    uint64_t takeBytes() { return std::exchange(crossed_, 0); }

private:
    struct Kept {
        TargetName name;
        BufferId buffer;
        FrameId copy;  // into the place; none: not recorded yet
    };
    Kept* find(const TargetName& name);
    Status keep(const TargetName& name);

    Backend& backend_;
    std::vector<Kept> kept_;
    std::vector<uint32_t> packed_;
    uint64_t keptBytes_ = 0, crossed_ = 0;
};

}  // namespace dpl
