// SPDX-License-Identifier: Apache-2.0
// Which of several people in the pictures the scan is of.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "reconstruction/input/observe/observations.h"

namespace dpl {

/** The people of one frame. Frames are in the order in which they were taken. */
struct PeopleOfFrame {
    Vec2d sizePx{1};  // of the picture
    std::span<const SeenPerson> people;
    std::optional<Vec2d> pointPx;  // the user says that the person is here
};

constexpr size_t kNobody = SIZE_MAX;

/** For each frame the index of the chosen person, or kNobody.
 *
 *  People of neighbouring frames whose boxes continue each other form a track. The track with the largest sum of height × nearness to the
 *  middle × score wins; a track that a point of the user lies on wins over all others. Frames without it are filled by the next best track,
 *  unless that one was in view together with a chosen track, or begins where the person cannot have come to: then it is somebody else. */
std::vector<size_t> choosePerson(std::span<const PeopleOfFrame> frames);

/** The index of the person whose box is nearest to `box`, or kNobody when none overlaps it or is as large within a factor of 2. */
size_t nearestPerson(std::span<const SeenPerson> people, const PersonBox& box);

/** 0: apart, 1: equal. */
double boxOverlap(const PersonBox& a, const PersonBox& b);

}  // namespace dpl
