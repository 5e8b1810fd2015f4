// SPDX-License-Identifier: Apache-2.0
// What is wrong with a film, from a sample of its pictures alone: no cameras, no body (docs/reference/body-map.md, "The first look").
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "reconstruction/input/capture/frame_picture.h"
#include "reconstruction/input/capture/scan.h"

namespace dpl {

/** The person as one look of the pose network shows them. */
struct GlancedPerson {
    size_t people = 1;               // in view
    double secondShare = 0;          // height of the second one, of the first
    std::vector<Vec2d> landmarks;    // 33, BlazePose order, pixels; may lie outside the picture
    std::vector<double> confidence;  // 33, 0 … 1: in the picture and not hidden
    double turnRad = 0;              // where the camera stands round the person: 0 in front, π/2 at the person's left
};

/** Measures of one picture. */
struct FilmPicture {
    FrameKind kind = FrameKind::StaticFull;
    size_t film = 0;  // pictures of one film are neighbours in time
    double timeS = 0;
    uint32_t widthPx = 0, heightPx = 0;
    double luma = 0;              // mean, 0 … 255
    std::optional<float> blurPx;  // of its edges; none: too few edges
    bool looked = false;          // by the pose network
    std::optional<GlancedPerson> person;
    std::array<std::optional<Vec3f>, 2> clothes;  // mean colour of the belly and of the thighs, CIELAB
};

/** Measures a picture. person: null where no network looked; with no landmarks: it found nobody. */
FilmPicture measureFilmPicture(const ImageRgb8& image, FrameKind kind, size_t film, double timeS, const GlancedPerson* person);

/** One thing that is wrong, worst first. */
struct FilmFault {
    std::string key;       // "blur walk", "turn", "feet", "moves" ...
    std::string sentence;  // what to do, and why
};

/** The faults of a film, those that cost most first; of pictures in any order. What needs a person is not judged where no network looked.
 *  `undivided`: the still pictures are of one video, which also holds the moves. */
std::vector<FilmFault> filmFaults(std::span<const FilmPicture> pictures, bool undivided);

}  // namespace dpl
