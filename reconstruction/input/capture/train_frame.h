// SPDX-License-Identifier: Apache-2.0
// A frame of a scan with the pose of the person in it.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "reconstruction/input/capture/frame_picture.h"
#include "reconstruction/input/capture/pose_precision.h"
#include "sdk/avatar/rig.h"

namespace dpl {

/** A frame's picture, which is constant. It is decoded when somebody asks for it, and may be decoded again the next time: whoever takes it
 *  lets go of it before the next frame, so that the pictures of a scan need not fit into memory together. Copies ask the same source. */
class LazyPicture {
public:
    /** Decodes. Errors as of readFramePicture(). Called from several threads. */
    using Load = std::function<Result<std::shared_ptr<const FramePicture>>()>;

    LazyPicture() = default;                                    // no picture
    LazyPicture(std::shared_ptr<const FramePicture> picture) {  // one that stays in memory
        if (picture) load_ = [picture = std::move(picture)] { return picture; };
    }
    explicit LazyPicture(Load load) : load_(std::move(load)) {}

    explicit operator bool() const { return bool(load_); }
    /** NotFound: there is no picture. From any thread. */
    Result<std::shared_ptr<const FramePicture>> get() const {
        if (!load_) return fail(Code::NotFound, "a frame has no picture");
        return load_();
    }

private:
    Load load_;
};

/** One picture with its camera and the subject's pose. */
struct TrainFrame {
    std::string name;
    FrameKind kind = FrameKind::StaticFull;
    Camerad camera;
    Pose pose;
    LazyPicture picture;                             // of the camera's size
    std::shared_ptr<const PosePrecision> precision;  // of `pose`; null: nothing is known
};

}  // namespace dpl
