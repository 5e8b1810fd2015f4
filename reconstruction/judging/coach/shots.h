// SPDX-License-Identifier: Apache-2.0
// The coach: which shots would improve the body map most, in words that a person can follow (docs/reference/body-map.md, "Shots").
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "reconstruction/judging/coach/body_map.h"

namespace dpl {

/** What the map says of one place, over the part of it that a camera can see at all. */
struct PlaceFigures {
    BodyPlace place = BodyPlace::Face;
    double areaM2 = 0;
    // Medians by area of what the pictures show; 0 when they show nothing:
    double pixelM = 0, blurPx = 0, detailM = 0, views = 0;
    double unseenShare = 0;  // share of the area that no still training picture shows
};

/** One piece of advice. */
struct Shot {
    std::string key;       // "closeup left_hand", "walk left", "walk around"
    std::string sentence;  // what to film, and why
    double gain = 0;       // importance × halvings of the finest visible detail, summed over the places
};

struct FilmAgain {
    std::vector<Shot> shots;           // at most three, the most helpful first; callers may add moves.h's; empty: none is needed
    std::vector<PlaceFigures> places;  // of places with area, in the order of BodyPlace
    std::vector<uint8_t> viewable;     // F: 1 where a real or an imagined picture shows the triangle
};

/** Imagines shots that a person can take with the camera of these pictures (close-ups of head, hands, feet, chest and back; walks past each
 *  side and all around) and takes the one that improves the map most, three times. Each time the map is improved as if the shot had been
 *  taken. `map`: of the surface, with one place a triangle. No pictures: no shots. */
FilmAgain bestShots(const MeshData& surface, std::span<const JointData> joints, std::span<const BodyPlace> places,
                    std::span<const SeenTriangle> map, std::span<const PosedPicture> pictures, Jobs& jobs);

/** Where the camera stands in the middle of a shot of bestShots(), for a picture of it: in the world of the first full-body picture, with
 *  the subject in its pose. nullopt: no shot has this key, or no picture shows the whole body. Reads no pixels. */
std::optional<Camerad> cameraOfShot(std::string_view key, const MeshData& surface, std::span<const JointData> joints,
                                    std::span<const BodyPlace> places, std::span<const PosedPicture> pictures);

/** The advice as lines of text: a heading and one line a shot, or one line that says that nothing is needed. Ends with a line break. */
std::string describeShots(const FilmAgain& advice);

}  // namespace dpl
