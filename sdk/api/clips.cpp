// SPDX-License-Identifier: Apache-2.0
// Clips of an avatar: those of its file and those that dplLoadClip added.
#include <cmath>

#include "sdk/api/api_state.h"
#include "sdk/motion/clip.h"
#include "sdk/motion/motion_clip.h"

using namespace dpl;
using namespace dpl::api;

Result<const ClipData*> dpl::api::clipOf(const Avatar& avatar, uint32_t clip) {
    if (clip < avatar.clips.size()) return avatar.clips[clip];
    return fail(Code::NotFound, "there is no clip {}; the avatar has {}", clip, avatar.clips.size());
}

extern "C" {

DplResult dplGetClipInfo(DplAvatar avatar, uint32_t clip, DplClipInfo* info) {
    return guarded("dplGetClipInfo", [&]() -> Status {
        DPL_TRY(const auto found, avatarOf(avatar));
        std::lock_guard lock(found->context->mutex);
        DPL_TRY(const ClipData* data, clipOf(*found, clip));
        DplClipInfo out{};
        out.name = data->name.c_str();
        out.durationS = clipDurationS(*data);
        out.keyCount = uint32_t(data->timesS.size());
        return writeStruct(info, out, "info");
    });
}

DplResult dplSetPoseFromClip(DplAvatar avatar, uint32_t clip, double timeS, int loop) {
    return guarded("dplSetPoseFromClip", [&]() -> Status {
        if (!std::isfinite(timeS)) return fail(Code::InvalidArgument, "timeS is not finite");
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        std::lock_guard lock(found->context->mutex);
        DPL_TRY(const ClipData* data, clipOf(*found, clip));
        const double t = loop != DPL_FALSE ? loopedTimeS(*data, timeS) : timeS;
        samplePose(*data, found->data->joints, t, found->pose);
        found->pose.before = found->clipMemories[clip].at(t, loop != DPL_FALSE);
        found->clock.setUntimed();
        return {};
    });
}

DplResult dplLoadClip(DplAvatar avatar, const uint8_t* data, size_t size, const DplClipOptions* options, uint32_t* clip) {
    return guarded("dplLoadClip", [&]() -> Status {
        if (data == nullptr || clip == nullptr) return fail(Code::InvalidArgument, "{} is NULL", data == nullptr ? "data" : "clip");
        DplClipOptions wanted{};
        if (options != nullptr) {
            DPL_TRY(wanted, readStruct<DplClipOptions>(options, "options", offsetof(DplClipOptions, animationName)));
            constexpr uint32_t kKnown = DPL_CLIP_KEEP_LEAD_IN | DPL_CLIP_KEEP_PLACE | DPL_CLIP_IN_PLACE | DPL_CLIP_AS_RECORDED;
            if (wanted.flags & ~kKnown) return fail(Code::InvalidArgument, "options has unknown flags {}", wanted.flags & ~kKnown);
        }
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        RetargetOptions how;
        how.keepLeadIn = (wanted.flags & DPL_CLIP_KEEP_LEAD_IN) != 0;
        how.keepPlace = (wanted.flags & DPL_CLIP_KEEP_PLACE) != 0;
        how.inPlace = (wanted.flags & DPL_CLIP_IN_PLACE) != 0;
        const bool asRecorded = (wanted.flags & DPL_CLIP_AS_RECORDED) != 0;
        how.levelHead = how.plantFeet = !asRecorded;
        const BodyShape body = asRecorded ? BodyShape() : BodyShape::of(found->data->joints, found->data->mesh);
        how.body = &body;
        const MotionChoice choice{wanted.animationName ? wanted.animationName : "", wanted.animation};
        DPL_TRY(ClipData made,  // outside the lock: the rig never changes
                readClip({data, size}, wanted.name ? wanted.name : "the clip", choice, found->data->joints, how));
        DPL_RETURN_IF_ERROR(checkClip(made, found->data->joints));
        auto kept = std::make_unique<ClipData>(std::move(made));
        ClipMemory memory = found->memoryOf(*kept);
        std::lock_guard lock(found->context->mutex);
        if (wanted.name)
            kept->name = wanted.name;
        else if (kept->name == "the clip")
            kept->name = formatText("clip {}", found->clips.size());
        found->added.push_back(std::move(kept));
        found->addClip(*found->added.back(), std::move(memory));
        *clip = uint32_t(found->clips.size() - 1);
        return {};
    });
}

}  // extern "C"
