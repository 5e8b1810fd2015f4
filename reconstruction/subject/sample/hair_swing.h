// SPDX-License-Identifier: Apache-2.0
// How long hair moves: chains of points without stretch that gravity pulls down, the air brakes, and the body keeps out.
#pragma once

#include <cstdint>
#include <vector>

#include "reconstruction/subject/sample/body_solids.h"
#include "reconstruction/subject/sample/hair_locks.h"
#include "reconstruction/subject/sample/motion.h"

namespace dpl {

struct Subject;

/** One chain a lock. The first two nodes are stiff with the head; the others are points of equal mass, pulled towards their groomed place
 *  beside the head, the more the nearer they are to the root. Nodes are those of all locks, in order. The HairLocks must outlive it. */
class LockChains {
public:
    static constexpr double kStepS = 1.0 / 240;

    /** At rest at `start`, the nodes of the standing subject. */
    LockChains(const HairLocks& hair, std::vector<Vec3d> start);
    /** Moves on by kStepS, at the end of which the head and the solids are there. A node keeps at most 10 m/s of
     *  its speed, so that the energy stays finite in any motion. */
    void step(const Mat3x4d& worldFromHead, const PosedSolids& solids);
    const std::vector<Vec3d>& nodes() const { return at_; }

private:
    void step(size_t lock, const Mat3x4d& worldFromHead, const PosedSolids& solids);
    const HairLocks& hair_;
    std::vector<Vec3d> at_, speed_, next_;
};

/** Which way the nodes of a lock face: away from the body where it is near, else as the node before. `facing`: of the root. */
std::vector<LockNode> facingNodes(const std::vector<Vec3d>& nodes, const Vec3d& facing, const PosedSolids& solids);

/** The locks of a subject in motion, from rest at time 0. Subject and motion must outlive it. */
class HairSwing {
public:
    HairSwing(const Subject& subject, const SampleMotion& motion);
    /** Advances to `timeS`, which must not decrease, and returns the nodes of all locks. Empty without locks that swing. */
    std::vector<LockNode> at(double timeS);

private:
    const Subject& subject_;
    const SampleMotion& motion_;
    int64_t step_ = 0;
    LockChains chains_;
};

}  // namespace dpl
