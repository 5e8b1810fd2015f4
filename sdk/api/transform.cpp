// SPDX-License-Identifier: Apache-2.0
// Where avatars and general splats stand: checks what programs give, and keeps it.
#include <algorithm>
#include <cmath>

#include "sdk/api/api_state.h"
#include "sdk/draw/check_draw.h"

using namespace dpl;
using namespace dpl::api;

namespace {

constexpr double kLeastScale = 1e-3, kMostScale = 1e3;
constexpr double kTolerance = 1e-3;  // of a length and of a cosine, relative: as for the rotations of cameras

/** The placement of a row-major 3×4 matrix. The little by which its axes differ from a rotation is dropped. */
Result<Placement> placementOf(const std::array<float, 12>& rows) {
    if (!std::all_of(rows.begin(), rows.end(), [](float x) { return std::isfinite(x); }))
        return fail(Code::InvalidArgument, "worldFromAvatar has a number that is not finite");
    Mat3d axes;
    Placement p;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) axes[column][row] = double(rows[size_t(4 * row + column)]);
        p.translation[row] = double(rows[size_t(4 * row + 3)]);
    }
    const Vec3d lengths(glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2]));
    p.scale = (lengths.x + lengths.y + lengths.z) / 3;
    for (int axis = 0; axis < 3; ++axis)
        if (!(std::abs(lengths[axis] - p.scale) <= kTolerance * p.scale))
            return fail(Code::InvalidArgument, "worldFromAvatar scales x by {}, y by {} and z by {}; one scale for all axes is possible",
                        lengths.x, lengths.y, lengths.z);
    if (!(p.scale >= kLeastScale && p.scale <= kMostScale))
        return fail(Code::InvalidArgument, "worldFromAvatar scales by {}; {} to {} is possible", p.scale, kLeastScale, kMostScale);
    for (int axis = 0; axis < 3; ++axis)
        if (!(std::abs(glm::dot(axes[axis], axes[(axis + 1) % 3])) <= kTolerance * p.scale * p.scale))
            return fail(Code::InvalidArgument, "worldFromAvatar shears: its axes are not at right angles (rows are R0 R1 R2 t)");
    if (!(glm::determinant(axes) > 0))
        return fail(Code::InvalidArgument, "worldFromAvatar mirrors; a rotation, one positive scale and a translation are possible");
    for (int axis = 0; axis < 3; ++axis)
        if (!(std::abs(p.translation[axis]) <= double(kMaxDistanceM)))
            return fail(Code::InvalidArgument, "worldFromAvatar has a translation beyond {} m", kMaxDistanceM);
    p.rotation = glm::mat3_cast(glm::normalize(glm::quat_cast(axes / p.scale)));
    return p;
}

}  // namespace

extern "C" {

DplResult dplSetTransform(DplAvatar avatar, const float* worldFromAvatar) {
    return guarded("dplSetTransform", [&]() -> Status {
        DPL_TRY(const auto found, avatarOf(avatar));
        std::array<float, 12> rows = kStandsAtOrigin;
        if (worldFromAvatar != nullptr) std::copy_n(worldFromAvatar, rows.size(), rows.begin());
        DPL_TRY(const Placement placement, placementOf(rows));
        std::lock_guard lock(found->context->mutex);
        found->worldFromAvatar = rows, found->placement = placement;
        return {};
    });
}

DplResult dplGetTransform(DplAvatar avatar, float* worldFromAvatar) {
    return guarded("dplGetTransform", [&]() -> Status {
        if (worldFromAvatar == nullptr) return fail(Code::InvalidArgument, "worldFromAvatar is NULL");
        DPL_TRY(const auto found, avatarOf(avatar));
        std::lock_guard lock(found->context->mutex);
        std::copy(found->worldFromAvatar.begin(), found->worldFromAvatar.end(), worldFromAvatar);
        return {};
    });
}

}  // extern "C"
