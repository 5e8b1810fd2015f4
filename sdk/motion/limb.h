// SPDX-License-Identifier: Apache-2.0
// A limb of two bones (hip, knee, ankle or shoulder, elbow, wrist) whose end is moved.
#pragma once

#include <array>

#include "sdk/math/types.h"

namespace dpl {

inline const Quatf kNoTurn(1, 0, 0, 0);
constexpr float kWristTwistShare = 0.5f;  // of the twist of a wrist that the lower arm takes: one that turns alone would break

/** The shortest rotation from direction `from` to `to`; lengths do not matter. Identity if one has no length. */
Quatf shortestTurn(const Vec3f& from, const Vec3f& to);

/** The rotation that takes +Y to `up` and +X as near to `left` as it can; identity if they tell nothing. */
Quatf frameOf(const Vec3f& left, const Vec3f& up);

/** The rotation that takes direction a to `toA` exactly, and b to near `toB`. */
Quatf turnOf(const Vec3f& a, const Vec3f& b, const Vec3f& toA, const Vec3f& toB);

/** World rotations since rest of the two bones of a limb that points along `rest` at rest, bends about `hinge`, and now lies along `upper`
 *  and `lower`. before: rotation of what carries it. The plane of a bent limb tells its twist; a straight one hangs with the least turn. */
std::array<Quatf, 2> hingedLimb(const Quatf& before, const Vec3f& rest, const Vec3f& hinge, const Vec3f& upper, const Vec3f& lower);

/** World rotations that bring the end of a limb to `target`, metres. at: world positions of root, middle and end joint as they are.
 *  Returns the rotations to put in front of those of the upper and the lower bone. The middle joint stays in the plane in which the limb
 *  bends; `bend` is the side to which a straight limb bends. A target out of reach is approached as far as the limb is long. */
std::array<Quatf, 2> reachWith(const std::array<Vec3f, 3>& at, const Vec3f& target, const Vec3f& bend);

}  // namespace dpl
