// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/baseline/plain_file.h"

#include "sdk/draw/renderer.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/splat_file.h"
#include "tools/bench/baseline/plain_frame.h"

namespace dpl {

struct PlainFile::State {
    std::shared_ptr<const AvatarData> avatar;  // null for general splats
    Pose pose;
    plain::Frame frame;
    State(std::unique_ptr<Backend> backend, PlainFill fill) : frame(std::move(backend), fill) {}
};

PlainFile::PlainFile(std::unique_ptr<State> state, std::string name) : state_(std::move(state)), name_(std::move(name)) {}
PlainFile::PlainFile(PlainFile&&) noexcept = default;
PlainFile& PlainFile::operator=(PlainFile&&) noexcept = default;
PlainFile::~PlainFile() = default;

Result<PlainFile> PlainFile::open(std::span<const uint8_t> bytes, PlainFill fill) {
    auto backend = plain::createBackend({.allowSoftware = true});
    if (!backend) return fail(Code::Unsupported, "no Vulkan on this machine: {}", backend.error().message);
    std::string name = "vulkan: " + (*backend)->info().name + (fill == PlainFill::Quads ? " (plain float)" : " (plain float, tiles)");
    auto state = std::make_unique<State>(std::move(*backend), fill);
    if (splatFormatOf(bytes) != SplatFormat::None) {
        DPL_TRY(const SplatFile general, readSplats(bytes));
        DPL_RETURN_IF_ERROR(state->frame.load(general.splats));
    } else {
        DPL_TRY(AvatarData avatar, readAvatar(bytes));
        state->avatar = std::make_shared<const AvatarData>(std::move(avatar));
        DPL_RETURN_IF_ERROR(state->frame.load(state->avatar));
    }
    return PlainFile(std::move(state), std::move(name));
}

Status PlainFile::draw(std::span<const float> rotations, const Vec3f& rootTranslation, std::span<const Cameraf> views) {
    Pose& pose = state_->pose;
    pose.localRotations.clear();
    for (size_t j = 0; j + 4 <= rotations.size(); j += 4)
        pose.localRotations.emplace_back(rotations[j + 3], rotations[j], rotations[j + 1], rotations[j + 2]);
    pose.rootTranslation = rootTranslation;
    if (state_->avatar) {
        DPL_RETURN_IF_ERROR(checkPose(state_->avatar->joints, pose));
    }
    return state_->frame.draw(pose, views);
}

Status PlainFile::read(std::span<std::vector<uint8_t>> pictures) {
    DPL_TRY(const auto views, state_->frame.read());
    if (views.size() != pictures.size()) return fail(Code::InvalidArgument, "{} views into {} pictures", views.size(), pictures.size());
    for (size_t v = 0; v < views.size(); ++v) pictures[v].assign(views[v].begin(), views[v].end());
    return {};
}

PlainStats PlainFile::stats() const {
    PlainStats stats;
    const plain::Frame& frame = state_->frame;
    stats.splatsDrawn = frame.splatsDrawn();
    stats.residentBytes = frame.residentBytes();
    stats.splatBytes = frame.splatBytes();
    stats.avatarBytes = frame.avatarBytes() + (state_->avatar ? posingBytes(*state_->avatar) : 0);
    for (const PassTime& pass : frame.passTimes()) stats.passes.push_back({pass.label, pass.milliseconds});
    return stats;
}

}  // namespace dpl
