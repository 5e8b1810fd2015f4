// SPDX-License-Identifier: Apache-2.0
#include "sdk/draw/renderer.h"

#include "sdk/draw/check_subject.h"
#include "sdk/format/splat_codec.h"

namespace dpl {

Result<RenderAvatarId> Renderer::addAvatar(std::shared_ptr<const AvatarData> avatar) {
    if (!avatar) return fail(Code::InvalidArgument, "no avatar");
    DPL_RETURN_IF_ERROR(checkAvatarPosable(*avatar));
    DPL_RETURN_IF_ERROR(checkBoundSplats(*avatar));
    DPL_TRY(CodedSplats coded, codeSplats(avatar->mesh, avatar->splats));
    return addCodedAvatar(std::move(avatar), std::move(coded));
}

Result<RenderAvatarId> Renderer::addCodedAvatar(std::shared_ptr<const AvatarData> avatar, CodedSplats splats) {
    DPL_TRY(std::unique_ptr<PreparedSubject> prepared, prepareAvatar(std::move(avatar), std::move(splats)));
    return add(std::move(prepared));
}

Result<RenderAvatarId> Renderer::addSplats(const StaticSplatData& splats) {
    DPL_TRY(std::unique_ptr<PreparedSubject> prepared, prepareSplats(splats));
    return add(std::move(prepared));
}

Result<RenderAvatarId> Renderer::add(std::unique_ptr<PreparedSubject> subject) {
    DPL_TRY(const RenderAvatarId id, begin(std::move(subject)));
    if (const Status done = finishUpload(id); !done) {
        removeAvatar(id);
        return done.error();
    }
    return id;
}

Status Renderer::draw(RenderAvatarId avatar, const Pose& pose, std::span<const Cameraf> views, const FrameWants& wants) {
    const Drawn one{avatar, &pose};
    return drawTogether({&one, 1}, views, wants);
}

Status Renderer::render(RenderAvatarId avatar, const Pose& pose, std::span<const Cameraf> views, const FrameWants& wants,
                        std::span<RenderedView> out) {
    if (out.size() != views.size()) return fail(Code::InvalidArgument, "{} views into {} images", views.size(), out.size());
    DPL_RETURN_IF_ERROR(draw(avatar, pose, views, wants));
    DPL_TRY(const std::span<const PixelView> pixels, read(avatar));
    for (size_t v = 0; v < out.size(); ++v)
        out[v] = {pixels[v].widthPx,
                  pixels[v].heightPx,
                  {pixels[v].rgba.begin(), pixels[v].rgba.end()},
                  {pixels[v].depthM.begin(), pixels[v].depthM.end()},
                  {pixels[v].meshDepthM.begin(), pixels[v].meshDepthM.end()}};
    return {};
}

}  // namespace dpl
