// SPDX-License-Identifier: Apache-2.0
// Points on the clothed surface and how they look in the still pictures. Private to reconstruction/subject/registration.
#pragma once

#include "reconstruction/subject/registration/frame_features.h"
#include "reconstruction/subject/registration/surface_points.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "sdk/avatar/rig.h"

namespace dpl {

/** About `count` points, evenly spread over the area of the rest mesh. The same mesh gives the same points. */
std::vector<MeshPoint> spreadPoints(const MeshData& mesh, size_t count);

/** The mesh in one pose, drawn by one camera. */
struct DrawnMesh {
    std::vector<Vec3f> positions;
    MeshRaster raster;
};
/** One per pose; poses[i] is seen by cameras[i]. */
std::vector<DrawnMesh> drawMesh(std::span<const JointData> joints, const MeshData& mesh, std::span<const Pose> poses,
                                std::span<const Camerad> cameras, Jobs& jobs);

/** A point that a picture shows: not hidden, and not seen at a grazing angle. */
struct SeenPoint {
    uint32_t point = 0;
    Vec2d px{0};
};
std::vector<SeenPoint> seenPoints(const MeshData& mesh, std::span<const MeshPoint> points, const DrawnMesh& drawn, const Camerad& camera);

/** Contrast of a point over the still pictures. */
struct PointContrast {
    Vec3d median{0};
    double spread = 0;  // standard deviation of a channel between pictures, from the median of deviations
    bool known = false;
};

/** One still picture: which points it shows, and its contrast. */
struct StillContrast {
    std::span<const SeenPoint> seen;
    const ContrastImage* image = nullptr;
};
/** A point is known when at least three pictures show it. */
std::vector<PointContrast> gatherContrast(size_t pointCount, std::span<const StillContrast> stills);

}  // namespace dpl
