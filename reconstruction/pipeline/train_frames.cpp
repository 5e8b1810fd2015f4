// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/pipeline/train_frames.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/surface/mesh_raster.h"
#include "reconstruction/surface/posed_positions.h"
#include "reconstruction/surface/triangle_labels.h"
#include "sdk/avatar/rig.h"
#include "sdk/math/coverage.h"

namespace dpl {

const char* frameKindName(FrameKind kind) {
    return kind == FrameKind::Dynamic ? "dynamic" : kind == FrameKind::StaticCloseup ? "static_closeup" : "static_full";
}

const char* splitName(Split split) {
    return split == Split::Test ? "test" : split == Split::Validation ? "validation" : "train";
}

Result<std::shared_ptr<const FramePicture>> Pictures::of(size_t frame) {
    if (!pictures_[frame]) {
        DPL_TRY(FramePicture picture, readFramePicture(scan_.frames[frame]));
        pictures_[frame] = std::make_shared<const FramePicture>(std::move(picture));
    }
    return pictures_[frame];
}

Result<TrainFrame> frameAt(const IngestedScan& ingested, size_t index, const Camerad& camera, const Pose& pose, Pictures& pictures) {
    const ScanFrame& frame = ingested.scan.frames[index];
    TrainFrame out{frame.name, frame.kind, camera, pose, nullptr, nullptr};
    DPL_TRY(out.picture, pictures.of(index));
    return out;
}

Result<FrameSet> framesOf(const IngestedScan& ingested, Split split, std::span<const Camerad> cameras, std::span<const Pose> poses,
                          Pictures& pictures) {
    FrameSet set;
    for (size_t f = 0; f < ingested.scan.frames.size(); ++f) {
        const ScanFrame& scanned = ingested.scan.frames[f];
        if (split == Split::Train ? !isTrainingFrame(ingested, f) : scanned.split != split || scanned.maskPath.empty()) continue;
        DPL_TRY(TrainFrame frame, frameAt(ingested, f, cameras[f], poses[f], pictures));
        set.frames.push_back(std::move(frame));
        set.indices.push_back(f);
    }
    return set;
}

void setPrecisions(FrameSet& set, std::span<const std::shared_ptr<const PosePrecision>> precisions) {
    for (size_t i = 0; i < set.frames.size(); ++i) set.frames[i].precision = precisions[set.indices[i]];
}

std::vector<size_t> silhouetteFrames(const IngestedScan& ingested) {
    std::vector<size_t> frames;
    for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::Dynamic}) {
        for (size_t f = 0; f < ingested.scan.frames.size(); ++f) {
            const ScanFrame& frame = ingested.scan.frames[f];
            if (isTrainingFrame(ingested, f) && frame.kind == kind && !frame.maskPath.empty()) frames.push_back(f);
        }
        if (!frames.empty()) break;
    }
    return frames;
}

std::vector<uint8_t> voteTriangleLabels(const std::vector<JointData>& joints, const MeshData& mesh, const std::vector<TrainFrame>& frames,
                                        uint8_t bodyLabel, Jobs& jobs) {
    TriangleLabels votes(mesh.triangles.size());
    bool any = false;
    std::vector<Vec3f> positions;
    for (const TrainFrame& frame : frames) {
        if (frame.kind == FrameKind::Dynamic || frame.picture->labels.pixels.empty()) continue;
        posedPositions(joints, mesh, frame.pose, jobs, positions);
        const MeshRaster raster = rasteriseMesh(positions, mesh.triangles, frame.camera);
        votes.add(raster, positions, mesh.triangles, frame.camera, frame.picture->labels.pixels, frame.picture->mask.pixels);
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

std::vector<glm::u8vec4> gatherVertexColours(const std::vector<JointData>& joints, const MeshData& mesh,
                                             const std::vector<TrainFrame>& frames, Jobs& jobs) {
    VertexColours colours(mesh.restPositions.size());
    std::vector<Vec3f> positions;
    for (const TrainFrame& frame : frames) {
        posedPositions(joints, mesh, frame.pose, jobs, positions);
        const MeshRaster raster = rasteriseMesh(positions, mesh.triangles, frame.camera);
        colours.add(raster, positions, mesh.triangles, frame.camera, frame.picture->image.pixels, frame.picture->mask.pixels);
    }
    return colours.finish(mesh.triangles);
}

}  // namespace dpl
