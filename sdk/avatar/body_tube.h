// SPDX-License-Identifier: Apache-2.0
// The surface around a bone at rest, as a tube of varying width.
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "sdk/format/avatar_data.h"

namespace dpl {

struct BodyTube {
    static constexpr float kTaperM = 0.03f;  // beyond the ends of a tube its depth falls to zero over this length

    size_t joint = 0;
    Vec3f from{0}, along{0}, across{0}, third{0};  // at rest; axes: unit, at right angles
    float beginM = 0, endM = 0;                    // along the axis
    std::vector<float> radiiM;                     // by place along it and angle around it
    std::vector<float> widestM;                    // the largest radius at each place along it

    /** Around the line from a joint to a point: the vertices [first, last) of the mesh of which the joint has at least half. None where
     * they are too few, or the bone is too short. */
    static std::optional<BodyTube> of(std::span<const JointData> joints, const MeshData& mesh, size_t first, size_t last, size_t joint,
                                      const Vec3f& to);

    /** A point at rest as the tube sees it: along its axis from `from`, across it, and along the third axis. */
    Vec3f localOf(const Vec3f& atRest) const {
        const Vec3f p = atRest - from;
        return {glm::dot(p, along), glm::dot(p, across), glm::dot(p, third)};
    }
    struct Place {
        float distanceM = 0, radiusM = 0;  // from the axis; of the tube there
        float share = 0;                   // 1 within the tube, falls to 0 beyond its ends
    };
    /** None: beyond the ends, on the axis, where the tube has no surface, or surely farther from it than withinM, which costs little. */
    std::optional<Place> placeOf(const Vec3f& local, float withinM = std::numeric_limits<float>::infinity()) const;

private:
    float ringAt(float alongM) const;
    float radiusAt(float ring, float angleRad) const;
};

/** Joint that has at least half of a vertex; none for vertices between joints. */
std::optional<size_t> ownerOf(const MeshData& mesh, size_t vertex);

}  // namespace dpl
