// SPDX-License-Identifier: Apache-2.0
// Hair with thickness: pointed locks of triangles that are rooted on the subject's hair layer and belong to it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sdk/math/types.h"

namespace dpl {

class BodySolids;
class Jobs;
struct Subject;

/** The hair of a subject: a close cap without locks, or locks that stand off a thin cap, or that hang from it and swing. */
enum class Hairstyle : uint8_t { Cap, Short, Long };

/** A place on a lock's middle line. */
struct LockNode {
    Vec3d at{0};      // metres
    Vec3d facing{0};  // unit, away from the body: a lock is flat, and this is the normal of its flat side
};

struct HairLock {
    uint32_t rootTriangle = 0;  // of the subject's mesh, in the hair layer
    Vec3f rootWeights{0};       // of that triangle's corners
    double lengthM = 0, halfWidthM = 0, halfThicknessM = 0;
    std::vector<LockNode> rest;      // from the root to the tip, evenly spaced; of long hair after it has settled
    std::vector<Vec3d> groomed;      // where combing alone puts the nodes of the standing subject
    std::vector<double> clearanceM;  // per node: how far the body keeps it away

    double linkM() const { return lengthM / double(rest.size() - 1); }
};

struct HairLocks {
    Hairstyle style = Hairstyle::Cap;
    std::vector<HairLock> locks;
    uint32_t nodesPerLock = 0;
    uint32_t firstVertex = 0, firstTriangle = 0;  // in the subject's mesh; locks follow each other to the end of the hair layer
    double frequencyHz = 0, damping = 0;          // of the pull towards the groomed shape; damping 1: critical
    std::shared_ptr<const BodySolids> solids;     // what locks that swing stay out of

    bool swing() const { return style == Hairstyle::Long; }
    uint32_t verticesPerLock() const;
};

/** Chooses roots all over the hair layer, the subject's last so far, and appends the vertices and triangles of their locks to it, all
 *  vertices at the roots. */
void sowLocks(Subject& subject, Hairstyle style);

/** Gives the locks of a finished subject their shape: lengths and directions by the seed; long hair is left to hang until it is still.
 *  Same bytes for any thread count. */
void growLocks(Subject& subject, Jobs& jobs);

/** Sets vertices, weights and coordinates of textures of the subject's locks from their nodes at rest. */
void dressLocks(Subject& subject);

/** The vertices of locks with these nodes (those of all locks, in order), to vertices[firstVertex] and on. */
void placeLocks(const HairLocks& hair, std::span<const LockNode> nodes, std::vector<Vec3d>& vertices);

}  // namespace dpl
