// SPDX-License-Identifier: Apache-2.0
// Avatars: queries and poses.
#include <algorithm>
#include <cmath>
#include <optional>

#include "sdk/api/api_state.h"
#include "sdk/api/surface.h"
#include "sdk/avatar/capture_zoom.h"

namespace dpl::api {

Avatar::Avatar() = default;

Avatar::~Avatar() {
    if (renderId == 0) return;  // of a load that failed early; perhaps it has no context yet
    std::lock_guard lock(context->mutex);
    if (context->renderer) context->renderer->removeAvatar(renderId);
}

Result<std::shared_ptr<Avatar>> avatarOf(DplAvatar handle) {
    auto avatar = avatars().find(reinterpret_cast<uintptr_t>(handle));
    if (!avatar) return fail(Code::InvalidArgument, "{} is not a live avatar", handle ? "the handle" : "0");
    return avatar;
}

Status checkPosable(const Avatar& avatar) {
    if (!avatar.data->joints.empty()) return {};
    return fail(Code::InvalidArgument, "these are general splats ({}): they have no joints, so there is nothing to pose",
                avatar.data->name);
}

namespace {

Status checkTrained(const Avatar& avatar) {
    if (avatar.data->correctives.followsPose()) return {};
    return fail(Code::Unsupported, "{} has no pose correctives, so it has no record of its training poses", avatar.data->name);
}

Status wrongJointCount(const Avatar& avatar, uint32_t jointCount) {
    return fail(Code::InvalidArgument, "jointCount is {}, the avatar has {} joints", jointCount, avatar.data->joints.size());
}

/** timeNs: none for dplSetPose, which knows no time. */
Status setPose(DplAvatar avatar, const float* rotations, uint32_t jointCount, const float* rootTranslation, std::optional<int64_t> timeNs) {
    if (rotations == nullptr) return fail(Code::InvalidArgument, "rotations is NULL");
    DPL_TRY(const auto found, avatarOf(avatar));
    DPL_RETURN_IF_ERROR(checkPosable(*found));
    if (jointCount != found->data->joints.size()) return wrongJointCount(*found, jointCount);
    std::lock_guard lock(found->context->mutex);
    Pose& pose = found->givenPose;  // reused, because apps set a pose every frame; found->pose stays unless all checks pass
    pose.localRotations.resize(jointCount);
    for (uint32_t j = 0; j < jointCount; ++j) {
        const float* q = rotations + size_t(j) * 4;
        pose.localRotations[j] = Quatf(q[3], q[0], q[1], q[2]);
    }
    pose.rootTranslation = rootTranslation != nullptr ? Vec3f(rootTranslation[0], rootTranslation[1], rootTranslation[2]) : Vec3f(0);
    DPL_RETURN_IF_ERROR(checkPose(found->data->joints, pose));
    for (Quatf& q : pose.localRotations) q = glm::normalize(q);
    pose.before = {};
    std::swap(found->pose, pose);
    if (timeNs)
        found->clock.setTime(*timeNs);
    else
        found->clock.setUntimed();
    return {};
}

}  // namespace
}  // namespace dpl::api

using namespace dpl;
using namespace dpl::api;

extern "C" {

DplResult dplDestroyAvatar(DplAvatar avatar) {
    return guarded("dplDestroyAvatar", [&]() -> Status {
        if (avatar == nullptr) return {};
        if (!avatars().take(reinterpret_cast<uintptr_t>(avatar)))
            return fail(Code::InvalidArgument, "the handle is not a live avatar; was it destroyed before?");
        return {};
    });
}

DplResult dplGetAvatarInfo(DplAvatar avatar, DplAvatarInfo* info) {
    return guarded("dplGetAvatarInfo", [&]() -> Status {
        DPL_TRY(const auto found, avatarOf(avatar));
        std::lock_guard lock(found->context->mutex);
        const AvatarData& data = *found->data;
        DplAvatarInfo out{};
        out.name = data.name.c_str();
        out.jointCount = uint32_t(data.joints.size());
        out.splatCount = found->splatCount;
        out.vertexCount = uint32_t(data.mesh.restPositions.size());
        out.triangleCount = uint32_t(data.mesh.triangles.size());
        out.layerCount = uint32_t(data.mesh.layers.size());
        out.clipCount = uint32_t(found->clips.size());
        out.shDegree = found->shDegree;
        for (int axis = 0; axis < 3; ++axis) out.restMin[axis] = found->restMin[axis], out.restMax[axis] = found->restMax[axis];
        out.fileSplatCount = found->fileSplatCount, out.fileShDegree = found->fileShDegree;
        return writeStruct(info, out, "info", offsetof(DplAvatarInfo, fileSplatCount));
    });
}

DplResult dplGetFileAxes(DplAvatar avatar, DplFileAxes* axes) {
    return guarded("dplGetFileAxes", [&]() -> Status {
        DPL_TRY(const auto found, avatarOf(avatar));
        DplFileAxes out{};
        out.stated = found->axesStated ? DPL_TRUE : DPL_FALSE;
        for (int column = 0; column < 3; ++column)
            for (int row = 0; row < 3; ++row) out.loadedFromFile[3 * column + row] = float(found->loadedFromFile[column][row]);
        return writeStruct(axes, out, "axes");
    });
}

DplResult dplGetJointInfo(DplAvatar avatar, uint32_t joint, DplJointInfo* info) {
    return guarded("dplGetJointInfo", [&]() -> Status {
        DPL_TRY(const auto found, avatarOf(avatar));
        const std::vector<JointData>& joints = found->data->joints;
        if (joint >= joints.size()) return fail(Code::NotFound, "there is no joint {}; the avatar has {}", joint, joints.size());
        DplJointInfo out{};
        out.name = joints[joint].name.c_str();
        out.humanoidBone = joints[joint].humanoidBone.c_str();
        out.parent = joints[joint].parent;
        for (int axis = 0; axis < 3; ++axis) out.restPosition[axis] = joints[joint].restPosition[axis];
        return writeStruct(info, out, "info");
    });
}

DplResult dplFindJoint(DplAvatar avatar, const char* name, uint32_t* joint) {
    return guarded("dplFindJoint", [&]() -> Status {
        if (name == nullptr || joint == nullptr) return fail(Code::InvalidArgument, "{} is NULL", name == nullptr ? "name" : "joint");
        DPL_TRY(const auto found, avatarOf(avatar));
        const std::vector<JointData>& joints = found->data->joints;
        for (const auto key : {&JointData::name, &JointData::humanoidBone})
            for (size_t j = 0; j < joints.size() && *name != 0; ++j)
                if (joints[j].*key == name) {
                    *joint = uint32_t(j);
                    return {};
                }
        std::string names;
        for (const JointData& j : joints) names += (names.empty() ? "" : ", ") + j.name;
        return fail(Code::NotFound, "there is no joint '{}'; the avatar has: {}", name, names);
    });
}

DplResult dplSetPose(DplAvatar avatar, const float* rotations, uint32_t jointCount, const float* rootTranslation) {
    return guarded("dplSetPose", [&] { return setPose(avatar, rotations, jointCount, rootTranslation, std::nullopt); });
}

DplResult dplSetPoseAtTime(DplAvatar avatar, const float* rotations, uint32_t jointCount, const float* rootTranslation, int64_t timeNs) {
    return guarded("dplSetPoseAtTime", [&] { return setPose(avatar, rotations, jointCount, rootTranslation, timeNs); });
}

DplResult dplSettle(DplAvatar avatar) {
    return guarded("dplSettle", [&]() -> Status {
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        std::lock_guard lock(found->context->mutex);
        found->clock.settle(found->pose);
        return {};
    });
}

DplResult dplGetMotionState(DplAvatar avatar, uint8_t* state, size_t capacity, size_t* size) {
    return guarded("dplGetMotionState", [&]() -> Status {
        if (size == nullptr) return fail(Code::InvalidArgument, "size is NULL");
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        std::lock_guard lock(found->context->mutex);
        const MotionModeData& motion = found->data->correctives.motion;
        if (state != nullptr) found->clock.show(motion, found->pose);
        const std::vector<uint8_t> bytes = found->clock.save(motion);
        if (state != nullptr && capacity < bytes.size())
            return fail(Code::InvalidArgument, "capacity is {}; the motion state has {} bytes", capacity, bytes.size());
        if (state != nullptr) std::copy(bytes.begin(), bytes.end(), state);
        *size = bytes.size();
        return {};
    });
}

DplResult dplSetMotionState(DplAvatar avatar, const uint8_t* state, size_t size) {
    return guarded("dplSetMotionState", [&]() -> Status {
        if (state == nullptr) return fail(Code::InvalidArgument, "state is NULL");
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        std::lock_guard lock(found->context->mutex);
        return found->clock.restore(found->data->correctives.motion, {state, size}, found->pose);
    });
}

DplResult dplSetClothStiffness(DplAvatar avatar, float stiffness) {
    return guarded("dplSetClothStiffness", [&]() -> Status {
        if (!(stiffness >= 0 && stiffness <= kMostClothStiffness))
            return fail(Code::InvalidArgument, "stiffness is {}; it must be from 0 to {}, and 1 is as learned", stiffness,
                        kMostClothStiffness);
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        std::lock_guard lock(found->context->mutex);
        found->clothStiffness = stiffness;
        return {};
    });
}

DplResult dplGetPose(DplAvatar avatar, float* rotations, uint32_t jointCount, float* rootTranslation) {
    return guarded("dplGetPose", [&]() -> Status {
        DPL_TRY(const auto found, avatarOf(avatar));
        if (rotations != nullptr && jointCount != found->data->joints.size()) return wrongJointCount(*found, jointCount);
        std::lock_guard lock(found->context->mutex);
        for (uint32_t j = 0; j < jointCount && rotations != nullptr; ++j) {
            const Quatf& q = found->pose.localRotations[j];
            float* out = rotations + size_t(j) * 4;
            out[0] = q.x, out[1] = q.y, out[2] = q.z, out[3] = q.w;
        }
        for (int axis = 0; axis < 3 && rootTranslation != nullptr; ++axis) rootTranslation[axis] = found->pose.rootTranslation[axis];
        return {};
    });
}

DplResult dplGetPoseTrust(DplAvatar avatar, DplPoseTrust* trust, float* distances, uint32_t jointCount) {
    return guarded("dplGetPoseTrust", [&]() -> Status {
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        if (distances != nullptr && jointCount != found->data->joints.size()) return wrongJointCount(*found, jointCount);
        DPL_RETURN_IF_ERROR(checkTrained(*found));
        std::lock_guard lock(found->context->mutex);
        poseTrust(found->data->correctives, found->pose, found->trust);
        const std::vector<float>& away = found->trust.joints;
        DplPoseTrust out{};
        out.offsets = found->trust.offsets;
        out.away = found->trust.away;
        out.offModes = found->trust.offModes;
        out.farthestJoint = uint32_t(std::max_element(away.begin(), away.end()) - away.begin());
        out.farthestDistance = away[out.farthestJoint];
        DPL_RETURN_IF_ERROR(writeStruct(trust, out, "trust"));
        if (distances != nullptr) std::copy(away.begin(), away.end(), distances);
        return {};
    });
}

DplResult dplHoldPose(DplAvatar avatar, float limit) {
    return guarded("dplHoldPose", [&]() -> Status {
        if (!std::isfinite(limit) || !(limit > 0)) return fail(Code::InvalidArgument, "limit is {}; it must be above 0 and finite", limit);
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        DPL_RETURN_IF_ERROR(checkTrained(*found));
        std::lock_guard lock(found->context->mutex);
        holdPose(found->data->correctives, limit, found->pose);
        return {};
    });
}

DplResult dplGetCaptureDetail(DplAvatar avatar, uint32_t joint, DplCaptureDetail* detail) {
    return guarded("dplGetCaptureDetail", [&]() -> Status {
        DPL_TRY(const auto found, avatarOf(avatar));
        const size_t joints = found->data->joints.size();
        if (joint >= joints) return fail(Code::NotFound, "there is no joint {}; the avatar has {}", joint, joints);
        DplCaptureDetail out{};
        const CaptureMapData& map = found->data->captureMap;
        for (size_t s = 0; s < kCaptureSides && !map.empty(); ++s) {
            const CaptureSide& side = map.sides[joint * kCaptureSides + s];
            out.pixelM[s] = side.pixelM, out.detailM[s] = side.detailM, out.views[s] = side.views;
        }
        return writeStruct(detail, out, "detail");
    });
}

DplResult dplGetNearestDistance(DplAvatar avatar, const float* point, const float* eye, float focalPx, float magnification,
                                float* distanceM) {
    return guarded("dplGetNearestDistance", [&]() -> Status {
        if (point == nullptr || eye == nullptr || distanceM == nullptr)
            return fail(Code::InvalidArgument, "{} is NULL", point == nullptr ? "point" : eye == nullptr ? "eye" : "distanceM");
        DPL_TRY(const auto found, avatarOf(avatar));
        const Vec3f at(point[0], point[1], point[2]), from(eye[0], eye[1], eye[2]);
        for (int axis = 0; axis < 3; ++axis)
            if (!std::isfinite(at[axis]) || !std::isfinite(from[axis])) return fail(Code::InvalidArgument, "point or eye is not finite");
        if (!(focalPx > 0 && magnification > 0) || !std::isfinite(focalPx) || !std::isfinite(magnification))
            return fail(Code::InvalidArgument, "focalPx is {} and magnification {}; both must be above 0 and finite", focalPx,
                        magnification);
        std::lock_guard lock(found->context->mutex);
        const std::vector<JointData>& joints = found->data->joints;
        if (!found->data->captureMap.empty()) jointTransforms(joints, found->pose, found->transforms);
        const Placement& placed = found->placement;
        const Vec3f ownPoint(placed.toOwn(Vec3d(at))), ownDirection(placed.directionToOwn(Vec3d(from) - Vec3d(at)));
        // A detail is `scale` times as large in the world, so the distance from which it takes as many pixels is as well.
        *distanceM = float(placed.scale) *
                     nearestDistanceM(found->data->captureMap, joints, found->transforms, ownPoint, ownDirection, focalPx, magnification);
        return {};
    });
}

DplResult dplGetJointPositions(DplAvatar avatar, float* positions, uint32_t jointCount) {
    return guarded("dplGetJointPositions", [&]() -> Status {
        if (positions == nullptr) return fail(Code::InvalidArgument, "positions is NULL");
        DPL_TRY(const auto found, avatarOf(avatar));
        const std::vector<JointData>& joints = found->data->joints;
        if (jointCount != joints.size()) return wrongJointCount(*found, jointCount);
        std::lock_guard lock(found->context->mutex);
        jointTransforms(joints, found->pose, found->transforms);
        for (uint32_t j = 0; j < jointCount; ++j) {
            const Vec3f p(found->placement.toWorld(Vec3d(found->transforms[j] * Vec4f(joints[j].restPosition, 1))));
            for (int axis = 0; axis < 3; ++axis) positions[size_t(j) * 3 + size_t(axis)] = p[axis];
        }
        return {};
    });
}

}  // extern "C"
