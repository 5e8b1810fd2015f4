// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage_assemble.h"

#include <algorithm>

#include "reconstruction/output/package/sh_palette.h"
#include "reconstruction/run/film_memory.h"
#include "reconstruction/run/mesh_votes.h"
#include "reconstruction/run/scan_motion.h"
#include "reconstruction/run/stage_body_fit.h"
#include "reconstruction/run/stage_co_optimise.h"
#include "reconstruction/run/stage_garments.h"
#include "reconstruction/run/stage_ingest.h"
#include "reconstruction/run/stage_register.h"
#include "reconstruction/subject/garments/tuck_body.h"
#include "reconstruction/training/trainer/init.h"
#include "reconstruction/training/trainer/train_images.h"
#include "sdk/avatar/cloth_bounds.h"
#include "sdk/avatar/stress_poses.h"
#include "sdk/core/evenly_spaced.h"
#include "sdk/core/log.h"

namespace dpl {
namespace {

constexpr size_t kTuckedPoses = 64;  // of training, at most
constexpr int kMostMends = 3;

/** Clothes that sink into unseen skin in stress poses or in those of training stay outside it. */
Status tuckUnseenBody(AssembledAvatar& assembled, Jobs& jobs) {
    AvatarData& avatar = assembled.avatar;
    std::vector<Pose> poses = stressPoses(avatar.joints);
    for (const Pose& pose : evenlySpaced(movingPoses(assembled.frames), kTuckedPoses)) poses.push_back(pose);
    DPL_TRY(const TriangleSight sight, triangleSight({avatar.joints, avatar.mesh, assembled.triangleLabel, assembled.frames}, jobs));
    const size_t moved = tuckBody(avatar, sight.seen, poses, jobs);
    log(LogLevel::Info, "{} vertices of unseen skin are taken in below clothes", moved);
    return {};
}

}  // namespace

void mendGarments(AvatarData& avatar) {
    boundNewGarments(avatar.joints, avatar.mesh);
    for (int round = 0; round < kMostMends && boundGarments(avatar.joints, avatar.mesh).evened > 0; ++round) {
    }
}

Result<AvatarData> asReadersDecode(const AvatarData& avatar, Jobs& jobs) {
    DPL_TRY(AvatarData decoded, decodedAvatar(avatar));
    if (decoded.splats.shDegree == 0) return decoded;
    DPL_TRY(const ShPaletteReport palette, paletteSh(decoded.splats, kAvatarPalette, jobs));
    log(LogLevel::Info, "SH palette of {} entries, {} levels off", palette.entries, palette.rmsLevels);
    DPL_TRY(const auto bytes, writeAvatar(decoded, kPackaged));
    return readAvatar(bytes);
}

Status StageOf<AssembledAvatar>::inputs(StageInputs& in) {
    DPL_TRY(const FrameTable* table, in.part<FrameTable>());
    DPL_TRY([[maybe_unused]] const MetricCameras* cameras, in.part<MetricCameras>());
    DPL_TRY([[maybe_unused]] const FittedBody* body, in.part<FittedBody>());
    DPL_TRY([[maybe_unused]] const GarmentLayers* layers, in.part<GarmentLayers>());
    in.value("name", table->scan.name);
    in.value("shPaletteEntries", kAvatarPalette.maxEntries);
    in.value("shPaletteLevels", kAvatarPalette.maxRmsLevels);
    in.value("tuckedPoses", kTuckedPoses);
    DPL_RETURN_IF_ERROR(in.use<RegisteredPoses>());
    return in.use<Training>();
}

Result<AssembledAvatar> StageOf<AssembledAvatar>::compute(StageInputs& in) {
    DPL_TRY(const FrameTable* table, in.of<FrameTable>());
    DPL_TRY(const FittedBody* body, in.of<FittedBody>());
    DPL_TRY(const GarmentLayers* layers, in.of<GarmentLayers>());
    DPL_TRY(const Training* training, in.of<Training>());
    const CoOptimiseResult& trained = training->result;
    DPL_TRY(FrameSet set, registeredFrames(in, Split::Train));
    AssembledAvatar out;
    out.frames = std::move(set.frames);
    if (trained.poses.size() != out.frames.size())
        return fail(Code::CorruptData, "the trained file has {} poses for {} frames; delete the co-optimise stage and run again",
                    trained.poses.size(), out.frames.size());
    std::vector<Pose> poses = trained.poses;
    rememberPoses(table->scan, set.rows, trained.correctives.motion, poses);
    for (size_t i = 0; i < out.frames.size(); ++i) out.frames[i].pose = poses[i];

    AvatarData& avatar = out.avatar;
    avatar.name = table->scan.name;
    avatar.generator = "doppel reconstruct";
    avatar.joints = body->shaped.joints;
    avatar.kappaPx2 = kTrainedKappaPx2;
    avatar.trainedPixelM = trainedPixelM(avatar.joints, out.frames);
    avatar.mesh = layers->clothed.mesh;
    out.triangleLabel = layers->clothed.triangleLabel;
    avatar.mesh.restPositions = trained.restPositions;
    DPL_TRY(avatar.mesh.colours, gatherVertexColours(avatar.joints, avatar.mesh, out.frames, in.jobs()));
    avatar.splats = trained.splats;
    avatar.correctives = trained.correctives;
    avatar.light = trained.light;
    avatar.clips = scanMotion(table->scan, set.rows, trained.poses);
    sortSplats(avatar);
    DPL_RETURN_IF_ERROR(tuckUnseenBody(out, in.jobs()));

    const std::vector<Vec3f> trainedRest = avatar.mesh.restPositions;
    DPL_TRY(AvatarData decoded, decodedAvatar(avatar));
    avatar.mesh = decoded.mesh;  // the vertices that every reader decodes
    mendGarments(avatar);
    DPL_TRY([[maybe_unused]] uint32_t unchanged, rebaseSplats(trainedRest, avatar));
    DPL_TRY(avatar, asReadersDecode(avatar, in.jobs()));
    return out;
}

}  // namespace dpl
