// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/track_driver.h"

#include <algorithm>
#include <cmath>

#include "sdk/motion/limb.h"

namespace dpl {
namespace {

constexpr float kFloorRisesMPerS = 0.2f, kHipsSinkMPerS = 0.002f, kJumpShowsM = 0.05f, kDeepestShare = 0.75f;
constexpr float kSlackRad = 0.8727f;      // 50 degrees
constexpr float kLeastHorizontal = 0.2f;  // of a view direction: below, its heading says nothing

Quatf yaw(float rad) {
    return glm::angleAxis(rad, Vec3f(0, 1, 0));
}

}  // namespace

Result<std::unique_ptr<TrackDriver>> TrackDriver::create(const TrackSource& source, std::span<const JointData> joints,
                                                         const TrackerOptions& options) {
    if (!source.skeleton()) {
        const BoneMap bones = bonesOf(joints);
        if (!findBone(bones, "head") && !findBone(bones, "leftHand") && !findBone(bones, "rightHand"))
            return fail(Code::Unsupported, "the avatar has neither a head nor hands that are named as humanoid bones");
        return std::unique_ptr<TrackDriver>(new HandDriver(joints, options));
    }
    auto driver = std::make_unique<BoneDriver>(source, joints, options);
    DPL_RETURN_IF_ERROR(
        checkCommonBones("tracker", source.skeleton()->joints(), source.skeleton()->bones(), joints, driver->targetBones()));
    driver->findScale();
    return std::unique_ptr<TrackDriver>(std::move(driver));
}

void TrackDriver::restart() {
    for (auto& channel : turns_) channel.restart();
    for (auto& channel : places_) channel.restart();
}

BoneDriver::BoneDriver(const TrackSource& source, std::span<const JointData> joints, const TrackerOptions& options)
    : TrackDriver(joints, options),
      source_(source),
      skeleton_(*source.skeleton()),
      follower_(skeleton_.joints(), skeleton_.bones(), skeleton_.rest(), joints),
      local_(joints.size(), kNoTurn),
      anew_(joints.size(), 0) {
    turns_.resize(joints.size());
    places_.resize(1);  // root translation
}

/** Where the rest pose tells the person's size. */
void BoneDriver::findScale() {
    if (skeleton_.knowsLengths()) scale_ = follower_.travelScale();
    if (source_.tellsLegs()) return;
    const auto trunk = [](const BoneMap& map, auto&& at) { return glm::length(at(*findBone(map, "head")) - at(*findBone(map, "hips"))); };
    scale_ = 1;
    if (!findBone(targetBones(), "head")) return;
    const float own = trunk(targetBones(), [&](size_t j) { return joints_[j].restPosition; });
    const float theirs = trunk(skeleton_.bones(), [&](size_t j) { return skeleton_.rest()[j]; });
    if (own > 0.05f && theirs > 0.05f) scale_ = own / theirs;
}

void BoneDriver::take(const CleanFrame& frame, const StreamClock& clock) {
    const std::vector<uint8_t>& tracked = frame.tracked;
    follower_.pose(frame.rotations, {}, tracked, local_);
    // Local rotations below a joint that comes or goes begin anew, since they are relative to it.
    wasTracked_.resize(tracked.size(), 0);
    std::fill(anew_.begin(), anew_.end(), uint8_t(0));
    for (const BoneFollower::Driven& d : follower_.driven()) anew_[d.target] = tracked[d.source] != wasTracked_[d.source];
    for (size_t j = 0; j < joints_.size(); ++j)
        if (joints_[j].parent >= 0) anew_[j] |= anew_[size_t(joints_[j].parent)];
    wasTracked_ = tracked;
    for (const BoneFollower::Driven& d : follower_.driven())
        if (tracked[d.source]) turns_[d.target].feed(clock, local_[d.target], anew_[d.target] != 0);
    const size_t hips = *findBone(skeleton_.bones(), "hips");
    if (tracked[hips]) places_[0].feed(clock, rootFor(clock.stepS > 0 ? clock.stepS : 1.0f / 60, frame));
}

/** A rest pose did not tell the scale of travel; legs of this frame may. */
void BoneDriver::measureLegs(const CleanFrame& frame) {
    const BoneMap &own = targetBones(), &theirs = skeleton_.bones();
    float theirLegs = 0, ownLegs = 0;
    for (const std::string side : {"left", "right"})
        for (const auto& [a, b] : {std::pair("UpperLeg", "LowerLeg"), {"LowerLeg", "Foot"}}) {
            const auto ta = findBone(theirs, side + a), tb = findBone(theirs, side + b), oa = findBone(own, side + a),
                       ob = findBone(own, side + b);
            if (!ta || !tb || !oa || !ob || !frame.tracked[*ta] || !frame.tracked[*tb]) continue;
            theirLegs += glm::length(frame.positions[*tb] - frame.positions[*ta]);
            ownLegs += glm::length(joints_[*ob].restPosition - joints_[*oa].restPosition);
        }
    if (theirLegs > 0.1f && ownLegs > 0.1f) scale_ = ownLegs / theirLegs;
}

/** Root translation for the pose in local_ and follower_.positions(). */
Vec3f BoneDriver::rootFor(float stepS, const CleanFrame& frame) {
    const std::span<const Vec3f> at = follower_.positions();
    const BoneMap &own = targetBones(), &theirs = skeleton_.bones();
    const size_t hips = *findBone(own, "hips");
    const Vec3f rest = joints_[hips].restPosition;
    Vec3f place = rest;
    const bool travels = source_.travels();
    const Vec3f there = travels ? frame.positions[*findBone(theirs, "hips")] : Vec3f(0);
    if (scale_ <= 0 && travels) measureLegs(frame);
    const float scale = scale_ > 0 ? scale_ : 1.0f;
    if (!origin_) origin_ = there;
    if (travels && options_.keepPlace) place = there;
    if (travels && !options_.keepPlace && !options_.inPlace) place = rest + scale * (there - *origin_);
    Vec3f root = place - at[hips];
    if (!source_.tellsLegs()) {
        if (!floor_ || there.y > *floor_) floor_ = there.y;
        *floor_ = std::max(there.y, *floor_ - kHipsSinkMPerS * stepS);
        root.y = std::max(scale * (there.y - *floor_), -kDeepestShare * rest.y) + rest.y - at[hips].y;
        return root;
    }
    float lowest = 1e30f, theirLowest = 1e30f;
    for (std::string_view bone : {"leftFoot", "rightFoot", "leftToes", "rightToes"}) {
        if (const auto joint = findBone(own, bone)) lowest = std::min(lowest, at[*joint].y - joints_[*joint].restPosition.y);
        const auto joint = travels ? findBone(theirs, bone) : std::nullopt;
        if (joint && frame.tracked[*joint]) theirLowest = std::min(theirLowest, frame.positions[*joint].y);
    }
    float air = 0;
    if (theirLowest < 1e29f) {
        floor_ = floor_ ? std::min(theirLowest, *floor_ + kFloorRisesMPerS * stepS) : theirLowest;
        air = std::max(0.0f, theirLowest - *floor_ - kJumpShowsM);
    }
    root.y = (lowest < 1e29f ? -lowest : rest.y - at[hips].y) + scale * air;
    return root;
}

float BoneDriver::show(const StreamClock& clock, Pose& pose, std::span<uint32_t> drivers) {
    float aheadS = 0;
    for (const BoneFollower::Driven& d : follower_.driven()) {
        const auto& channel = turns_[d.target];
        if (!channel.isFresh(clock)) continue;
        pose.localRotations[d.target] = channel.sample(clock, aheadS);
        drivers[d.target] = channel.driver();
    }
    if (!places_[0].isFresh(clock)) return aheadS;
    pose.rootTranslation = places_[0].sample(clock, aheadS);
    drivers.back() = places_[0].driver();
    return aheadS;
}

void BoneDriver::complete(Pose& pose, std::span<uint32_t> drivers) {
    if (!source_.tellsLegs() && drivers.back() != 0) standBelowHips(pose, drivers);
}

/** Feet stand where they do at rest, below the hips and turned with them; knees bend as far as the hips have sunk. */
void BoneDriver::standBelowHips(Pose& pose, std::span<uint32_t> drivers) {
    const BoneMap& bones = targetBones();
    const size_t hips = *findBone(bones, "hips");
    world_.resize(joints_.size());
    at_.resize(joints_.size());
    for (size_t j = 0; j < joints_.size(); ++j) {
        const int32_t above = joints_[j].parent;
        const Quatf parent = above < 0 ? kNoTurn : world_[size_t(above)];
        at_[j] = above < 0 ? joints_[j].restPosition + (j == 0 ? pose.rootTranslation : Vec3f(0))
                           : at_[size_t(above)] + parent * (joints_[j].restPosition - joints_[size_t(above)].restPosition);
        world_[j] = glm::normalize(parent * pose.localRotations[j]);
    }
    const Vec3f ahead = world_[hips] * Vec3f(0, 0, 1);
    const Quatf heading = yaw(std::hypot(ahead.x, ahead.z) > kLeastHorizontal ? std::atan2(ahead.x, ahead.z) : 0.0f);
    for (const std::string side : {"left", "right"}) {
        const auto upper = findBone(bones, side + "UpperLeg"), lower = findBone(bones, side + "LowerLeg"),
                   foot = findBone(bones, side + "Foot");
        if (!upper || !lower || !foot || joints_[*upper].parent < 0 || joints_[*lower].parent != int32_t(*upper) ||
            joints_[*foot].parent != int32_t(*lower))
            continue;
        Vec3f target = heading * (joints_[*foot].restPosition - joints_[hips].restPosition);
        target += at_[hips];
        target.y = joints_[*foot].restPosition.y;
        const auto turn = reachWith({at_[*upper], at_[*lower], at_[*foot]}, target, heading * Vec3f(0, 0, 1));
        const Quatf first = turn[0] * world_[*upper], second = turn[1] * world_[*lower];
        const auto set = [&](size_t joint, const Quatf& above, const Quatf& world) {
            pose.localRotations[joint] = glm::normalize(glm::conjugate(above) * world);
            drivers[joint] = 1;
        };
        set(*upper, world_[size_t(joints_[*upper].parent)], first);
        set(*lower, first, second);
        set(*foot, second, heading);
    }
}

HandDriver::HandDriver(std::span<const JointData> joints, const TrackerOptions& options)
    : TrackDriver(joints, options), follower_(joints), driven_(joints.size(), 0) {
    turns_.resize(HeadAndHands::kCount);
    places_.resize(3);  // head, left wrist, right wrist
}

void HandDriver::take(const CleanFrame& frame, const StreamClock& clock) {
    for (size_t j = 0; j < HeadAndHands::kCount; ++j)
        if (frame.tracked[j]) turns_[j].feed(clock, frame.rotations[j]);
    for (size_t place = 0; place < places_.size(); ++place) {
        const size_t joint = place == 0 ? 0 : handJoint(place - 1, kWrist);
        if (frame.tracked[joint]) places_[place].feed(clock, frame.positions[joint]);
    }
}

/** Where the body faces: it turns with the head by what exceeds the slack of the neck. */
Quatf HandDriver::headingOf(const Quatf& head) {
    const Vec3f ahead = head * Vec3f(0, 0, -1);
    if (std::hypot(ahead.x, ahead.z) >= kLeastHorizontal) {
        const float heading = std::atan2(ahead.x, ahead.z);
        if (!stanceKnown_) stanceYawRad_ = heading;
        stanceKnown_ = true;
        const float turned = std::remainder(heading - stanceYawRad_, 2 * glm::pi<float>());
        stanceYawRad_ += turned - std::clamp(turned, -kSlackRad, kSlackRad);
    }
    return yaw(stanceYawRad_);
}

float HandDriver::show(const StreamClock& clock, Pose& pose, std::span<uint32_t> drivers) {
    HeadAndHands person;
    person.rotations.fill(kNoTurn);
    person.positions.fill(Vec3f(0));
    uint32_t driver = 1;
    float aheadS = 0;
    for (size_t j = 0; j < HeadAndHands::kCount; ++j) {
        person.tracked[j] = turns_[j].isFresh(clock);
        if (person.tracked[j]) person.rotations[j] = turns_[j].sample(clock, aheadS);
    }
    for (size_t place = 0; place < places_.size(); ++place) {
        const size_t joint = place == 0 ? 0 : handJoint(place - 1, kWrist);
        driver += turns_[joint].driver();
        if (!places_[place].isFresh(clock)) person.tracked[joint] = 0;
        if (person.tracked[joint]) person.positions[joint] = places_[place].sample(clock, aheadS);
    }
    const bool stands = !options_.inPlace && person.tracked[0];
    Quatf heading = kNoTurn;
    Vec3f below(0);
    if (stands) {
        heading = headingOf(person.rotations[0]);
        below = Vec3f(person.positions[0].x, 0, person.positions[0].z);
        for (size_t j = 0; j < HeadAndHands::kCount; ++j) {
            person.rotations[j] = glm::conjugate(heading) * person.rotations[j];
            person.positions[j] = glm::conjugate(heading) * (person.positions[j] - below);
        }
        if (!origin_) origin_ = below;
    }
    std::fill(driven_.begin(), driven_.end(), uint8_t(0));
    follower_.pose(person, pose, driven_);
    if (stands && !joints_.empty()) {
        const Vec3f pivot = joints_[0].restPosition;
        pose.rootTranslation = heading * (pivot + pose.rootTranslation) - pivot + (options_.keepPlace ? below : below - *origin_);
        pose.localRotations[0] = heading * pose.localRotations[0];
        driven_[0] = 1;
        drivers.back() = driver;
    }
    for (size_t j = 0; j < joints_.size(); ++j)
        if (driven_[j]) drivers[j] = driver;
    return aheadS;
}

}  // namespace dpl
