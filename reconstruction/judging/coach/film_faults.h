// SPDX-License-Identifier: Apache-2.0
// What is wrong with a film, from a sample of its pictures alone: no cameras, no body (docs/reference/body-map.md, "The first look").
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "reconstruction/input/capture/frame_picture.h"
#include "reconstruction/input/capture/glance.h"
#include "reconstruction/input/capture/scan.h"

namespace dpl {

/** Measures of one picture. */
struct FilmPicture {
    FrameKind kind = FrameKind::StaticFull;
    size_t film = 0;  // pictures of one film are neighbours in time
    double timeS = 0;
    uint32_t widthPx = 0, heightPx = 0;
    double luma = 0;              // mean, 0 … 255
    std::optional<float> blurPx;  // of its edges; none: too few edges
    bool looked = false;          // by the pose network
    std::optional<Glance> person;
    std::array<std::optional<Vec3f>, 2> clothes;  // mean colour of the belly and of the thighs, CIELAB
};

/** Measures a picture. glance: null where no network looked. */
FilmPicture measureFilmPicture(const ImageRgb8& image, FrameKind kind, size_t film, double timeS, const Glance* glance);

/** One thing that is wrong, worst first. */
struct FilmFault {
    std::string key;       // "blur walk", "turn", "feet", "moves" ...
    std::string sentence;  // what to do, and why
};

/** The faults of a film, those that cost most first; of pictures in any order. What needs a person is not judged where no network looked.
 *  `undivided`: the still pictures are of one video, which also holds the moves. */
std::vector<FilmFault> filmFaults(std::span<const FilmPicture> pictures, bool undivided);

}  // namespace dpl
