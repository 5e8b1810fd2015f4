// SPDX-License-Identifier: Apache-2.0
// Avatars: loading, queries and poses.
#include <algorithm>

#include "sdk/api/api_state.h"
#include "sdk/avatar/clip.h"
#include "sdk/avatar/humanoid.h"
#include "sdk/core/log.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/splat_file.h"

namespace dpl::api {

Avatar::~Avatar() {
    std::lock_guard lock(context->mutex);
    if (context->renderer && renderId != 0) context->renderer->removeAvatar(renderId);
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

/** Makes the checks that posing and queries need and that the file reader does not make. */
Status checkLoaded(const AvatarData& data) {
    DPL_CHECK_OK(checkRig(data.joints));
    for (const ClipData& clip : data.clips) DPL_CHECK_OK(checkClip(clip, data.joints));
    return {};
}

/** A decoded file: the object behind the handle, and the subject prepared for the renderer. */
struct Loaded {
    std::shared_ptr<Avatar> avatar;
    std::unique_ptr<PreparedSubject> subject;
};

Result<Loaded> loadAvatarFile(const std::shared_ptr<Context>& owner, const Renderer& renderer, std::span<const uint8_t> bytes) {
    if (bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) != 0)
        return fail(Code::Unsupported,
                    "neither an avatar (.glb) nor general splats (PLY, compressed PLY, SPZ, .glb with KHR_gaussian_splatting)");
    DPL_TRY(CodedAvatar coded, readCodedAvatar(bytes));
    AvatarData& decoded = coded.avatar;
    decoded.mesh.colours = {};  // only other glTF viewers use them
    DPL_CHECK_OK(checkLoaded(decoded));
    if (std::all_of(decoded.joints.begin(), decoded.joints.end(), [](const JointData& j) { return j.humanoidBone.empty(); }))
        assignHumanoidBones(decoded.joints);
    auto made = std::make_shared<Avatar>();
    made->context = owner;
    made->data = std::make_shared<const AvatarData>(std::move(decoded));
    made->splatCount = coded.splats.count(), made->shDegree = coded.splats.shDegree;
    made->pose = Pose::rest(made->data->joints.size());
    for (const ClipData& clip : made->data->clips) made->clips.push_back(&clip);
    const std::vector<Vec3f>& vertices = made->data->mesh.restPositions;
    if (!vertices.empty()) made->restMin = made->restMax = vertices.front();
    for (const Vec3f& v : vertices) made->restMin = glm::min(made->restMin, v), made->restMax = glm::max(made->restMax, v);
    DPL_TRY(auto subject, renderer.prepareAvatar(made->data, std::move(coded.splats)));
    return Loaded{std::move(made), std::move(subject)};
}

/** Makes an avatar without joints. */
Result<Loaded> loadGeneralSplats(const std::shared_ptr<Context>& owner, const Renderer& renderer, std::span<const uint8_t> bytes) {
    DPL_TRY(const SplatFile file, readSplats(bytes));
    auto made = std::make_shared<Avatar>();
    made->context = owner;
    AvatarData named;
    named.name = nameOf(file.format);
    made->data = std::make_shared<const AvatarData>(std::move(named));
    made->splatCount = file.splats.count(), made->shDegree = file.splats.shDegree;
    const SplatBox box = boxOf(file.splats);
    made->restMin = box.low, made->restMax = box.high;
    DPL_TRY(auto subject, renderer.prepareSplats(file.splats));
    return Loaded{std::move(made), std::move(subject)};
}

/** Decodes and prepares. Takes long: the context's mutex must not be held, so that other threads can draw meanwhile. */
Result<Loaded> prepareFile(const std::shared_ptr<Context>& owner, const Renderer& renderer, std::span<const uint8_t> bytes) {
    const bool general = splatFormatOf(bytes) != SplatFormat::None;
    DPL_TRY(Loaded loaded, general ? loadGeneralSplats(owner, renderer, bytes) : loadAvatarFile(owner, renderer, bytes));
    log(LogLevel::Debug, "prepared '{}': {} splats", loaded.avatar->data->name, loaded.avatar->splatCount);
    return loaded;
}

Status wrongJointCount(const Avatar& avatar, uint32_t jointCount) {
    return fail(Code::InvalidArgument, "jointCount is {}, the avatar has {} joints", jointCount, avatar.data->joints.size());
}

}  // namespace
}  // namespace dpl::api

using namespace dpl;
using namespace dpl::api;

extern "C" {

DplResult dplLoadAvatar(DplContext context, const uint8_t* data, size_t size, DplAvatar* avatar) {
    return guarded("dplLoadAvatar", [&]() -> Status {
        if (data == nullptr || avatar == nullptr) return fail(Code::InvalidArgument, "{} is NULL", data == nullptr ? "data" : "avatar");
        if (size == 0) return fail(Code::InvalidArgument, "the avatar has 0 bytes");
        DPL_TRY(auto owner, contextOf(context));
        const std::shared_lock keepsRenderer(owner->loads);
        std::shared_ptr<const Renderer> renderer;
        {
            std::lock_guard lock(owner->mutex);
            DPL_CHECK_OK(checkUsable(*owner));
            renderer = owner->renderer;
        }
        DPL_TRY(Loaded loaded, prepareFile(owner, *renderer, {data, size}));
        {
            std::lock_guard lock(owner->mutex);
            if (!owner->renderer) return fail(Code::InvalidArgument, "the context was destroyed while the avatar was read");
            DPL_TRY(loaded.avatar->renderId, owner->renderer->add(std::move(loaded.subject)));
        }
        *avatar = reinterpret_cast<DplAvatar>(avatars().add(std::move(loaded.avatar)));
        return {};
    });
}

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
        return writeStruct(info, out, "info");
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
    return guarded("dplSetPose", [&]() -> Status {
        if (rotations == nullptr) return fail(Code::InvalidArgument, "rotations is NULL");
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_CHECK_OK(checkPosable(*found));
        if (jointCount != found->data->joints.size()) return wrongJointCount(*found, jointCount);
        std::lock_guard lock(found->context->mutex);
        Pose& pose = found->givenPose;  // reused, because apps set a pose every frame; found->pose stays unless all checks pass
        pose.localRotations.resize(jointCount);
        for (uint32_t j = 0; j < jointCount; ++j) {
            const float* q = rotations + size_t(j) * 4;
            pose.localRotations[j] = Quatf(q[3], q[0], q[1], q[2]);
        }
        pose.rootTranslation = rootTranslation != nullptr ? Vec3f(rootTranslation[0], rootTranslation[1], rootTranslation[2]) : Vec3f(0);
        DPL_CHECK_OK(checkPose(found->data->joints, pose));
        for (Quatf& q : pose.localRotations) q = glm::normalize(q);
        std::swap(found->pose, pose);
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

DplResult dplGetJointPositions(DplAvatar avatar, float* positions, uint32_t jointCount) {
    return guarded("dplGetJointPositions", [&]() -> Status {
        if (positions == nullptr) return fail(Code::InvalidArgument, "positions is NULL");
        DPL_TRY(const auto found, avatarOf(avatar));
        const std::vector<JointData>& joints = found->data->joints;
        if (jointCount != joints.size()) return wrongJointCount(*found, jointCount);
        std::lock_guard lock(found->context->mutex);
        jointTransforms(joints, found->pose, found->transforms);
        for (uint32_t j = 0; j < jointCount; ++j) {
            const Vec3f p = found->transforms[j] * Vec4f(joints[j].restPosition, 1);
            for (int axis = 0; axis < 3; ++axis) positions[size_t(j) * 3 + size_t(axis)] = p[axis];
        }
        return {};
    });
}

}  // extern "C"
