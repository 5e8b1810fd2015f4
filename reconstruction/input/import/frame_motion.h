// SPDX-License-Identifier: Apache-2.0
// How sharp the frames of a video are and what moves in them: the camera, the subject or both. Which frames a scan takes follows from it.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

namespace dpl {

/** One analysed frame. Motion is that a frame, over the last few frames; lengths are shares of the picture's diagonal. */
struct FrameMotion {
    double timeS = 0;
    double sharpness = 0;     // variance of the Laplacian; comparable within a video
    double cameraMotion = 0;  // median length of the tracks
    double poseChange = 0;    // mean length by which tracks differ from what a moving camera explains
    bool followed = true;     // most features could be followed; else the frames lie too far apart, and poseChange says little
    double stayed = -1;       // share of the features of 3.5 s before that are near their place: high where the camera rests. −1: unknown
};

/** Measures the frames of one video in order. Keeps those of the last seconds. */
class MotionMeter {
public:
    MotionMeter(uint32_t widthPx, uint32_t heightPx) : widthPx_(widthPx), heightPx_(heightPx) {}
    /** grey: widthPx · heightPx bytes. */
    FrameMotion add(std::span<const uint8_t> grey, double timeS);

private:
    uint32_t widthPx_, heightPx_;
    std::deque<std::vector<uint8_t>> before_;  // the newest last
    size_t count_ = 0;
    double stayed_ = -1;
};

/** A span of analysed frames, [begin, end). */
struct FrameSpan {
    size_t begin = 0, end = 0;
};

/** Where in a video the subject stands still and where it moves. One of them may be empty. */
struct StillAndMoving {
    FrameSpan still, moving;
    bool cameraRests = false;  // all the time. Then no part is a walk round a still subject, whatever the subject does
    bool followed = true;      // false: the frames lie too far apart to tell, and the whole is taken as still
};

/** Finds the one moment that splits a video best into a still and a moving part, in either order. The still part is a walk round the
 *  subject: a part where the camera rests is a moving one. A video without a clear change is still as a whole, or moving when the camera
 *  rests or the pose changes as fast as in moving parts. */
StillAndMoving splitByMotion(std::span<const FrameMotion> frames);

/** Chooses at most `count` frames of a span: the path of the camera (and with `withPose` of the pose) is cut into `count` equal pieces, and
 * of each piece the sharpest frame near its middle is taken. So a camera that rests gives no duplicates. Indices in increasing order. */
std::vector<size_t> chooseFrames(std::span<const FrameMotion> frames, FrameSpan span, size_t count, bool withPose);

}  // namespace dpl
