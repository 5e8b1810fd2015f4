// SPDX-License-Identifier: Apache-2.0
// Trackers: what platforms tell of a person, as poses of an avatar.
#include "sdk/api/api_state.h"
#include "sdk/motion/tracker.h"

using namespace dpl;
using namespace dpl::api;

namespace {

/** The object behind a DplTracker. */
struct TrackerSlot {
    std::mutex mutex;  // guards the rest. Locked before that of the context, which dplTrackFrame never takes
    DplAvatar avatar = nullptr;
    bool overPose = false;
    std::unique_ptr<Tracker> tracker;
    Pose pose;  // scratch
};

HandleTable<TrackerSlot>& trackers() {
    static auto* table = new HandleTable<TrackerSlot>(0x1004);  // never freed, as contexts()
    return *table;
}

Result<std::shared_ptr<TrackerSlot>> trackerOf(DplTracker handle) {
    auto slot = trackers().find(reinterpret_cast<uintptr_t>(handle));
    if (!slot) return fail(Code::InvalidArgument, "{} is not a live tracker", handle ? "the handle" : "0");
    return slot;
}

std::span<const float> floats(const float* numbers, size_t count) {
    return numbers != nullptr ? std::span(numbers, count) : std::span<const float>();
}

DplTrackerStatus statusOf(const TrackerStatus& now) {
    DplTrackerStatus out{};
    out.state = DplTrackerState(now.state);
    out.drivenJoints = now.drivenJoints;
    out.framesTaken = now.framesTaken, out.framesDropped = now.framesDropped;
    out.rateHz = now.rateHz, out.noiseDeg = now.noiseDeg, out.delayS = now.delayS, out.predictedS = now.predictedS;
    return out;
}

}  // namespace

extern "C" {

DplResult dplGetTrackJointName(DplTrackFormat format, uint32_t joint, const char** name) {
    return guarded("dplGetTrackJointName", [&]() -> Status {
        if (name == nullptr) return fail(Code::InvalidArgument, "name is NULL");
        const auto table = trackedJoints(TrackFormat(format));
        if (joint >= table.size())
            return fail(Code::NotFound, "there is no joint {} of format {}; it has {}", joint, int(format), table.size());
        *name = table[joint].name.c_str();
        return {};
    });
}

DplResult dplCreateTracker(DplAvatar avatar, const DplTrackerInfo* info, DplTracker* tracker) {
    return guarded("dplCreateTracker", [&]() -> Status {
        if (tracker == nullptr) return fail(Code::InvalidArgument, "tracker is NULL");
        DPL_TRY(const DplTrackerInfo wanted, readStruct<DplTrackerInfo>(info, "info"));
        constexpr uint32_t kKnown = DPL_TRACKER_RAW | DPL_TRACKER_KEEP_PLACE | DPL_TRACKER_IN_PLACE | DPL_TRACKER_OVER_POSE;
        if (wanted.flags & ~kKnown) return fail(Code::InvalidArgument, "info has unknown flags {}", wanted.flags & ~kKnown);
        const auto table = trackedJoints(TrackFormat(wanted.format));
        if (wanted.restCount != 0 && wanted.restCount != table.size())
            return fail(Code::InvalidArgument, "restCount is {}; format {} has {} joints", wanted.restCount, int(wanted.format),
                        table.size());
        if (wanted.restCount != 0 && (wanted.restRotations == nullptr || wanted.restPositions == nullptr))
            return fail(Code::InvalidArgument, "restRotations or restPositions is NULL, restCount is {}", wanted.restCount);
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        TrackFrame rest;
        if (wanted.restCount != 0)
            rest.rotations = floats(wanted.restRotations, 4 * size_t(wanted.restCount)),
            rest.positions = floats(wanted.restPositions, 3 * size_t(wanted.restCount));
        TrackerOptions options;
        options.raw = (wanted.flags & DPL_TRACKER_RAW) != 0;
        options.keepPlace = (wanted.flags & DPL_TRACKER_KEEP_PLACE) != 0;
        options.inPlace = (wanted.flags & DPL_TRACKER_IN_PLACE) != 0;
        auto slot = std::make_shared<TrackerSlot>();
        DPL_TRY(slot->tracker, Tracker::create(found->data->joints, TrackFormat(wanted.format), options, rest));
        slot->tracker->guardArms(BodyShape::of(found->data->joints, found->data->mesh));
        slot->avatar = avatar;
        slot->overPose = (wanted.flags & DPL_TRACKER_OVER_POSE) != 0;
        *tracker = reinterpret_cast<DplTracker>(trackers().add(std::move(slot)));
        return {};
    });
}

DplResult dplDestroyTracker(DplTracker tracker) {
    return guarded("dplDestroyTracker", [&]() -> Status {
        if (tracker == nullptr) return {};
        if (!trackers().take(reinterpret_cast<uintptr_t>(tracker)))
            return fail(Code::InvalidArgument, "the handle is not a live tracker; was it destroyed before?");
        return {};
    });
}

DplResult dplTrackFrame(DplTracker tracker, const DplTrackFrame* frame) {
    return guarded("dplTrackFrame", [&]() -> Status {
        DPL_TRY(const DplTrackFrame given, readStruct<DplTrackFrame>(frame, "frame"));
        DPL_TRY(const auto slot, trackerOf(tracker));
        std::lock_guard lock(slot->mutex);
        if (given.jointCount != slot->tracker->trackedCount())
            return fail(Code::InvalidArgument, "jointCount is {}; the tracker's format has {} joints", given.jointCount,
                        slot->tracker->trackedCount());
        TrackFrame in;
        in.timeNs = given.timeNs;
        in.rotations = floats(given.rotations, 4 * size_t(given.jointCount));
        in.positions = floats(given.positions, 3 * size_t(given.jointCount));
        in.confidence = floats(given.confidence, given.jointCount);
        return slot->tracker->add(in);
    });
}

DplResult dplSetPoseFromTracker(DplTracker tracker, int64_t displayTimeNs, DplTrackerStatus* status) {
    return guarded("dplSetPoseFromTracker", [&]() -> Status {
        DPL_TRY(const auto slot, trackerOf(tracker));
        if (status != nullptr) DPL_RETURN_IF_ERROR(readStruct<DplTrackerStatus>(status, "status"));
        DPL_TRY(const auto found, avatarOf(slot->avatar));
        std::lock_guard lock(slot->mutex);
        std::lock_guard contextLock(found->context->mutex);
        if (slot->overPose)
            slot->pose = found->pose;
        else
            slot->pose.localRotations.assign(found->data->joints.size(), Quatf(1, 0, 0, 0)), slot->pose.rootTranslation = Vec3f(0);
        slot->tracker->pose(displayTimeNs, !slot->overPose, slot->pose);
        DPL_RETURN_IF_ERROR(checkPose(found->data->joints, slot->pose));
        std::swap(found->pose, slot->pose);
        found->clock.setTime(displayTimeNs);
        if (status != nullptr) return writeStruct(status, statusOf(slot->tracker->status()), "status");
        return {};
    });
}

}  // extern "C"
