// SPDX-License-Identifier: Apache-2.0
// A recorded motion with the skeleton that it was recorded on. The BVH and glTF readers return it; retargeting takes it.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Joint frames are parallel to the world at rest, as in JointData. The world rotation of joint j is D_j = D_parent · R_j; its position is
 *  x_j = x_parent + D_parent · (p_j − p_parent + translation_j). Axes and heading are those of the file. Lengths are metres; as files name
 *  no unit, it is guessed from the skeleton's height. */
struct Motion {
    std::string name;
    std::vector<JointData> joints;  // parents first; end sites are joints too, named "<parent> end"
    std::vector<float> timesS;      // K times, strictly rising from 0
    std::vector<Quatf> rotations;   // K × J, key-major, unit
    struct Translation {
        uint32_t joint = 0;
        std::vector<Vec3f> offsets;  // K, added to the rest offset, in the parent's frame, metres
    };
    std::vector<Translation> translations;
    float metresPerUnit = 1;         // factor applied to the lengths of the file: 1, 0.1, 0.0254, 0.01 or 0.001
    std::vector<std::string> notes;  // sentences: what was left out, or chosen among several

    size_t keyCount() const { return timesS.size(); }
};

/** World rotations and positions of all joints at one key. Both are resized to J. */
void motionAt(const Motion& motion, size_t key, std::vector<Quatf>& rotations, std::vector<Vec3f>& positions);

/** Metres per unit of a skeleton that is `height` units high: the one of m, dm, inch, cm and mm that brings it closest to 1.7 m. */
float guessMetresPerUnit(float height);

/** Converts all lengths to metres by the guessed unit. */
void scaleToMetres(Motion& motion);

/** Reads a BVH text, with any channel order, end sites, CRLF and blank lines. Position channels below the root are kept. Programs differ in
 *  whether these replace OFFSET or add to it; the first frame decides. Frames with numbers that are not finite, frames beyond those that
 *  'Frames:' promises and a last frame that is cut off are left out and noted. Any thread; the bytes may be freed on return.
 *  CorruptData, with the line number: not a BVH, no whole frame, an OFFSET that is not finite, more than 1024 joints or 10⁶ frames.
 *  Unsupported: a second ROOT. */
Result<Motion> readBvh(std::string_view text, std::string_view name);

/** Which animation of a glTF file to read. */
struct MotionChoice {
    std::string animation;  // its name, or else its number from 0; empty: `index`
    uint32_t index = 0;
};

/** Reads one animation of a glTF binary, with or without a skin. Bones are those that the file states (VRM 0, VRM 1, VRM animation). Its
 * keys are the union of the key times of all channels; if a channel is cubic, 60 keys per second are added. Where the file holds several
 *  animations and none was chosen by name, a note names them. Keys that are not sound are left out and noted. Errors as readSkinnedGltf;
 * NotFound: no such animation, the text lists them.
 */
Result<Motion> readGltfMotion(std::span<const uint8_t> bytes, std::string_view name, const MotionChoice& choice = {});

/** Reads either kind; the first bytes tell which. Unsupported: another kind of file; the text says which, and what to do. */
Result<Motion> readMotion(std::span<const uint8_t> bytes, std::string_view name, const MotionChoice& choice = {});

}  // namespace dpl
