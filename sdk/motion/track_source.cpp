// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/track_source.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "sdk/motion/track_points.h"

namespace dpl {
namespace {

constexpr float kTracked = 0.5f, kFarthestM = 1000, kFarthestNumber = 1e5f, kLeastQuaternion = 1e-3f;
constexpr size_t kManyFar = 4;  // joints beyond kFarthestM: no stray ones
constexpr float kShortestPalmM = 0.03f, kLongestPalmM = 0.2f, kPalmInOtherUnits = 2;

bool isUsable(const float* numbers, size_t count, float largest) {
    return std::all_of(numbers, numbers + count, [&](float x) { return std::abs(x) <= largest; });  // false for NaN
}

/** Formats that give world rotations and positions of bones. */
class BoneSource : public TrackSource {
public:
    using TrackSource::TrackSource;
    Status read(const TrackFrame& frame, CleanFrame& out) override {
        DPL_RETURN_IF_ERROR(clean(frame, out));
        return skeleton_->read(out);
    }
    const TrackSkeleton* skeleton() const override { return &*skeleton_; }

private:
    Status start(const CleanFrame& rest) override {
        DPL_TRY(TrackSkeleton made, TrackSkeleton::create(table_, rest));
        skeleton_.emplace(std::move(made));
        return {};
    }

    std::optional<TrackSkeleton> skeleton_;
};

class VrmSource final : public BoneSource {
public:
    VrmSource() : BoneSource(trackedJoints(TrackFormat::Vrm)) {}

private:
    RestPose restPose() const override { return RestPose::Optional; }
};

class UnitySource final : public BoneSource {
public:
    UnitySource() : BoneSource(trackedJoints(TrackFormat::Unity)) {}

private:
    void turnAxes(Quatf& rotation, Vec3f& position) const override {  // a mirror in z: left-handed to right-handed
        rotation = Quatf(rotation.w, -rotation.x, -rotation.y, rotation.z);
        position.z = -position.z;
    }
};

class ArkitBodySource final : public BoneSource {
public:
    ArkitBodySource() : BoneSource(trackedJoints(TrackFormat::ArkitBody)) {}
};

class FbBodySource final : public BoneSource {
public:
    FbBodySource() : BoneSource(trackedJoints(TrackFormat::FbBody)) {}
    bool tellsLegs() const override { return false; }
};

class OpenxrHandsSource final : public TrackSource {
public:
    OpenxrHandsSource() : TrackSource(trackedJoints(TrackFormat::OpenxrHands)) {}
    Status read(const TrackFrame& frame, CleanFrame& out) override {
        DPL_RETURN_IF_ERROR(clean(frame, out));
        int seen = 0, wrong = 0, huge = 0;
        for (size_t side = 0; side < 2; ++side) {
            const size_t wrist = handJoint(side, kWrist), index = handJoint(side, kIndexProximal),
                         little = handJoint(side, kLittleProximal), middle = handJoint(side, kMiddleProximal);
            bool usable = out.tracked[wrist] != 0;
            if (usable && out.tracked[index] && out.tracked[little]) {
                const auto from = [&](size_t joint) { return out.positions[joint] - out.positions[wrist]; };
                const Vec3f back = (side == 0 ? 1.0f : -1.0f) * glm::cross(from(index), from(little));
                const bool other = glm::dot(back, out.rotations[wrist] * Vec3f(0, 1, 0)) < 0;
                const float palm = glm::length(from(out.tracked[middle] ? middle : index));
                ++seen;
                wrong += other, huge += palm > kPalmInOtherUnits;
                usable = !other && palm > kShortestPalmM && palm < kLongestPalmM;
            }
            for (size_t j = 0; j < kHandJoints && !usable; ++j) out.tracked[handJoint(side, j)] = 0;
        }
        if (seen > 0 && huge == seen)
            return fail(Code::CorruptData, "palms are metres long: metres are needed, these look like centimetres or millimetres");
        if (seen == 2 && wrong == 2) return fail(Code::CorruptData, "left and right hand are swapped: both thumbs lie on the wrong side");
        return {};
    }

private:
    RestPose restPose() const override { return RestPose::None; }
    Status start(const CleanFrame&) override { return {}; }
};

class MediapipePoseSource final : public TrackSource {
public:
    MediapipePoseSource() : TrackSource(trackedJoints(TrackFormat::MediapipePose)) {}
    Status read(const TrackFrame& frame, CleanFrame& out) override {
        DPL_RETURN_IF_ERROR(clean(frame, points_));
        DPL_RETURN_IF_ERROR(checkUnit());
        bonesFromPoints(points_.positions, points_.tracked, bones_);
        if (bones_.swapped) return fail(Code::CorruptData, "left and right of the points are swapped, as in a mirrored picture");
        out.rotations = bones_.rotations;
        out.tracked = bones_.tracked;
        return {};
    }
    const TrackSkeleton* skeleton() const override { return &*skeleton_; }
    bool travels() const override { return false; }

private:
    RestPose restPose() const override { return RestPose::None; }
    bool hasRotations() const override { return false; }
    void turnAxes(Quatf&, Vec3f& position) const override { position = Vec3f(position.x, -position.y, -position.z); }
    Status start(const CleanFrame&) override {
        DPL_TRY(TrackSkeleton made, TrackSkeleton::create(trackedJoints(TrackFormat::Vrm), {}));  // points are turned into VRM's bones
        skeleton_.emplace(std::move(made));
        return {};
    }

    /** Shoulders are some 0.3 m apart. */
    Status checkUnit() const {
        constexpr size_t kLeftShoulder = 11, kRightShoulder = 12;
        constexpr float kWidestM = 3;
        if (!points_.tracked[kLeftShoulder] || !points_.tracked[kRightShoulder]) return {};
        const float across = glm::length(points_.positions[kLeftShoulder] - points_.positions[kRightShoulder]);
        if (across < kWidestM) return {};
        return fail(Code::CorruptData,
                    "shoulders are {} m apart: metres are needed (world landmarks); these look like pixels, centimetres or millimetres",
                    across);
    }

    std::optional<TrackSkeleton> skeleton_;
    CleanFrame points_;
    PointBones bones_;
};

std::unique_ptr<TrackSource> sourceOf(TrackFormat format) {
    switch (format) {
        case TrackFormat::Vrm:
            return std::make_unique<VrmSource>();
        case TrackFormat::Unity:
            return std::make_unique<UnitySource>();
        case TrackFormat::ArkitBody:
            return std::make_unique<ArkitBodySource>();
        case TrackFormat::FbBody:
            return std::make_unique<FbBodySource>();
        case TrackFormat::OpenxrHands:
            return std::make_unique<OpenxrHandsSource>();
        case TrackFormat::MediapipePose:
            return std::make_unique<MediapipePoseSource>();
    }
    return nullptr;
}

}  // namespace

Result<std::unique_ptr<TrackSource>> TrackSource::create(TrackFormat format, const TrackFrame& rest) {
    std::unique_ptr<TrackSource> source = sourceOf(format);
    if (!source) return fail(Code::InvalidArgument, "there is no tracker format {}", uint32_t(format));
    const bool given = !rest.positions.empty();
    if (!given && source->restPose() == RestPose::Needed)
        return fail(Code::InvalidArgument, "this format needs the platform's rest pose of {} joints", source->jointCount());
    if (given && source->restPose() == RestPose::None) return fail(Code::InvalidArgument, "this format has no rest pose; pass none");
    CleanFrame pose;
    if (given) {
        DPL_RETURN_IF_ERROR(source->checkSizes(rest));
        if (const Status usable = source->clean(rest, pose); !usable)
            return fail(Code::InvalidArgument, "rest: {}", usable.error().message);
    }
    DPL_RETURN_IF_ERROR(source->start(pose));
    return source;
}

Status TrackSource::checkSizes(const TrackFrame& frame) const {
    const size_t count = table_.size();
    if (frame.positions.size() != 3 * count)
        return fail(Code::InvalidArgument, "positions are missing, or not 3 numbers for each of {} joints", count);
    if (frame.rotations.size() != (hasRotations() ? 4 * count : 0))
        return fail(Code::InvalidArgument,
                    hasRotations() ? "rotations are missing, or not 4 numbers for each of {} joints" : "this format has no rotations",
                    count);
    if (!frame.confidence.empty() && frame.confidence.size() != count)
        return fail(Code::InvalidArgument, "confidence is not 1 number for each of {} joints", count);
    return {};
}

Status TrackSource::clean(const TrackFrame& frame, CleanFrame& out) const {
    const size_t count = table_.size();
    out.rotations.assign(count, Quatf(1, 0, 0, 0));
    out.positions.assign(count, Vec3f(0));
    out.tracked.assign(count, 0);
    size_t usable = 0, far = 0;
    for (size_t j = 0; j < count; ++j) {
        const float* p = frame.positions.data() + 3 * j;
        if (!frame.confidence.empty() && !(frame.confidence[j] >= kTracked)) continue;
        if (isUsable(p, 3, kFarthestNumber)) ++usable, far += !isUsable(p, 3, kFarthestM);
        if (!isUsable(p, 3, kFarthestM)) continue;
        if (!frame.rotations.empty()) {
            const float* r = frame.rotations.data() + 4 * j;
            if (!isUsable(r, 4, 1e6f)) continue;
            const Quatf q(r[3], r[0], r[1], r[2]);
            const float length = glm::length(q);
            if (!(length > kLeastQuaternion)) continue;
            out.rotations[j] = q / length;
        }
        out.positions[j] = Vec3f(p[0], p[1], p[2]);
        turnAxes(out.rotations[j], out.positions[j]);
        out.tracked[j] = 1;
    }
    if (far >= kManyFar)
        return fail(Code::CorruptData, "{} of {} joints lie farther away than {} m: metres are needed, these look like millimetres", far,
                    usable, kFarthestM);
    return {};
}

}  // namespace dpl
