// SPDX-License-Identifier: Apache-2.0
// Repairs the cameras that a scan brings, where its keypoints raise doubt and its pictures agree (docs/reference/cameras.md).
#pragma once

#include <string>
#include <string_view>

#include "reconstruction/input/capture/scan.h"
#include "sdk/core/jobs.h"

namespace dpl {

/** Whether the keypoints of still training frames miss their common points by more than priors::kCameraDoubt of the subject's height in the
 *  picture, or fit another focal length clearly better. Reads keypoint files only. Files that cannot be read count as absent: the scan
 * check names them. */
bool keypointsDoubtCameras(const Scan& scan);

struct CameraRepair {
    bool repaired = false;                     // false: the scan is as it was
    double missBeforePx = 0, missAfterPx = 0;  // median miss of the pictures' matches
    double focalFactor = 1;                    // the focal length was multiplied by this
    size_t moved = 0, kept = 0;                // frames that got another camera; frames whose pictures did not tell
    std::string sentence;                      // for people; says why when nothing was repaired
};

/** Matches the pictures of still training frames, the person masked out where there are masks, and adjusts their cameras, the focal length
 *  and k1 by a bundle adjustment. The world stays where it was on average. When matches then miss by less than half as much, the scan gets
 *  the new cameras, and every other frame is placed on the points by its own picture; held-out frames therefore change nothing else.
 *  Otherwise the scan is unchanged. Errors: a picture cannot be read; Cancelled. */
Result<CameraRepair> repairCameras(Scan& scan, Jobs& jobs);

}  // namespace dpl
