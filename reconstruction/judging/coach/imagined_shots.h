// SPDX-License-Identifier: Apache-2.0
// Shots that a person could still take, and what they would show. Private to reconstruction/judging/coach and its tests.
#pragma once

#include <string>
#include <vector>

#include "reconstruction/judging/coach/body_map.h"

namespace dpl {

/** A few pictures, sharp and with the lens of the scan. */
struct ImaginedShot {
    std::string key, action;       // "closeup left_hand", "Film the left hand from 40 cm, slowly from all sides"
    std::vector<BodyPlace> of;     // of a close-up; empty: a walk, which is of the whole body
    bool plural = false;           // of "they are"
    double effort = 1;             // a close-up or a walk past one side: 1
    std::vector<Camerad> cameras;  // world of the pose that the subject stood in
    std::vector<float> pixelM;     // F: smallest size of a pixel on the surface; 0: not shown
    std::vector<uint32_t> views;   // F: pictures that would look at it at less than 60° to its normal

    /** Median of pixelM where it is shown. */
    double typicalPixelM() const;
};

/** The subject stands as in the first full-body picture, and the camera is that picture's. Sides and heights are those of the subject; the
 *  world may have any up. Walks keep the usual distance of the full-body pictures, or come nearer when the person fills less than 60 % of
 *  their height. No full-body picture: no shots. Reads the pictures' cameras and poses alone. */
std::vector<ImaginedShot> imagineShots(const MeshData& surface, std::span<const JointData> joints, std::span<const BodyPlace> places,
                                       std::span<const PosedPicture> pictures, Jobs& jobs);

}  // namespace dpl
