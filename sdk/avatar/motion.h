// SPDX-License-Identifier: Apache-2.0
// A recorded motion on the skeleton it was recorded with: what the BVH and glTF readers give, and what retargeting takes.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Frames are parallel to the world at rest, as in JointData: world rotation of joint j is D_j = D_parent · R_j, and its position is
 *  x_j = x_parent + D_parent · (p_j − p_parent + translation_j). Axes and heading are the file's; lengths are metres as far as the
 *  skeleton's height tells (a file has no unit). */
struct Motion {
    std::string name;
    std::vector<JointData> joints;  // parents first; end sites are joints too, named "<parent> end"
    std::vector<float> timesS;      // strictly rising, from 0; K of them
    std::vector<Quatf> rotations;   // K × J, key-major, unit
    struct Translation {
        uint32_t joint = 0;
        std::vector<Vec3f> offsets;  // K, beside the rest offset, in the parent's frame, metres
    };
    std::vector<Translation> translations;
    float metresPerUnit = 1;  // what the file's lengths were multiplied by: 1, 0.1, 0.0254, 0.01 or 0.001

    size_t keyCount() const { return timesS.size(); }
};

/** World rotations and positions of all joints at one key. Both are resized to J. */
void motionAt(const Motion& motion, size_t key, std::vector<Quatf>& rotations, std::vector<Vec3f>& positions);

/** Rest heights of people lie between 0.5 and 2.5 m; the unit among m, dm, inch, cm, mm that brings `height` closest to 1.7 m. */
float guessMetresPerUnit(float height);

/** Multiplies all lengths by the guessed unit. */
void scaleToMetres(Motion& motion);

/** Reads a BVH text. Any channel order, end sites, CRLF and blank lines are fine. Position channels below the root are kept; whether they
 *  replace or add to OFFSET differs between programs and is told by the first frame. Any thread; the bytes may be freed on return.
 *  CorruptData with the line number: not a BVH, truncated, numbers that are not finite, more than 1024 joints or 10⁶ frames. */
Result<Motion> readBvh(std::string_view text, std::string_view name);

/** Reads animation `animation` of a skinned glTF binary; keys are the union of all channels' key times (cubic ones sampled at 60 Hz too).
 *  Errors as readSkinnedGltf; NotFound: no such animation, the text lists the names. */
Result<Motion> readGltfMotion(std::span<const uint8_t> bytes, std::string_view name, uint32_t animation = 0);

/** Either of the two, told apart by the first bytes. */
Result<Motion> readMotion(std::span<const uint8_t> bytes, std::string_view name, uint32_t animation = 0);

}  // namespace dpl
