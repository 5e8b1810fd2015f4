// SPDX-License-Identifier: Apache-2.0
// What is weak in an avatar's pose, in colour over the picture, as far as the SDK tells of it: triangles that skinning stretches or
// squeezes, and joints that are bent as training never was.
#pragma once

#include <array>
#include <span>

#include "apps/viewer/subject.h"

namespace dpl {

enum class Overlay : uint8_t { None, Needles, Trust, Hidden };  // Hidden: hidden_splats.h

/** How much a triangle is stretched from rest to pose: the singular values of the map between both in their planes. A triangle without
 *  area at rest: 1 and 1. */
struct Stretch {
    float most = 1, least = 1;
};
Stretch stretchOf(const std::array<Vec3f, 3>& rest, const std::array<Vec3f, 3>& posed);

/** Pictures bound what lies outside kLeast to kMost, and leave out what is torn (docs/reference/binding.md). */
struct StretchLimits {
    static constexpr float kMost = 1.7f, kLeast = 0.5f, kTornMost = 3, kTornLeast = 1.0f / 3;
};

/** A triangle outside the limits, world, metres. */
struct WeakTriangle {
    std::array<Vec3f, 3> corners;
    bool torn = false;
};

/** A joint and how far it is bent from what was trained: in standard deviations, up to 2 is usual, above 4 was hardly seen; negative: not
 *  known. */
struct JointTrust {
    Vec3f place{0};  // world, metres
    float distance = -1;
};

struct OverlayShapes {
    std::vector<WeakTriangle> triangles;
    std::vector<JointTrust> joints;
    std::vector<Vec3f> hidden;  // places of splats, world, metres
    std::string words;          // what is seen, or why nothing can be
};

/** The shapes of avatars' poses. Keeps their meshes at rest. */
class OverlayMaker {
public:
    /** Puts the avatar into its rest pose for a moment when it is asked for the first time: pose it anew after. The result is that of the
     *  pose that it had at the last call of shapes(). */
    Result<OverlayShapes> shapes(ViewedSubject& subject, Overlay overlay, const Playback& clock, double nowS);

private:
    Result<OverlayShapes> needles(ViewedSubject& subject, const Playback& clock, double nowS);
    DplAvatar restOf_ = nullptr;
    std::vector<float> rest_, posed_;
    std::vector<uint32_t> triangles_;
};

}  // namespace dpl
