// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/hidden_splats.h"

#include <doppel/doppel_posed.h>

#include "apps/shared/pictures.h"
#include "apps/viewer/subject.h"
#include "sdk/core/evenly_spaced.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

Status ofSdk(const doppel::Status& status) {
    return status ? Status() : fromSdk(status.error());
}

}  // namespace

Result<GateQuestion> gateQuestion(const ViewedSubject& subject, const Vec3d& eye) {
    GateQuestion out{.avatar = subject.avatar.handle(), .file = subject.path};
    out.rotations.resize(subject.joints.size() * 4);
    if (dplGetPose(out.avatar, out.rotations.data(), uint32_t(subject.joints.size()), out.root.data()) != DPL_OK ||
        dplGetTransform(out.avatar, out.transform.data()) != DPL_OK)
        return fail(Code::Internal, "{}", dplGetLastError());
    auto motion = subject.avatar.motionState();
    if (!motion) return fromSdk(motion.error());
    out.motion = std::move(*motion);
    out.eye = Vec3f(eye);
    return out;
}

Status GateFinder::load(const GateQuestion& question) {
    if (question.file.empty()) return fail(Code::NotFound, "only avatars from files are asked for hidden splats");
    DPL_TRY(const auto bytes, readFile(question.file));
    if (!context_.handle()) {
        auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE);
        if (!context) return fromSdk(context.error());
        context_ = std::move(*context);
    }
    auto twin = context_.loadAvatar(bytes);
    if (!twin) return fromSdk(twin.error());
    twin_ = std::move(*twin);
    of_ = question.avatar, file_ = question.file;
    return {};
}

Result<HiddenSplats> GateFinder::find(const GateQuestion& question) {
    if (of_ != question.avatar || file_ != question.file) DPL_RETURN_IF_ERROR(load(question));
    DPL_RETURN_IF_ERROR(ofSdk(twin_.setPose(question.rotations, question.root)));
    DPL_RETURN_IF_ERROR(ofSdk(twin_.setMotionState(question.motion)));
    DPL_RETURN_IF_ERROR(ofSdk(twin_.setTransform(question.transform)));
    const auto count = twin_.splatCount();
    if (!count) return fromSdk(count.error());
    places_.resize(size_t(*count) * 3), seen_.resize(*count), all_.resize(*count);
    const auto write = [&](uint32_t property, std::vector<float>& into, const float* eye) -> Status {
        doppel::SplatOptions options;
        options.eye = eye;
        const DplBufferElement element = doppel::bufferElement(property, 0);
        const auto written = twin_.writeSplats({&element, 1}, std::as_writable_bytes(std::span(into)), options);
        return written ? Status() : fromSdk(written.error());
    };
    DPL_RETURN_IF_ERROR(write(DPL_SPLAT_POSITION, places_, nullptr));
    DPL_RETURN_IF_ERROR(write(DPL_SPLAT_OPACITY, all_, nullptr));
    DPL_RETURN_IF_ERROR(write(DPL_SPLAT_OPACITY, seen_, &question.eye.x));
    HiddenSplats out;
    std::vector<size_t> hidden;
    for (size_t i = 0; i < all_.size(); ++i) {
        if (!(all_[i] > 0)) continue;
        ++out.splats;
        if (!(seen_[i] > 0)) hidden.push_back(i);
    }
    out.hidden = hidden.size();
    for (const size_t i : evenlySpaced(hidden, HiddenSplats::kMostPlaces))
        out.places.push_back({places_[3 * i], places_[3 * i + 1], places_[3 * i + 2]});
    return out;
}

}  // namespace dpl
