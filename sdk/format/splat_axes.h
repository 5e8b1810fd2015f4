// SPDX-License-Identifier: Apache-2.0
// How a file of general splats stands, as it states: by comments of a PLY, the coordinate extension of an SPZ, or the standard of its
// format. And the turn of splats from one set of axes to another.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sdk/format/avatar_data.h"

namespace dpl {

/** Axes as a file states them. */
struct SplatAxes {
    std::string stated;        // in words: "x right, y up, z back", "up is (0, -1, 0)"; empty: the file states nothing
    Mat3d uprightFromFile{1};  // into our axes (x right, y up, z back); orthogonal. Determinant −1: the file's axes are mirrored
};

/** Axes by the directions of x, y and z: L or R, U or D, F or B, one of each pair, in any order. "RUB" are ours; F is away from the viewer
 *  of a picture. Nothing for other letters. */
std::optional<SplatAxes> axesOfLetters(std::string_view letters);

/** Axes of which only the up direction is known: the shortest turn to +y, from −y half a turn about x. Nothing for a vector without a
 *  direction. */
std::optional<SplatAxes> axesOfUp(const Vec3d& up);

/** What the comments of a PLY say (docs/formats/splats.md): our own axes, else a vertical axis as nerfstudio and Brush write it. A
 *  vertical axis that cannot be read becomes a note. */
SplatAxes axesOfComments(std::span<const std::string> comments, std::vector<std::string>& notes);

/** Whether the comments of a PLY say that it was trained antialiased (Brush, Postshot). */
bool antialiasedByComments(std::span<const std::string> comments);

/** The comments that state these axes and `antialiased`, without the word "comment". `letters` as for axesOfLetters. */
std::vector<std::string> commentsOf(std::string_view letters, bool antialiased);

/** Turns centres, rotations and SH: what lay at p lies at to·p. `to` is orthogonal; it may mirror. Exact where it only changes signs. */
void turnSplats(StaticSplatData& splats, const Mat3d& to);

}  // namespace dpl
