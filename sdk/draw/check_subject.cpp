// SPDX-License-Identifier: Apache-2.0
#include "sdk/draw/check_subject.h"

#include <algorithm>

#include "sdk/avatar/rig.h"
#include "sdk/format/check_mesh.h"
#include "sdk/format/correctives.h"
#include "sdk/format/expressions.h"
#include "sdk/format/light.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr size_t kMaxJoints = 0xFFFF;  // skin weights name joints by 16 bits

Status asArgument(const AvatarData& avatar, const Status& status) {
    if (status) return {};
    return fail(Code::InvalidArgument, "avatar '{}': {}", avatar.name, status.error().message);
}

}  // namespace

Status checkAvatarPosable(const AvatarData& avatar) {
    if (avatar.joints.empty() || avatar.joints.size() > kMaxJoints)
        return fail(Code::InvalidArgument, "avatar '{}' has {} joints; 1 to {} are possible", avatar.name, avatar.joints.size(),
                    kMaxJoints);
    DPL_RETURN_IF_ERROR(asArgument(avatar, checkRig(avatar.joints)));
    DPL_RETURN_IF_ERROR(asArgument(avatar, checkMesh(avatar.mesh, avatar.joints.size())));
    DPL_RETURN_IF_ERROR(asArgument(avatar, checkLight(avatar.light)));
    DPL_RETURN_IF_ERROR(asArgument(avatar, checkCorrectives(avatar.correctives, avatar.joints.size(), avatar.mesh.restPositions.size())));
    return asArgument(avatar, checkExpressions(avatar.expressions, avatar.correctives));
}

Status checkBoundSplats(const AvatarData& avatar) {
    const SplatData& splats = avatar.splats;
    const size_t triangles = avatar.mesh.triangles.size(), count = splats.count();
    if (splats.shDegree > kMaxShDegree)
        return fail(Code::Unsupported, "avatar '{}' has splats of SH degree {}; at most {} is drawn", avatar.name, splats.shDegree,
                    kMaxShDegree);
    if (splats.phi.size() != count || splats.scaleM.size() != count || splats.opacity.size() != count || splats.flags.size() != count ||
        splats.sh.size() != count * shCoefficientCount(splats.shDegree) * 3)
        return fail(Code::InvalidArgument, "the arrays of the {} splats of avatar '{}' differ in length", count, avatar.name);
    const std::vector<uint32_t>& start = splats.triangleStart;
    const bool covers =
        start.size() == triangles + 1 && start.front() == 0 && start.back() == count && std::is_sorted(start.begin(), start.end());
    if (!covers && !(count == 0 && start.empty()))
        return fail(Code::InvalidArgument, "triangleStart of avatar '{}' does not cover its {} triangles and {} splats in rising order",
                    avatar.name, triangles, count);
    return {};
}

Status checkGeneralSplats(const StaticSplatData& splats) {
    const size_t count = splats.count();
    if (splats.shDegree > kMaxShDegree)
        return fail(Code::Unsupported, "general splats of SH degree {}; at most {} is drawn", splats.shDegree, kMaxShDegree);
    if (splats.rotation.size() != count || splats.scaleM.size() != count || splats.opacity.size() != count ||
        splats.sh.size() != count * shCoefficientCount(splats.shDegree) * 3)
        return fail(Code::InvalidArgument, "the arrays of {} general splats differ in length", count);
    return {};
}

}  // namespace dpl
