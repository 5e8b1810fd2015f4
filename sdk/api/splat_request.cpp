// SPDX-License-Identifier: Apache-2.0
#include "sdk/api/splat_request.h"

#include <cmath>

#include "sdk/draw/check_draw.h"
#include "sdk/splat/posed_splats.h"

namespace dpl::api {

static_assert(DPL_SPLAT_POSITION == int(SplatNumbers::Position) && DPL_SPLAT_ROTATION == int(SplatNumbers::Rotation) &&
              DPL_SPLAT_SCALE == int(SplatNumbers::Scale) && DPL_SPLAT_COVARIANCE == int(SplatNumbers::Covariance) &&
              DPL_SPLAT_OPACITY == int(SplatNumbers::Opacity) && DPL_SPLAT_COLOUR == int(SplatNumbers::Colour) &&
              DPL_SPLAT_SH == int(SplatNumbers::Sh) && DPL_SPLAT_ROTATION_WXYZ == int(SplatNumbers::RotationWxyz));

Result<SplatRequest> requestOf(const DplSplatOptions* options) {
    SplatRequest request;
    if (options == nullptr) return request;
    DPL_TRY(const DplSplatOptions given, readStruct<DplSplatOptions>(options, "options"));
    if (given.shDegree > kMaxShDegree)
        return fail(Code::InvalidArgument, "SH of degree {}; 0 to {} are possible", given.shDegree, kMaxShDegree);
    request.budget = given.splatBudget, request.shDegree = given.shDegree;
    if (given.eye == nullptr) return request;
    for (int axis = 0; axis < 3; ++axis)
        if (!(std::abs(given.eye[axis]) <= kMaxDistanceM))
            return fail(Code::InvalidArgument, "the eye is at ({}, {}, {}); up to {} m from the origin is possible", given.eye[0],
                        given.eye[1], given.eye[2], kMaxDistanceM);
    request.eye = Vec3f(given.eye[0], given.eye[1], given.eye[2]);
    return request;
}

std::array<BufferProperty, 8> splatProperties(uint32_t shDegree) {
    std::array<BufferProperty, 8> out = {{{"position", 0},
                                          {"rotation", 0},
                                          {"scale", 0},
                                          {"covariance", 0},
                                          {"opacity", 0},
                                          {"colour", 0},
                                          {"SH", 0},
                                          {"rotation, w first", 0}}};
    for (size_t p = 0; p < out.size(); ++p) out[p].numbers = numbersOf(SplatNumbers(p), shDegree);
    return out;
}

}  // namespace dpl::api
