// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/mesh_votes.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/surface/mesh_raster.h"
#include "reconstruction/subject/surface/posed_positions.h"
#include "reconstruction/subject/surface/triangle_labels.h"
#include "sdk/avatar/rig.h"
#include "sdk/math/coverage.h"

namespace dpl {

Result<std::vector<uint8_t>> voteTriangleLabels(const std::vector<JointData>& joints, const MeshData& mesh,
                                                const std::vector<TrainFrame>& frames, uint8_t bodyLabel, Jobs& jobs) {
    TriangleLabels votes(mesh.triangles.size());
    bool any = false;
    std::vector<Vec3f> positions;
    for (const TrainFrame& frame : frames) {
        if (frame.kind == FrameKind::Dynamic) continue;
        DPL_TRY(const auto picture, frame.picture.get());
        if (picture->labels.pixels.empty()) continue;
        posedPositions(joints, mesh, frame.pose, jobs, positions);
        const MeshRaster raster = rasteriseMesh(positions, mesh.triangles, frame.camera);
        votes.add(raster, positions, mesh.triangles, frame.camera, picture->labels.pixels, picture->mask.pixels);
        any = true;
    }
    return any ? votes.finish(mesh.triangles, bodyLabel) : std::vector<uint8_t>();
}

float trainedPixelM(const std::vector<JointData>& joints, const std::vector<TrainFrame>& frames) {
    std::vector<std::pair<double, size_t>> pixels;  // pixel size in metres, number of joints that the frame shows
    size_t total = 0;
    std::vector<Mat3x4f> worldFromRest;
    for (const TrainFrame& frame : frames) {
        const Camerad& camera = frame.camera;
        jointTransforms(joints, frame.pose, worldFromRest);
        size_t shown = 0;
        for (size_t j = 0; j < joints.size(); ++j) {
            const Vec3d view = camera.toView(Vec3d(worldFromRest[j] * Vec4f(joints[j].restPosition, 1)));
            const Vec2d at = camera.pixelOf(view);
            shown += view.z > 0 && at.x >= 0 && at.y >= 0 && at.x < camera.widthPx && at.y < camera.heightPx;
        }
        const double size = pixelAtM(camera, Vec3d(rootPosition(joints, frame.pose)));
        if (!(size > 0) || !std::isfinite(size)) continue;
        pixels.push_back({size, shown});
        total += shown;
    }
    std::sort(pixels.begin(), pixels.end());
    size_t seen = 0;
    for (const auto& [size, shown] : pixels)
        if (shown > 0 && 2 * (seen += shown) >= total) return float(size);
    return 0;
}

Result<std::vector<glm::u8vec4>> gatherVertexColours(const std::vector<JointData>& joints, const MeshData& mesh,
                                                     const std::vector<TrainFrame>& frames, Jobs& jobs) {
    VertexColours colours(mesh.restPositions.size());
    std::vector<Vec3f> positions;
    for (const TrainFrame& frame : frames) {
        DPL_TRY(const auto picture, frame.picture.get());
        posedPositions(joints, mesh, frame.pose, jobs, positions);
        const MeshRaster raster = rasteriseMesh(positions, mesh.triangles, frame.camera);
        colours.add(raster, positions, mesh.triangles, frame.camera, picture->image.pixels, picture->mask.pixels);
    }
    return colours.finish(mesh.triangles);
}

}  // namespace dpl
