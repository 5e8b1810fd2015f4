// SPDX-License-Identifier: Apache-2.0
// Mixes of clips, and avatars that look at a point.
#include "sdk/api/api_state.h"

using namespace dpl;
using namespace dpl::api;

namespace {

/** The context's mutex must be held. i: number of the layer in the text of an error; the name of a parameter, where there is one layer. */
template <class Which>
Result<ClipLayer> layerOf(const Avatar& avatar, const DplClipLayer& given, const Which& i) {
    if (const uint32_t unknown = given.flags & ~uint32_t(DPL_LAYER_LOOP | DPL_LAYER_TRAVEL))
        return fail(Code::InvalidArgument, "layer {}: unknown flags {}", i, unknown);
    const auto clip = clipOf(avatar, given.clip);
    if (!clip)
        return fail(clip.error().code, "layer {}: {}; a clip is of the avatar that loaded it, so load it onto this one too", i,
                    clip.error().message);
    ClipLayer layer{*clip, given.timeS, given.weight, given.joint};
    layer.loops = (given.flags & DPL_LAYER_LOOP) != 0, layer.travels = (given.flags & DPL_LAYER_TRAVEL) != 0;
    layer.place = {given.headingRad, {given.shiftM[0], given.shiftM[1]}};
    return layer;
}

/** 0 in a limit means the usual one. */
Vec2f limitOf(const float (&given)[2], const Vec2f& usual) {
    return {given[0] == 0 ? usual.x : given[0], given[1] == 0 ? usual.y : given[1]};
}

}  // namespace

extern "C" {

DplResult dplSetPoseFromClips(DplAvatar avatar, const DplClipLayer* layers, uint32_t layerCount, int64_t timeNs) {
    return guarded("dplSetPoseFromClips", [&]() -> Status {
        if (layers == nullptr) return fail(Code::InvalidArgument, "layers is NULL");
        if (layerCount == 0 || layerCount > DPL_MAX_CLIP_LAYERS)
            return fail(Code::InvalidArgument, "{} layers; 1 to {} are mixed", layerCount, DPL_MAX_CLIP_LAYERS);
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        std::lock_guard lock(found->context->mutex);
        found->layers.clear();
        for (uint32_t i = 0; i < layerCount; ++i) {
            DPL_TRY(const DplClipLayer given, element(layers, i, "layers"));
            DPL_TRY(const ClipLayer layer, layerOf(*found, given, i));
            found->layers.push_back(layer);
        }
        Pose& pose = found->givenPose;
        DPL_RETURN_IF_ERROR(found->mix.mix(found->layers, found->data->joints, pose));
        DPL_RETURN_IF_ERROR(checkPose(found->data->joints, pose));
        std::swap(found->pose, pose);
        found->clock.setTime(timeNs);
        return {};
    });
}

DplResult dplJoinClipLayer(DplAvatar avatar, const DplClipLayer* before, DplClipLayer* layer) {
    return guarded("dplJoinClipLayer", [&]() -> Status {
        DPL_TRY(const DplClipLayer from, readStruct<DplClipLayer>(before, "before"));
        DPL_TRY(DplClipLayer to, readStruct<DplClipLayer>(layer, "layer"));
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        std::lock_guard lock(found->context->mutex);
        DPL_TRY(ClipLayer first, layerOf(*found, from, "'before'"));
        DPL_TRY(ClipLayer second, layerOf(*found, to, "'layer'"));
        const std::span<const JointData> joints = found->data->joints;
        first.weight = second.weight = 1;  // a fade begins with 0
        first.joint = second.joint = 0, second.place = {};
        for (const ClipLayer& each : {first, second}) DPL_RETURN_IF_ERROR(ClipMix::check({&each, 1}, joints));
        const GroundPlace place = placeAfter(first, second, joints);
        to.headingRad = float(place.headingRad), to.shiftM[0] = float(place.shiftM.x), to.shiftM[1] = float(place.shiftM.y);
        return writeStruct(layer, to, "layer");
    });
}

DplResult dplLookAtPoint(DplAvatar avatar, const DplGaze* gaze) {
    return guarded("dplLookAtPoint", [&]() -> Status {
        DPL_TRY(const DplGaze given, readStruct<DplGaze>(gaze, "gaze"));
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        std::lock_guard lock(found->context->mutex);
        const std::vector<JointData>& joints = found->data->joints;
        if (!found->gazeJoints) {
            DPL_TRY(found->gazeJoints, GazeJoints::of(joints));
        }
        Gaze wanted;
        wanted.target = Vec3f(given.target[0], given.target[1], given.target[2]);
        wanted.headWeight = given.headWeight, wanted.eyeWeight = given.eyeWeight;
        wanted.headLimitRad = limitOf(given.headLimitRad, kUsualHeadLimitRad);
        wanted.eyeLimitRad = limitOf(given.eyeLimitRad, kUsualEyeLimitRad);
        return lookAt(joints, *found->gazeJoints, wanted, found->pose, found->transforms);
    });
}

}  // extern "C"
