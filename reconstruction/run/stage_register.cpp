// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage_register.h"

#include <algorithm>

#include "reconstruction/output/package/poses_file.h"
#include "reconstruction/run/mesh_votes.h"
#include "reconstruction/run/precision_file.h"
#include "reconstruction/run/settings_json.h"
#include "reconstruction/run/stage_body_fit.h"
#include "reconstruction/run/stage_ingest.h"
#include "reconstruction/run/stage_surface.h"
#include "reconstruction/subject/body/priors.h"
#include "reconstruction/subject/body/swapped_sides.h"
#include "reconstruction/subject/garments/label_field.h"
#include "reconstruction/subject/registration/priors.h"
#include "reconstruction/subject/registration/register_frames.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

/** Values of the labels whose outlines are those of something rigid. */
std::vector<uint8_t> rigidLabels(const Scan& scan) {
    std::vector<uint8_t> labels;
    for (const ScanLabel& label : scan.labels)
        for (const char* name : {"body", "hair", "shoes"})
            if (label.name == name) labels.push_back(label.value);
    return labels;
}

/** 1 for triangles that move with their joints: skin, hair and shoes near the shaped body; without labels whatever lies tight to it. */
std::vector<uint8_t> rigidTriangles(const MeshData& mesh, std::span<const Vec3f> offsets, std::span<const uint8_t> triangleLabel,
                                    std::span<const uint8_t> rigid) {
    std::vector<uint8_t> out(mesh.triangles.size(), 0);
    for (size_t t = 0; t < out.size(); ++t) {
        float standOffM = 0;
        for (int k = 0; k < 3; ++k) standOffM = std::max(standOffM, glm::length(offsets[mesh.triangles[t][k]]));
        out[t] = triangleLabel.empty()
                     ? standOffM < priors::kTightStandOffM
                     : standOffM < priors::kRigidStandOffM && std::find(rigid.begin(), rigid.end(), triangleLabel[t]) != rigid.end();
    }
    return out;
}

}  // namespace

Status StageOf<RegisteredPoses>::inputs(StageInputs& in) {
    DPL_TRY(const FrameTable* table, in.part<FrameTable>());
    DPL_TRY([[maybe_unused]] const MetricCameras* cameras, in.part<MetricCameras>());
    in.value("training", table->trainingHash);
    in.value("settings", fieldsJson(RegisterSettings()));
    DPL_RETURN_IF_ERROR(in.use<FittedBody>());
    return in.use<FittedSurface>();
}

Status StageOf<RegisteredPoses>::make(StageInputs& in, StageContext& context) {
    DPL_TRY(const FrameTable* table, in.of<FrameTable>());
    DPL_TRY(const MetricCameras* metric, in.of<MetricCameras>());
    DPL_TRY(const FittedBody* body, in.of<FittedBody>());
    DPL_TRY(const FittedSurface* surface, in.of<FittedSurface>());
    const Scan& scan = table->scan;
    const MeshData mesh = surface->clothed(body->shaped.mesh);
    std::vector<std::vector<Keypoint>> keypoints(scan.frames.size());
    std::vector<TrainFrame> stills;
    RegisterInput input;
    for (size_t f = 0; f < scan.frames.size(); ++f) {
        const ScanFrame& frame = scan.frames[f];
        DPL_TRY(keypoints[f], readKeypoints(scan, frame));
        if (f < body->fit.swapped.size() && body->fit.swapped[f])
            keypoints[f] = withSidesSwapped(keypoints[f], scan.keypointNames, body->fit.swapped[f]);
        if (table->trains(f) && frame.kind != FrameKind::Dynamic) stills.push_back(table->frame(f, metric->cameras[f], surface->poses[f]));
        input.frames.push_back({frame.kind, frame.timeS, metric->cameras[f], surface->poses[f],
                                table->trains(f) ? table->lazyPicture(f) : LazyPicture(), keypoints[f], frame.split});
    }
    DPL_TRY(const std::vector<uint8_t> triangleLabel,
            voteTriangleLabels(body->shaped.joints, mesh, stills, votingLabels(scan.labels)[0].value, in.jobs()));
    const std::vector<uint8_t> labels = triangleLabel.empty() ? std::vector<uint8_t>() : rigidLabels(scan);
    const std::vector<uint8_t> rigid = rigidTriangles(mesh, surface->restOffsets, triangleLabel, labels);
    input.body = &body->shaped, input.surface = &mesh;
    input.triangleLabel = triangleLabel, input.rigidTriangle = rigid, input.outlineLabels = labels;
    input.keypointNames = scan.keypointNames, input.landmarks = body->fit.landmarks;
    // What the still frames show is too little for found keypoints (priors::kFoundKeypointSigma).
    input.keypointSigma = scan.keypointsFound || !(body->fit.keypointSigma > 0) ? keypointSigma(scan) : body->fit.keypointSigma;
    input.pictureWeight = scan.keypointsFound ? priors::kFoundPictureWeight : 1;
    input.searchLimbs = scan.keypointsFound;
    input.stillPose = body->fit.staticPose;
    DPL_TRY(Registration registration, registerFrames(input, {}, in.jobs()));
    for (size_t f = 0; f < body->fingers.size(); ++f)  // registration takes the fingers from the body fit
        registration.precisions[f] = together(registration.precisions[f], *body->fingers[f]);
    PosesFile file;
    for (const JointData& joint : body->shaped.joints) file.jointNames.push_back(joint.name);
    for (size_t f = 0; f < scan.frames.size(); ++f) {
        const ScanFrame& frame = scan.frames[f];
        file.frames.push_back({frame.name, frame.kind, frame.split, registration.poses[f], std::nullopt});
    }
    DPL_RETURN_IF_ERROR(writePrecisions(registration.precisions, context.folder / "precisions.bin"));
    return writeFileAtomically(context.folder / "poses.json", posesToJson(file));
}

Result<RegisteredPoses> StageOf<RegisteredPoses>::read(StageInputs& in, const std::filesystem::path& folder) {
    DPL_TRY(const FrameTable* table, in.of<FrameTable>());
    DPL_TRY(const FittedBody* body, in.of<FittedBody>());
    const size_t joints = body->shaped.joints.size();
    const std::filesystem::path path = folder / "poses.json";
    DPL_TRY(const PosesFile file, readPosesFile(path));
    if (file.frames.size() != table->rows())
        return fail(Code::CorruptData, "{} does not fit the scan; delete it and run again", path.string());
    RegisteredPoses registered;
    DPL_TRY(registered.precisions, readPrecisions(folder / "precisions.bin", file.frames.size(), joints));
    for (const FramePose& frame : file.frames) {
        if (frame.pose.localRotations.size() != joints)
            return fail(Code::CorruptData, "{} does not fit the body; delete it and run again", path.string());
        registered.poses.poses.push_back(frame.pose);
    }
    return registered;
}

Result<FrameSet> registeredFrames(StageInputs& in, Split split) {
    DPL_TRY(const FrameTable* table, in.of<FrameTable>());
    DPL_TRY(const MetricCameras* metric, in.of<MetricCameras>());
    DPL_TRY(const RegisteredPoses* registered, in.of<RegisteredPoses>());
    FrameSet set = table->frames(split, metric->cameras, registered->poses.poses);
    setPrecisions(set, registered->precisions);
    return set;
}

}  // namespace dpl
