// SPDX-License-Identifier: Apache-2.0
// The target that a recorded frame draws into, and who owns it.
#pragma once

#include <utility>

#include "sdk/backend/backend.h"

namespace dpl {

/** A target that is made for one frame and destroyed with it, or one that its owner lends and keeps until the frame is gone, or none. The
 *  backend must live longer. Move-only. One thread at a time, as the backend. */
class FrameTarget {
public:
    static Result<FrameTarget> create(Backend& backend, const TargetDesc& desc) {
        DPL_TRY(const TargetId id, backend.createTarget(desc));
        return FrameTarget(&backend, id);
    }
    static FrameTarget lent(TargetId id) { return FrameTarget(nullptr, id); }
    static FrameTarget none() { return FrameTarget(nullptr, {}); }

    FrameTarget(FrameTarget&& other) noexcept : owner_(std::exchange(other.owner_, nullptr)), id_(other.id_) {}
    FrameTarget& operator=(FrameTarget&& other) noexcept {
        std::swap(owner_, other.owner_);
        std::swap(id_, other.id_);
        return *this;
    }
    ~FrameTarget() {
        if (owner_) owner_->destroyTarget(id_);
    }

    TargetId id() const { return id_; }

private:
    FrameTarget(Backend* owner, TargetId id) : owner_(owner), id_(id) {}

    Backend* owner_;  // null: lent, or none
    TargetId id_;
};

}  // namespace dpl
