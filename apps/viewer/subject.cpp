// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/subject.h"

#include <cmath>
#include <utility>

#include "apps/shared/change_pose.h"
#include "apps/shared/pictures.h"

namespace dpl {

Quatf rotationOfAngles(const Vec3f& degrees) {
    const Vec3f a = glm::radians(degrees);
    return glm::angleAxis(a.z, Vec3f(0, 0, 1)) * glm::angleAxis(a.y, Vec3f(0, 1, 0)) * glm::angleAxis(a.x, Vec3f(1, 0, 0));
}

Result<ViewedSubject> ViewedSubject::of(doppel::Avatar avatar, std::string file) {
    ViewedSubject made(std::move(avatar));
    auto info = made.avatar.info();
    if (!info) return fromSdk(info.error());
    made.info = *info;
    auto axes = made.avatar.fileAxes();
    if (!axes) return fromSdk(axes.error());
    made.axes = *axes;
    made.file = std::move(file);
    std::vector<std::string> bones;
    std::vector<int32_t> parents;
    for (uint32_t i = 0; i < info->jointCount; ++i) {
        auto joint = made.avatar.joint(i);
        if (!joint) return fromSdk(joint.error());
        made.joints.push_back(joint->name);
        bones.push_back(joint->humanoidBone), parents.push_back(joint->parent);
    }
    made.regions = regionsOf(bones, parents);
    made.byHandDeg.resize(made.joints.size(), Vec3f(0));
    made.rotations_.resize(made.joints.size() * 4);
    DPL_TRY(made.face, FaceByHand::of(made.avatar));
    if (info->clipCount > 0) DPL_RETURN_IF_ERROR(made.takeNewClip());
    if (!made.clips.empty()) made.clip = 0;
    return made;
}

Status ViewedSubject::takeNewClip(const std::filesystem::path& from) {
    auto now = avatar.info();
    if (!now) return fromSdk(now.error());
    info = *now;
    const std::vector<Clip> before = std::exchange(clips, {});
    for (uint32_t i = 0; i < info.clipCount; ++i) {
        auto about = avatar.clip(i);
        if (!about) return fromSdk(about.error());
        clips.push_back({about->name, about->durationS, i < before.size() ? before[i].from : from});
    }
    if (!clips.empty()) clip = uint32_t(clips.size() - 1);
    return {};
}

void ViewedSubject::play(std::optional<uint32_t> other, double nowS) {
    if (other == clip) return;
    fadesFrom_ = clip, fadeBeganS_ = nowS;
    clip = other;
}

Status ViewedSubject::poseByClips(const Playback& clock, double nowS) {
    const auto timeIn = [&](uint32_t i) { return timeInClip(clock.timeS, clips[i].durationS, clock.loop); };
    const double share = (nowS - fadeBeganS_) / kFadeS;
    if (!fadesFrom_ || !(share >= 0 && share < 1)) {
        fadesFrom_.reset();
        const auto set = avatar.setPoseFromClip(*clip, timeIn(*clip), clock.loop);
        return set ? Status() : fromSdk(set.error());
    }
    const auto weight = float(share * share * (3 - 2 * share));
    const uint32_t flags = clock.loop ? DPL_LAYER_LOOP : 0;
    const DplClipLayer both[] = {doppel::clipLayer(*fadesFrom_, timeIn(*fadesFrom_), 1 - weight, 0, flags),
                                 doppel::clipLayer(*clip, timeIn(*clip), weight, 0, flags)};
    const auto set = avatar.setPoseFromClips(both, int64_t(nowS * 1e9));
    return set ? Status() : fromSdk(set.error());
}

Mat3d ViewedSubject::stand() const {
    const double turn = glm::radians(double(turnedDeg)), c = std::cos(turn), s = std::sin(turn);
    return Mat3d(c, 0, -s, 0, 1, 0, s, 0, c) * upright;
}

Status ViewedSubject::pose(const Playback& clock, double nowS) {
    std::array<float, 12> rows = standing(stand(), place().x);
    rows[11] = float(place().z);
    if (auto set = avatar.setTransform(rows); !set) return fromSdk(set.error());
    if (!isAvatar()) return {};
    if (auto set = avatar.setClothStiffness(clothStiffness); !set) return fromSdk(set.error());
    if (face.any()) {
        if (auto set = avatar.setExpression(face.weights); !set) return fromSdk(set.error());
        const auto seed = uint32_t(reinterpret_cast<uintptr_t>(avatar.handle()));  // people who stand together blink apart
        const float idles = face.idles ? 1.0f : 0.0f;
        if (auto set = avatar.setFaceMotion(doppel::faceMotion(seed, idles, idles), int64_t(nowS * 1e9)); !set) return fromSdk(set.error());
    }
    float root[3] = {};
    if (clip) {
        DPL_RETURN_IF_ERROR(poseByClips(clock, nowS));
        if (dplGetPose(avatar.handle(), rotations_.data(), uint32_t(joints.size()), root) != DPL_OK)
            return fail(Code::Internal, "{}", dplGetLastError());
    } else {
        for (size_t i = 0; i < rotations_.size(); ++i) rotations_[i] = i % 4 == 3 ? 1.0f : 0.0f;
    }
    for (size_t i = 0; i < joints.size(); ++i) {
        if (byHandDeg[i] == Vec3f(0)) continue;
        float* q = &rotations_[4 * i];
        const Quatf turned = Quatf(q[3], q[0], q[1], q[2]) * rotationOfAngles(byHandDeg[i]);
        q[0] = turned.x, q[1] = turned.y, q[2] = turned.z, q[3] = turned.w;
    }
    if (auto set = clip ? changePose(avatar, rotations_, root) : avatar.setPose(rotations_, root); !set) return fromSdk(set.error());
    return {};
}

WorldBox ViewedSubject::box() const {
    const Mat3d turn = stand();
    WorldBox box{Vec3d(INFINITY), Vec3d(-INFINITY)};
    for (uint32_t corner = 0; corner < 8; ++corner) {
        Vec3d at;
        for (int k = 0; k < 3; ++k) at[k] = corner >> k & 1 ? info.restMax[k] : info.restMin[k];
        at = place() + turn * at;
        box = {glm::min(box.low, at), glm::max(box.high, at)};
    }
    return box;
}

double ViewedSubject::nearestM(const Vec3d& point, const Vec3d& eye, double focalPx, double magnification) const {
    const Vec3f at(point), from(eye);
    const auto nearest = avatar.nearestDistance(std::span<const float, 3>(&at.x, 3), std::span<const float, 3>(&from.x, 3), float(focalPx),
                                                float(magnification));
    return nearest ? double(*nearest) : 0;
}

double nearestM(const std::vector<ViewedSubject>& subjects, const Vec3d& point, const Vec3d& eye, double focalPx, double magnification) {
    const ViewedSubject* closest = nullptr;
    double least = 0;
    for (const ViewedSubject& subject : subjects) {
        const WorldBox box = subject.box();
        const double away = glm::length(point - glm::clamp(point, box.low, box.high));
        if (!closest || away < least) closest = &subject, least = away;
    }
    return closest ? closest->nearestM(point, eye, focalPx, magnification) : 0;
}

std::vector<double> placesInRow(size_t count) {
    constexpr double kApartM = 1.0;  // wider than a stand
    std::vector<double> places(count);
    for (size_t i = 0; i < count; ++i) places[i] = kApartM * (double(i) - 0.5 * double(count - 1));
    return places;
}

WorldBox boxOf(const std::vector<ViewedSubject>& subjects) {
    if (subjects.empty()) return {Vec3d(-0.5, 0, -0.3), Vec3d(0.5, 1.8, 0.3)};
    WorldBox all = subjects[0].box();
    for (const ViewedSubject& subject : subjects) {
        const WorldBox box = subject.box();
        all = {glm::min(all.low, box.low), glm::max(all.high, box.high)};
    }
    return all;
}

}  // namespace dpl
