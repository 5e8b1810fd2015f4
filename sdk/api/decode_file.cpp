// SPDX-License-Identifier: Apache-2.0
#include "sdk/api/decode_file.h"

#include <algorithm>

#include "sdk/avatar/cloth_bounds.h"
#include "sdk/avatar/humanoid.h"
#include "sdk/core/task.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/avatar_head.h"
#include "sdk/format/splat_file.h"
#include "sdk/motion/clip.h"

namespace dpl::api {
namespace {

/** Makes the checks that posing and queries need and that the file reader does not make. */
Status checkLoaded(const AvatarData& data) {
    DPL_RETURN_IF_ERROR(checkRig(data.joints));
    for (const ClipData& clip : data.clips) DPL_RETURN_IF_ERROR(checkClip(clip, data.joints));
    return {};
}

Result<Decoded> decodeAvatar(std::span<const uint8_t> bytes) {
    if (bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) != 0) DPL_RETURN_IF_ERROR(checkAvatarHead(bytes, bytes.size()));
    DPL_TRY(CodedAvatar coded, readCodedAvatar(bytes));
    AvatarData& decoded = coded.avatar;
    decoded.mesh.colours = {};  // only other glTF viewers use them
    DPL_RETURN_IF_ERROR(checkLoaded(decoded));
    if (std::all_of(decoded.joints.begin(), decoded.joints.end(), [](const JointData& j) { return j.humanoidBone.empty(); }))
        assignHumanoidBones(decoded.joints);
    boundGarments(decoded.joints, decoded.mesh);
    auto made = std::make_shared<Avatar>();
    made->data = std::make_shared<const AvatarData>(std::move(decoded));
    made->carriesSplats.assign(made->data->mesh.triangles.size(), 0);
    for (const uint32_t triangle : coded.splats.parents) made->carriesSplats[triangle] = 1;
    made->fileSplatCount = coded.splats.count(), made->fileShDegree = coded.splats.shDegree;
    made->pose = Pose::rest(made->data->joints.size());
    if (!made->data->expressions.shapes.empty()) made->faceEyes = FaceEyes::of(*made->data);
    for (const ClipData& clip : made->data->clips) made->addClip(clip, made->memoryOf(clip));
    const std::vector<Vec3f>& vertices = made->data->mesh.restPositions;
    if (!vertices.empty()) made->restMin = made->restMax = vertices.front();
    for (const Vec3f& v : vertices) made->restMin = glm::min(made->restMin, v), made->restMax = glm::max(made->restMax, v);
    return Decoded{std::move(made), std::move(coded.splats), {}};
}

}  // namespace

Result<Decoded> decodeFile(std::span<const uint8_t> bytes, const std::string& file) {
    return isSplatFile(bytes) ? decodeGeneralSplats(bytes, file) : decodeAvatar(bytes);
}

}  // namespace dpl::api
