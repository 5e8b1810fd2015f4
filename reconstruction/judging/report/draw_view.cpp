// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/draw_view.h"

#include <doppel/doppel.hpp>

#include "reconstruction/base/sdk_camera.h"
#include "sdk/format/avatar_file.h"
#include "sdk/motion/motion_clock.h"

namespace dpl {
namespace {

Error sdkError(const doppel::Error& error) {
    return {error.code == DPL_ERROR_CORRUPT_DATA       ? Code::CorruptData
            : error.code == DPL_ERROR_INVALID_ARGUMENT ? Code::InvalidArgument
                                                       : Code::Device,
            error.message};
}

}  // namespace

struct AvatarView::State {
    doppel::Context context;
    doppel::Avatar avatar;
    MotionModeData motion;  // of the avatar; empty: it has none
};

std::vector<uint8_t> motionStateBytes(const MotionModeData& motion, Pose pose) {
    MotionClock clock;
    clock.show(motion, pose);
    return clock.save(motion);
}

AvatarView::AvatarView(std::unique_ptr<State> state) : state_(std::move(state)) {}
AvatarView::AvatarView(AvatarView&&) noexcept = default;
AvatarView& AvatarView::operator=(AvatarView&&) noexcept = default;
AvatarView::~AvatarView() = default;

Result<AvatarView> AvatarView::open(std::span<const uint8_t> bytes, uint32_t threadCount) {
    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE, threadCount);
    if (!context) return sdkError(context.error());
    auto avatar = context->loadAvatar(bytes);
    if (!avatar) return sdkError(avatar.error());
    auto state = std::make_unique<State>(State{std::move(*context), std::move(*avatar), {}});
    DPL_TRY(const AvatarInfo info, inspectAvatar(bytes));
    if (info.motionModes > 0) {
        DPL_TRY(AvatarData data, readAvatar(bytes));
        state->motion = std::move(data.correctives.motion);
    }
    return AvatarView(std::move(state));
}

Result<std::vector<uint8_t>> AvatarView::draw(const Pose& pose, const Camerad& camera) {
    static_assert(sizeof(Quatf) == 4 * sizeof(float), "GLM keeps quaternions as xyzw");
    if (auto set = state_->avatar.setPose({&pose.localRotations[0].x, pose.localRotations.size() * 4}, {&pose.rootTranslation.x, 3}); !set)
        return sdkError(set.error());
    if (!state_->motion.empty())
        if (auto set = state_->avatar.setMotionState(motionStateBytes(state_->motion, pose)); !set) return sdkError(set.error());
    const DplCamera view = sdkCamera(camera.cast<float>());
    std::vector<uint8_t> rgba(size_t(camera.widthPx) * camera.heightPx * 4);
    DplImage image{};
    image.structSize = sizeof image;
    image.flags = DPL_IMAGE_STRAIGHT_ALPHA;
    image.rgba = rgba.data();
    image.rgbaBytes = rgba.size();
    if (auto drawn = state_->avatar.render({&view, 1}, {&image, 1}); !drawn) return sdkError(drawn.error());
    return rgba;
}

}  // namespace dpl
