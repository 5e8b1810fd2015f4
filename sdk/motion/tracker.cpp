// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/tracker.h"

#include <algorithm>
#include <cmath>

#include "sdk/motion/limb.h"

namespace dpl {
namespace {

constexpr double kNsPerS = 1e9;
constexpr int64_t kRestartNs = 1'000'000'000;  // a stream that goes back by more has a new clock
constexpr int64_t kHoldNs = 300'000'000;
constexpr float kLeastGapS = 0.1f, kGapSteps = 3;          // a longer pause, or more missing frames, is a gap
constexpr float kFastestRadPerS = 50, kFastestMPerS = 15;  // no joint turns and no person moves as fast: the stream jumped
constexpr float kJumpRad = 0.6f, kJumpM = 0.3f;
constexpr float kFloorRisesMPerS = 0.2f, kHipsSinkMPerS = 0.002f, kJumpShowsM = 0.05f, kDeepestShare = 0.75f;
constexpr float kPushS = 0.05f;  // in which hands give way to the body, and come back
constexpr float kMovesRadPerS = 0.5f;
constexpr float kSlackRad = 0.8727f;      // 50 degrees
constexpr float kLeastHorizontal = 0.2f;  // of a view direction: below, its heading says nothing
constexpr float kShortestPalmM = 0.03f, kLongestPalmM = 0.2f;

float secondsBetween(int64_t from, int64_t to) {
    return float((double(to) - double(from)) / kNsPerS);  // in double first: int64 would overflow
}

float medianOf(std::vector<float>& values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

Quatf yaw(float rad) {
    return glm::angleAxis(rad, Vec3f(0, 1, 0));
}

bool needsRest(TrackFormat format) {
    return format == TrackFormat::Unity || format == TrackFormat::ArkitBody || format == TrackFormat::FbBody;
}

}  // namespace

Tracker::Tracker(std::vector<JointData> joints, TrackFormat format, const TrackerOptions& options)
    : joints_(std::move(joints)), format_(format), options_(options), fade_(joints_.size()) {
    local_.assign(joints_.size(), kNoTurn);
    drivers_.assign(joints_.size() + 1, 0);
    driven_.assign(joints_.size(), 0);
}

Status Tracker::checkSizes(const TrackFrame& frame) const {
    const size_t count = trackedJoints(format_).size();
    if (frame.positions.size() != 3 * count)
        return fail(Code::InvalidArgument, "positions are missing, or not 3 numbers for each of {} joints", count);
    const bool turns = format_ != TrackFormat::MediapipePose;
    if (frame.rotations.size() != (turns ? 4 * count : 0))
        return fail(Code::InvalidArgument,
                    turns ? "rotations are missing, or not 4 numbers for each of {} joints" : "this format has no rotations", count);
    if (!frame.confidence.empty() && frame.confidence.size() != count)
        return fail(Code::InvalidArgument, "confidence is not 1 number for each of {} joints", count);
    return {};
}

Result<std::unique_ptr<Tracker>> Tracker::create(std::vector<JointData> joints, TrackFormat format, const TrackerOptions& options,
                                                 const TrackFrame& rest) {
    const size_t count = trackedJoints(format).size();
    if (count == 0) return fail(Code::InvalidArgument, "there is no tracker format {}", uint32_t(format));
    std::unique_ptr<Tracker> tracker(new Tracker(std::move(joints), format, options));
    if (rest.positions.empty() && needsRest(format))
        return fail(Code::InvalidArgument, "this format needs the platform's rest pose of {} joints", count);
    if (!rest.positions.empty()) {
        if (format == TrackFormat::OpenxrHands || format == TrackFormat::MediapipePose)
            return fail(Code::InvalidArgument, "this format has no rest pose; pass none");
        DPL_RETURN_IF_ERROR(tracker->checkSizes(rest));
    }
    if (format == TrackFormat::OpenxrHands) {
        const BoneMap bones = bonesOf(tracker->joints_);
        if (!findBone(bones, "head") && !findBone(bones, "leftHand") && !findBone(bones, "rightHand"))
            return fail(Code::Unsupported, "the avatar has neither a head nor hands that are named as humanoid bones");
        tracker->hands_.emplace(tracker->joints_);
        tracker->turns_.resize(HeadAndHands::kCount);
        tracker->places_.resize(3);  // head, left wrist, right wrist
        return tracker;
    }
    DPL_TRY(TrackSkeleton skeleton, TrackSkeleton::create(format == TrackFormat::MediapipePose ? TrackFormat::Vrm : format, rest));
    tracker->skeleton_.emplace(std::move(skeleton));
    const TrackSkeleton& source = *tracker->skeleton_;
    tracker->follower_.emplace(source.joints(), source.bones(), source.rest(), tracker->joints_);
    DPL_RETURN_IF_ERROR(checkCommonBones("tracker", source.joints(), source.bones(), tracker->joints_, tracker->follower_->targetBones()));
    tracker->turns_.resize(tracker->joints_.size());
    tracker->places_.resize(1);  // root translation
    if (!rest.positions.empty()) tracker->scale_ = tracker->follower_->travelScale();
    const BoneMap& bones = tracker->follower_->targetBones();
    if (format == TrackFormat::FbBody) {  // without legs, the trunk tells
        const auto trunk = [](const BoneMap& map, auto&& at) {
            return glm::length(at(*findBone(map, "head")) - at(*findBone(map, "hips")));
        };
        tracker->scale_ = 1;
        if (findBone(bones, "head")) {
            const float own = trunk(bones, [&](size_t j) { return tracker->joints_[j].restPosition; });
            const float theirs = trunk(source.bones(), [&](size_t j) { return source.rest()[j]; });
            if (own > 0.05f && theirs > 0.05f) tracker->scale_ = own / theirs;
        }
    }
    return tracker;
}

template <class T>
void Tracker::feed(Channel<T>& channel, const T& value, const FilterLimits& limits, float farthest, bool anew) {
    const float stepS = secondsBetween(channel.lastNs, lastNs_);
    const float gapS = std::max(kLeastGapS, kGapSteps * stepS_);
    const bool fresh = channel.driver != 0 && stepS > 0 && stepS <= gapS;
    const float way = fresh ? glm::length(stepBetween(channel.filter.value(), value)) : 0.0f;
    const bool jumped = way > (std::is_same_v<T, Quatf> ? kJumpRad : kJumpM) && way > farthest * stepS;
    if (!fresh || jumped || anew) {
        channel.filter.start(value);
        ++channel.driver;
    } else if (options_.raw) {
        channel.filter.set(value);
    } else {
        channel.filter.add(value, stepS, limits);
    }
    channel.lastNs = lastNs_;
}

Status Tracker::add(const TrackFrame& given) {
    DPL_RETURN_IF_ERROR(checkSizes(given));
    if (any_ && given.timeNs <= lastNs_) {
        if (double(lastNs_) - double(given.timeNs) <= double(kRestartNs)) {
            ++status_.framesDropped;
            return {};
        }
        for (auto& channel : turns_) channel.lastNs = 0, channel.filter.start(channel.filter.value());
        for (auto& channel : places_) channel.lastNs = 0, channel.filter.start(channel.filter.value());
        any_ = false;
    }
    cleanFrame(format_, given, frame_);
    const float stepS = any_ ? secondsBetween(lastNs_, given.timeNs) : 0.0f;
    const int64_t before = lastNs_;
    const bool anyBefore = any_;
    lastNs_ = given.timeNs;
    if (stepS > 0 && stepS < 0.2f) stepS_ = stepS_ > 0 ? stepS_ + 0.1f * (stepS - stepS_) : stepS;
    any_ = true;
    const Status done = format_ == TrackFormat::OpenxrHands ? addHands() : addBones();
    if (!done) {
        lastNs_ = before, any_ = anyBefore;
        ++status_.framesDropped;
        return done;
    }
    ++status_.framesTaken;
    return {};
}

Status Tracker::addBones() {
    const float stepS = stepS_ > 0 ? stepS_ : 1.0f / 60;
    if (format_ == TrackFormat::MediapipePose) {
        bonesFromPoints(frame_.positions, frame_.tracked, points_);
        if (points_.swapped) return fail(Code::CorruptData, "left and right of the points are swapped, as in a mirrored picture");
        follower_->pose(points_.rotations, {}, points_.tracked, local_);
    } else {
        DPL_RETURN_IF_ERROR(skeleton_->read(frame_));
        follower_->pose(frame_.rotations, {}, frame_.tracked, local_);
    }
    const std::vector<uint8_t>& tracked = format_ == TrackFormat::MediapipePose ? points_.tracked : frame_.tracked;
    // Local rotations below a joint that comes or goes begin anew, since they are relative to it.
    wasTracked_.resize(tracked.size(), 0);
    std::fill(driven_.begin(), driven_.end(), uint8_t(0));
    for (const BoneFollower::Driven& d : follower_->driven()) driven_[d.target] = tracked[d.source] != wasTracked_[d.source];
    for (size_t j = 0; j < joints_.size(); ++j)
        if (joints_[j].parent >= 0) driven_[j] |= driven_[size_t(joints_[j].parent)];
    wasTracked_ = tracked;
    for (const BoneFollower::Driven& d : follower_->driven())
        if (tracked[d.source]) feed(turns_[d.target], local_[d.target], kRotationLimits, kFastestRadPerS, driven_[d.target] != 0);
    const size_t hips = *findBone(skeleton_->bones(), "hips");
    if (tracked[hips]) feed(places_[0], rootFor(stepS, frame_), kPlaceLimits, kFastestMPerS, false);
    return {};
}

/** Root translation for the pose in local_ and follower_->positions(). */
Vec3f Tracker::rootFor(float stepS, const CleanFrame& frame) {
    const std::span<const Vec3f> at = follower_->positions();
    const BoneMap &own = follower_->targetBones(), &theirs = skeleton_->bones();
    const size_t hips = *findBone(own, "hips");
    const Vec3f rest = joints_[hips].restPosition;
    Vec3f place = rest;
    const bool travels = format_ != TrackFormat::MediapipePose;  // its points are relative to the hips
    const Vec3f there = travels ? frame.positions[*findBone(theirs, "hips")] : Vec3f(0);
    if (scale_ <= 0 && travels) {  // a rest pose did not tell: legs of this frame may
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
    const float scale = scale_ > 0 ? scale_ : 1.0f;
    if (!origin_) origin_ = there;
    if (travels && options_.keepPlace) place = there;
    if (travels && !options_.keepPlace && !options_.inPlace) place = rest + scale * (there - *origin_);
    Vec3f root = place - at[hips];
    if (format_ == TrackFormat::FbBody) {
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

Status Tracker::addHands() {
    int seen = 0, wrong = 0;
    for (size_t side = 0; side < 2; ++side) {
        const size_t wrist = handJoint(side, kWrist), index = handJoint(side, kIndexProximal), little = handJoint(side, kLittleProximal),
                     middle = handJoint(side, kMiddleProximal);
        bool usable = frame_.tracked[wrist] != 0;
        if (usable && frame_.tracked[index] && frame_.tracked[little]) {
            const auto from = [&](size_t joint) { return frame_.positions[joint] - frame_.positions[wrist]; };
            const Vec3f back = (side == 0 ? 1.0f : -1.0f) * glm::cross(from(index), from(little));
            const bool other = glm::dot(back, frame_.rotations[wrist] * Vec3f(0, 1, 0)) < 0;
            const float palm = glm::length(from(frame_.tracked[middle] ? middle : index));
            ++seen;
            wrong += other;
            usable = !other && palm > kShortestPalmM && palm < kLongestPalmM;
        }
        for (size_t j = 0; j < kHandJoints && !usable; ++j) frame_.tracked[handJoint(side, j)] = 0;
    }
    if (seen == 2 && wrong == 2) return fail(Code::CorruptData, "left and right hand are swapped: both thumbs lie on the wrong side");
    for (size_t j = 0; j < HeadAndHands::kCount; ++j)
        if (frame_.tracked[j]) feed(turns_[j], frame_.rotations[j], kRotationLimits, kFastestRadPerS, false);
    for (size_t place = 0; place < places_.size(); ++place) {
        const size_t joint = place == 0 ? 0 : handJoint(place - 1, kWrist);
        if (frame_.tracked[joint]) feed(places_[place], frame_.positions[joint], kPlaceLimits, kFastestMPerS, false);
    }
    return {};
}

template <class T>
bool Tracker::isFresh(const Channel<T>& channel) const {
    return channel.driver != 0 && any_ && double(pictureNs_) - double(channel.lastNs) <= double(kHoldNs);
}

template <class T>
T Tracker::sample(const Channel<T>& channel) {
    if (options_.raw) return channel.filter.value();
    const float ahead = aheadFor(secondsBetween(channel.lastNs, pictureNs_) + channel.filter.delayS());
    ahead_ = std::max(ahead_, ahead);
    return channel.filter.after(ahead, std::is_same_v<T, Quatf> ? kFastestRadPerS : kFastestMPerS);
}

void Tracker::poseBones(Pose& pose) {
    for (const BoneFollower::Driven& d : follower_->driven()) {
        const auto& channel = turns_[d.target];
        if (!isFresh(channel)) continue;
        pose.localRotations[d.target] = sample(channel);
        drivers_[d.target] = channel.driver;
    }
    if (!isFresh(places_[0])) return;
    pose.rootTranslation = sample(places_[0]);
    drivers_.back() = places_[0].driver;
}

void Tracker::poseHands(Pose& pose) {
    HeadAndHands person;
    person.rotations.fill(kNoTurn);
    person.positions.fill(Vec3f(0));
    uint32_t driver = 1;
    for (size_t j = 0; j < HeadAndHands::kCount; ++j) {
        person.tracked[j] = isFresh(turns_[j]);
        if (person.tracked[j]) person.rotations[j] = sample(turns_[j]);
    }
    for (size_t place = 0; place < places_.size(); ++place) {
        const size_t joint = place == 0 ? 0 : handJoint(place - 1, kWrist);
        driver += turns_[joint].driver;
        if (!isFresh(places_[place])) person.tracked[joint] = 0;
        if (person.tracked[joint]) person.positions[joint] = sample(places_[place]);
    }
    const bool stands = !options_.inPlace && person.tracked[0];
    Quatf heading = kNoTurn;
    Vec3f below(0);
    if (stands) {
        const Vec3f ahead = person.rotations[0] * Vec3f(0, 0, -1);
        if (std::hypot(ahead.x, ahead.z) >= kLeastHorizontal) {
            const float heading = std::atan2(ahead.x, ahead.z);
            if (!stanceKnown_) stanceYawRad_ = heading;
            stanceKnown_ = true;
            const float turned = std::remainder(heading - stanceYawRad_, 2 * glm::pi<float>());
            stanceYawRad_ += turned - std::clamp(turned, -kSlackRad, kSlackRad);
        }
        heading = yaw(stanceYawRad_);
        below = Vec3f(person.positions[0].x, 0, person.positions[0].z);
        for (size_t j = 0; j < HeadAndHands::kCount; ++j) {
            person.rotations[j] = glm::conjugate(heading) * person.rotations[j];
            person.positions[j] = glm::conjugate(heading) * (person.positions[j] - below);
        }
        if (!origin_) origin_ = below;
    }
    std::fill(driven_.begin(), driven_.end(), uint8_t(0));
    hands_->pose(person, pose, driven_);
    if (stands && !joints_.empty()) {
        const Vec3f pivot = joints_[0].restPosition;
        pose.rootTranslation = heading * (pivot + pose.rootTranslation) - pivot + (options_.keepPlace ? below : below - *origin_);
        pose.localRotations[0] = heading * pose.localRotations[0];
        driven_[0] = 1;
        drivers_.back() = driver;
    }
    for (size_t j = 0; j < joints_.size(); ++j)
        if (driven_[j]) drivers_[j] = driver;
}

/** Feet stand where they do at rest, below the hips and turned with them; knees bend as far as the hips have sunk. */
void Tracker::standBelowHips(Pose& pose) {
    const BoneMap& bones = follower_->targetBones();
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
            drivers_[joint] = 1;
        };
        set(*upper, world_[size_t(joints_[*upper].parent)], first);
        set(*lower, first, second);
        set(*foot, second, heading);
    }
}

void Tracker::pose(int64_t timeNs, bool holdsPlace, Pose& pose) {
    pictureNs_ = timeNs;
    ahead_ = 0;
    std::fill(drivers_.begin(), drivers_.end(), 0u);
    if (hands_)
        poseHands(pose);
    else
        poseBones(pose);
    if (holdsPlace && drivers_.back() == 0) pose.rootTranslation = Vec3f(rootShown_.x, pose.rootTranslation.y, rootShown_.z);
    const float stepS = shown_ ? std::clamp(secondsBetween(shownNs_, timeNs), 0.0f, 0.1f) : 0.0f;
    if (format_ == TrackFormat::FbBody && drivers_.back() != 0) standBelowHips(pose);
    fade_.step(pose, drivers_, stepS);
    shownNs_ = timeNs, shown_ = true;
    rootShown_ = pose.rootTranslation;
    if (guard_) {
        ArmGuard::Pushes needed = guard_->pushes(pose);
        const float share = 1 - std::exp(-stepS / kPushS);
        const auto follow = [&](Vec3f& pushed, const Vec3f& wanted) {
            pushed += share * (wanted - pushed);
            if (glm::length(pushed) < 1e-5f) pushed = Vec3f(0);
        };
        for (size_t side = 0; side < 2; ++side) {
            const auto arm = guard_->upperArm(side);
            if (!arm || drivers_[*arm] == 0) needed[side] = {};  // the pose beneath is the program's own
            follow(pushed_[side].elbow, needed[side].elbow), follow(pushed_[side].wrist, needed[side].wrist);
        }
        guard_->push(pushed_, pose);
    }
    describe();
}

void Tracker::describe() {
    status_.drivenJoints = uint32_t(std::count_if(drivers_.begin(), drivers_.end() - 1, [](uint32_t d) { return d != 0; }));
    status_.state = !any_ && status_.framesTaken == 0                                                     ? TrackerState::Waiting
                    : double(pictureNs_) - double(lastNs_) <= double(kHoldNs) && status_.drivenJoints > 0 ? TrackerState::Tracking
                                                                                                          : TrackerState::Lost;
    status_.rateHz = stepS_ > 0 ? 1 / stepS_ : 0.0f;
    status_.predictedS = ahead_;
    sorted_.clear();
    for (const auto& channel : turns_)
        if (channel.driver != 0) sorted_.push_back(channel.filter.noise());
    status_.noiseDeg = glm::degrees(medianOf(sorted_));
    for (const float slowest : {kMovesRadPerS, 0.0f}) {  // of joints that move, or of all if none does
        sorted_.clear();
        for (const auto& channel : turns_)
            if (channel.driver != 0 && channel.filter.speed() >= slowest) sorted_.push_back(channel.filter.delayS());
        if (!sorted_.empty()) break;
    }
    status_.delayS = medianOf(sorted_);
}

}  // namespace dpl
