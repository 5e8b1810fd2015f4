// SPDX-License-Identifier: Apache-2.0
#include "sdk/draw/check_draw.h"

#include <algorithm>
#include <cmath>

namespace dpl {
namespace {

constexpr float kRotationTolerance = 1e-3f;  // of each entry of RᵀR

Status checkView(const Cameraf& c, size_t view) {
    if (c.widthPx == 0 || c.heightPx == 0 || c.widthPx > kMaxImageSidePx || c.heightPx > kMaxImageSidePx)
        return fail(Code::InvalidArgument, "view {} is {} x {} pixels; sides of 1 to {} are drawn", view, c.widthPx, c.heightPx,
                    kMaxImageSidePx);
    if (!(c.fx > 0 && c.fy > 0 && c.fx <= kMaxIntrinsicPx && c.fy <= kMaxIntrinsicPx))
        return fail(Code::InvalidArgument, "view {} has focal lengths {} and {} px; they must be above 0 and at most {}", view, c.fx, c.fy,
                    kMaxIntrinsicPx);
    if (!(std::abs(c.cx) <= kMaxIntrinsicPx && std::abs(c.cy) <= kMaxIntrinsicPx))
        return fail(Code::InvalidArgument, "view {} has the principal point ({}, {}) px; its coordinates must be finite and at most {} px",
                    view, c.cx, c.cy, kMaxIntrinsicPx);
    for (int axis = 0; axis < 3; ++axis)
        if (!(std::abs(c.viewFromWorldTranslation[axis]) <= kMaxDistanceM))
            return fail(Code::InvalidArgument, "view {} has a translation that is not finite or beyond {} m", view, kMaxDistanceM);
    const Mat3f& r = c.viewFromWorldRotation;
    const Mat3f unit = glm::transpose(r) * r;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (!(std::abs(unit[i][j] - (i == j ? 1.0f : 0.0f)) <= kRotationTolerance))
                return fail(Code::InvalidArgument, "the 3x3 part of viewFromWorld of view {} is not a rotation (rows are R0 R1 R2 t)",
                            view);
    if (!(glm::determinant(r) > 0)) return fail(Code::InvalidArgument, "viewFromWorld of view {} mirrors; a rotation is needed", view);
    return {};
}

Status checkSceneDepth(const FrameWants& wants, std::span<const Cameraf> views) {
    for (size_t v = 0; v < views.size(); ++v)
        if (const size_t given = wants.sceneDepthM[v].size(), pixels = size_t(views[v].widthPx) * views[v].heightPx;
            given != 0 && given < pixels)
            return fail(Code::InvalidArgument, "view {} has {} depths of the scene; {} are needed", v, given, pixels);
    return {};
}

}  // namespace

Status checkViews(std::span<const Cameraf> views) {
    if (views.empty() || views.size() > kMaxViews)
        return fail(Code::InvalidArgument, "{} views; 1 to {} are drawn at once", views.size(), kMaxViews);
    for (size_t v = 0; v < views.size(); ++v) {
        DPL_RETURN_IF_ERROR(checkView(views[v], v));
        if (views[v].widthPx != views[0].widthPx || views[v].heightPx != views[0].heightPx)
            return fail(Code::InvalidArgument, "the views of one call have the same size; view {} differs from view 0", v);
    }
    return {};
}

Status checkDraw(std::span<const Drawn> what, std::span<const Cameraf> views, const FrameWants& wants, FindJoints findJoints) {
    DPL_RETURN_IF_ERROR(checkViews(views));
    DPL_RETURN_IF_ERROR(checkSceneDepth(wants, views));
    if (what.empty() || what.size() > kMaxDrawnTogether)
        return fail(Code::InvalidArgument, "{} avatars; 1 to {} are drawn together", what.size(), kMaxDrawnTogether);
    bool mesh = false;
    for (size_t i = 0; i < what.size(); ++i) {
        for (size_t k = 0; k < i; ++k)
            if (what[k].avatar == what[i].avatar)
                return fail(Code::InvalidArgument, "avatar {} is named twice; a draw takes each avatar once", what[i].avatar);
        const std::optional<std::span<const JointData>> joints = findJoints(what[i].avatar);
        if (!joints) return fail(Code::InvalidArgument, "avatar {} is not in this renderer", what[i].avatar);
        if (joints->empty()) continue;
        mesh = true;
        if (what[i].pose == nullptr) return fail(Code::InvalidArgument, "avatar {} is drawn without a pose", what[i].avatar);
        DPL_RETURN_IF_ERROR(checkPose(*joints, *what[i].pose));
    }
    if (wants.meshDepth && !mesh) return fail(Code::InvalidArgument, "mesh depth was asked for, but general splats have no mesh");
    return {};
}

}  // namespace dpl
