// SPDX-License-Identifier: Apache-2.0
// A frame of a scan with the pose of the person in it.
#pragma once

#include <memory>
#include <string>

#include "reconstruction/input/capture/frame_picture.h"
#include "reconstruction/input/capture/pose_precision.h"
#include "sdk/avatar/rig.h"

namespace dpl {

/** One picture with its camera and the subject's pose. Copies share the picture, which is constant. */
struct TrainFrame {
    std::string name;
    FrameKind kind = FrameKind::StaticFull;
    Camerad camera;
    Pose pose;
    std::shared_ptr<const FramePicture> picture;     // of the camera's size
    std::shared_ptr<const PosePrecision> precision;  // of `pose`; null: nothing is known
};

}  // namespace dpl
