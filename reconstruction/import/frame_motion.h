// SPDX-License-Identifier: Apache-2.0
// How sharp the frames of a video are and what moves in them: the camera, the subject or both. Which frames a scan takes follows from it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace dpl {

/** One analysed frame. Motion is that since the analysed frame before; lengths are shares of the picture's diagonal. */
struct FrameMotion {
    double timeS = 0;
    double sharpness = 0;     // variance of the Laplacian; comparable within a video
    double cameraMotion = 0;  // median length of the tracks
    double poseChange = 0;    // mean length by which tracks differ from what a moving camera explains
};

/** Measures the frames of one video in order. Keeps the previous frame. */
class MotionMeter {
public:
    MotionMeter(uint32_t widthPx, uint32_t heightPx) : widthPx_(widthPx), heightPx_(heightPx) {}
    /** grey: widthPx · heightPx bytes. */
    FrameMotion add(std::span<const uint8_t> grey, double timeS);

private:
    uint32_t widthPx_, heightPx_;
    std::vector<uint8_t> previous_;
};

/** A span of analysed frames, [begin, end). */
struct FrameSpan {
    size_t begin = 0, end = 0;
};

/** Where in a video the subject stands still and where it moves. One of them may be empty. */
struct StillAndMoving {
    FrameSpan still, moving;
};

/** Finds the one moment that splits a video best into a still and a moving part, in either order. A video without a clear change is still
 * as a whole, or moving when its pose changes as fast as in moving parts. */
StillAndMoving splitByMotion(std::span<const FrameMotion> frames);

/** Chooses at most `count` frames of a span: the path of the camera (and with `withPose` of the pose) is cut into `count` equal pieces, and
 * of each piece the sharpest frame near its middle is taken. So a camera that rests gives no duplicates. Indices in increasing order. */
std::vector<size_t> chooseFrames(std::span<const FrameMotion> frames, FrameSpan span, size_t count, bool withPose);

}  // namespace dpl
