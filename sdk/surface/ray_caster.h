// SPDX-License-Identifier: Apache-2.0
// The first triangle of a posed mesh that a ray meets.
//
//   load:  triangles ─► clusters of neighbours that hang on the same joint
//   pose:  vertices ─► one box a cluster
//   ray:   boxes, nearest first ─► triangles
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sdk/format/avatar_data.h"

namespace dpl {

/** From `origin` along `direction`, which is a unit vector. */
struct SurfaceRay {
    Vec3d origin{0}, direction{0, 0, 1};
};

struct RayHit {
    double distanceM = 0;
    uint32_t triangle = 0;
    Vec3d shares{0};  // of the corners of the triangle, sum 1
};

/** Of one mesh. One thread at a time. */
class RayCaster {
public:
    /** Takes tens of milliseconds. The mesh must have passed checkMesh. */
    explicit RayCaster(const MeshData& mesh);

    /** Takes the boxes from the posed vertices. */
    void follow(std::span<const Vec3f> positions);
    /** The nearest triangle, of either side, that the ray meets; ties go to the lower number. positions: those of the last follow(). left
     * out: one a triangle, or empty; triangles that are not 0 there do not count. A ray that meets an edge meets a triangle of it. */
    std::optional<RayHit> cast(std::span<const Vec3f> positions, const SurfaceRay& ray, std::span<const uint8_t> leftOut = {}) const;

private:
    struct Cluster {
        uint32_t triangles = 0, vertices = 0;  // ends of its ranges; they begin where those of the cluster before end
    };
    struct Box {
        Vec3f low, high;
    };
    std::vector<Cluster> clusters_;
    std::vector<Triangle> corners_;   // of all triangles, cluster by cluster
    std::vector<uint32_t> numbers_;   // of these triangles
    std::vector<uint32_t> vertices_;  // of the clusters
    std::vector<Box> boxes_;
    struct Entry {
        double at;
        uint32_t cluster;
    };
    mutable std::vector<Entry> entered_;  // scratch of cast
};

}  // namespace dpl
