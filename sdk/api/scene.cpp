// SPDX-License-Identifier: Apache-2.0
#include "sdk/api/scene.h"

#include "sdk/draw/check_draw.h"

namespace dpl::api {
namespace {

static_assert(DPL_MAX_TOGETHER == kMaxDrawnTogether && DPL_MAX_VIEWS == kMaxViews && DPL_MAX_IMAGE_SIDE_PX == kMaxImageSidePx);

Cameraf cameraOf(const DplCamera& c) {
    Cameraf camera;
    camera.widthPx = c.widthPx, camera.heightPx = c.heightPx;
    camera.fx = c.fx, camera.fy = c.fy, camera.cx = c.cx, camera.cy = c.cy;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) camera.viewFromWorldRotation[column][row] = c.viewFromWorld[row * 4 + column];
        camera.viewFromWorldTranslation[row] = c.viewFromWorld[row * 4 + 3];
    }
    return camera;
}

}  // namespace

Result<std::span<const DplAvatar>> together(const DplAvatar* avatars, uint32_t count) {
    if (avatars == nullptr) return fail(Code::InvalidArgument, "avatars is NULL");
    if (count == 0 || count > DPL_MAX_TOGETHER)
        return fail(Code::InvalidArgument, "{} avatars; 1 to {} are drawn together", count, DPL_MAX_TOGETHER);
    return std::span<const DplAvatar>(avatars, count);
}

Result<Scene> sceneOf(DplContext context, std::span<const DplAvatar> handles, uint32_t viewCount) {
    if (viewCount == 0 || viewCount > DPL_MAX_VIEWS)
        return fail(Code::InvalidArgument, "{} views; 1 to {} are drawn at once", viewCount, DPL_MAX_VIEWS);
    Scene s;
    DPL_TRY(s.context, contextOf(context));
    for (DplAvatar handle : handles) {
        DPL_TRY(s.avatars[s.count], avatarOf(handle));
        if (s.avatars[s.count]->context != s.context) return fail(Code::InvalidArgument, "the avatar was loaded with another context");
        ++s.count;
    }
    s.lock = std::unique_lock(s.context->mutex);
    DPL_RETURN_IF_ERROR(checkUsable(*s.context));
    return s;
}

Status takeViews(Scene& s, const DplCamera* views, uint32_t viewCount) {
    std::vector<Cameraf>& cameras = s.context->cameras;
    cameras.clear();
    for (uint32_t v = 0; v < viewCount; ++v) {
        DPL_TRY(const DplCamera given, element(views, v, "views", offsetof(DplCamera, viewFromWorld) + sizeof DplCamera::viewFromWorld));
        cameras.push_back(cameraOf(given));
        if (given.sceneDepthM && given.sceneDepthCount == 0)
            return fail(Code::InvalidArgument, "view {} has sceneDepthM and a sceneDepthCount of 0", v);
        s.sceneDepthM[v] = given.sceneDepthM ? std::span(given.sceneDepthM, given.sceneDepthCount) : std::span<const float>();
    }
    return checkViews(cameras);
}

}  // namespace dpl::api
