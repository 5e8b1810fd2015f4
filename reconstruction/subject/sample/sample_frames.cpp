// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/sample_frames.h"

#include <atomic>

#include "reconstruction/subject/sample/raycast.h"
#include "reconstruction/subject/sample/scan_plan.h"
#include "sdk/core/task.h"

namespace dpl {

Result<std::vector<TrainFrame>> sampleFrames(const Subject& subject, const SampleScanOptions& options, Jobs& jobs) {
    const std::vector<PlannedFrame> planned = planScan(subject, options);
    std::vector<std::unique_ptr<PersonTracer>> tracers(jobs.threadCount());
    std::vector<TrainFrame> frames(planned.size());
    std::atomic<bool> stopped{false};
    std::atomic<size_t> done{0};
    Status goesOn;  // of the calling thread, which is worker 0
    jobs.forBlocks(planned.size(), [&](size_t f, uint32_t worker) {
        if (stopped) return;
        if (!tracers[worker]) tracers[worker] = std::make_unique<PersonTracer>(subject);
        const PlannedFrame& frame = planned[f];
        tracers[worker]->setVertices(
            poseSubject(subject, frame.pose, frame.kind == FrameKind::Dynamic ? &frame.lag : nullptr, frame.lockNodes));
        RaycastFrame drawn = tracers[worker]->render(frame.camera, sampleRays(options, f));
        const uint32_t width = frame.camera.widthPx, height = frame.camera.heightPx;
        FramePicture picture;
        picture.image.widthPx = picture.mask.widthPx = picture.labels.widthPx = width;
        picture.image.heightPx = picture.mask.heightPx = picture.labels.heightPx = height;
        picture.image.pixels = std::move(drawn.rgb), picture.mask.pixels = std::move(drawn.mask);
        picture.labels.pixels = std::move(drawn.labels);
        frames[f] = {frame.name, frame.kind, frame.camera, poseOf(frame.pose), std::make_shared<const FramePicture>(std::move(picture)),
                     nullptr};
        const size_t count = ++done;
        if (worker == 0) goesOn = taskAt(double(count) / double(planned.size()), frame.name), stopped = stopped || !goesOn;
    });
    DPL_RETURN_IF_ERROR(goesOn);
    return frames;
}

std::vector<Pose> sampleMotionPoses(const Subject& subject, const SampleScanOptions& options, uint32_t count) {
    const SampleMotion motion =
        SampleMotion::dynamicSequence(subject.seed, options.dynamicS, options.fingers, options.hair == Hairstyle::Long);
    std::vector<Pose> poses;
    for (uint32_t i = 0; i < count; ++i) poses.push_back(poseOf(motion.pose(options.dynamicS * (i + 1) / (count + 1))));
    return poses;
}

std::vector<uint8_t> triangleLabels(const Subject& subject) {
    std::vector<uint8_t> labels(subject.mesh.triangles.size(), 0);
    for (size_t layer = 0; layer < subject.parts.size(); ++layer) {
        const LayerData& range = subject.mesh.layers[layer];
        std::fill_n(labels.begin() + range.firstTriangle, range.triangleCount, subject.parts[layer].label);
    }
    return labels;
}

}  // namespace dpl
