// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/pipeline/train_frames.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/surface/mesh_raster.h"
#include "reconstruction/surface/triangle_labels.h"
#include "sdk/avatar/rig.h"
#include "sdk/math/coverage.h"

namespace dpl {
namespace {

constexpr uint8_t kLabelBody = 1;

void posedMesh(const std::vector<JointData>& joints, const MeshData& mesh, const Pose& pose, Jobs& jobs, std::vector<Vec3f>& positions) {
    std::vector<Mat3x4f> worldFromRest;
    jointTransforms(joints, pose, worldFromRest);
    skin(mesh, worldFromRest, jobs, positions);
}

}  // namespace

Result<TrainFrame> loadTrainFrame(const ScanFrame& frame, const Pose& pose) {
    if (frame.maskPath.empty())
        return fail(Code::InvalidArgument, "frame {} has no mask; add masks/{}.png, or let --models find the person", frame.name,
                    frame.name);
    TrainFrame out;
    out.name = frame.name;
    out.kind = frame.kind;
    out.camera = frame.camera;
    out.pose = pose;
    DPL_TRY(out.image, readFrameImage(frame));
    DPL_TRY(out.mask, readFrameMask(frame));
    if (!frame.labelsPath.empty()) {
        DPL_TRY(out.labels, readFrameLabels(frame));
    }
    return out;
}

Result<std::vector<TrainFrame>> loadTrainFrames(const SubjectData& subject, Split split, std::vector<size_t>* indices) {
    std::vector<TrainFrame> frames;
    for (size_t f = 0; f < subject.scan.frames.size(); ++f) {
        if (subject.scan.frames[f].split != split || (split == Split::Train && !subject.usable[f])) continue;
        DPL_TRY(TrainFrame frame, loadTrainFrame(subject.scan.frames[f], subject.fit.poses[f]));
        frames.push_back(std::move(frame));
        if (indices) indices->push_back(f);
    }
    return frames;
}

std::vector<uint8_t> voteTriangleLabels(const std::vector<JointData>& joints, const MeshData& mesh, const std::vector<TrainFrame>& frames,
                                        Jobs& jobs) {
    TriangleLabels votes(mesh.triangles.size());
    bool any = false;
    std::vector<Vec3f> positions;
    for (const TrainFrame& frame : frames) {
        if (frame.kind == FrameKind::Dynamic || frame.labels.pixels.empty()) continue;
        posedMesh(joints, mesh, frame.pose, jobs, positions);
        const MeshRaster raster = rasteriseMesh(positions, mesh.triangles, frame.camera);
        votes.add(raster, positions, mesh.triangles, frame.camera, frame.labels.pixels, frame.mask.pixels);
        any = true;
    }
    return any ? votes.finish(mesh.triangles, kLabelBody) : std::vector<uint8_t>();
}

float trainedPixelM(const std::vector<JointData>& joints, const std::vector<TrainFrame>& frames) {
    std::vector<std::pair<double, size_t>> pixels;  // size, joints that the frame shows
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

std::vector<glm::u8vec4> gatherVertexColours(const std::vector<JointData>& joints, const MeshData& mesh,
                                             const std::vector<TrainFrame>& frames, Jobs& jobs) {
    VertexColours colours(mesh.restPositions.size());
    std::vector<Vec3f> positions;
    for (const TrainFrame& frame : frames) {
        posedMesh(joints, mesh, frame.pose, jobs, positions);
        const MeshRaster raster = rasteriseMesh(positions, mesh.triangles, frame.camera);
        colours.add(raster, positions, mesh.triangles, frame.camera, frame.image.pixels, frame.mask.pixels);
    }
    return colours.finish(mesh.triangles);
}

}  // namespace dpl
