// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/tracker.h"

#include <algorithm>
#include <cmath>

namespace dpl {
namespace {

constexpr double kRestartNs = 1e9;   // a stream that goes back by more has a new clock
constexpr uint32_t kLateInARow = 4;  // frames that rise below the last one: its time was wrong, or the clock was set back
constexpr float kPushS = 0.05f;      // in which hands give way to the body, and come back
constexpr float kMovesRadPerS = 0.5f;

float medianOf(std::vector<float>& values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace

Tracker::Tracker(std::vector<JointData> joints, const TrackerOptions& options) : joints_(std::move(joints)), fade_(joints_.size()) {
    clock_.raw = options.raw;
    drivers_.assign(joints_.size() + 1, 0);
}

Result<std::unique_ptr<Tracker>> Tracker::create(std::vector<JointData> joints, TrackFormat format, const TrackerOptions& options,
                                                 const TrackFrame& rest) {
    std::unique_ptr<Tracker> tracker(new Tracker(std::move(joints), options));
    DPL_TRY(tracker->source_, TrackSource::create(format, rest));
    DPL_TRY(tracker->driver_, TrackDriver::create(*tracker->source_, tracker->joints_, options));
    return tracker;
}

Status Tracker::add(const TrackFrame& given) {
    DPL_RETURN_IF_ERROR(source_->checkSizes(given));
    if (clock_.any && given.timeNs <= clock_.lastNs) {
        lateInARow_ = lateInARow_ > 0 && given.timeNs > lastLateNs_ ? lateInARow_ + 1 : 1;
        lastLateNs_ = given.timeNs;
        if (lateInARow_ < kLateInARow && double(clock_.lastNs) - double(given.timeNs) <= kRestartNs) {
            ++status_.framesDropped;
            return {};
        }
        driver_->restart();
        clock_.any = false;
    }
    lateInARow_ = 0;
    const StreamClock before = clock_;
    const float stepS = clock_.any ? secondsBetween(clock_.lastNs, given.timeNs) : 0.0f;
    clock_.lastNs = given.timeNs;
    if (stepS > 0 && stepS < 0.2f) clock_.stepS = clock_.stepS > 0 ? clock_.stepS + 0.1f * (stepS - clock_.stepS) : stepS;
    clock_.any = true;
    if (const Status read = source_->read(given, frame_); !read) {
        clock_.lastNs = before.lastNs, clock_.any = before.any;  // what it told of the rate stays
        ++status_.framesDropped;
        return read;
    }
    driver_->take(frame_, clock_);
    ++status_.framesTaken;
    return {};
}

void Tracker::pose(int64_t timeNs, bool holdsPlace, Pose& pose) {
    clock_.pictureNs = timeNs;
    std::fill(drivers_.begin(), drivers_.end(), 0u);
    const float aheadS = driver_->show(clock_, pose, drivers_);
    if (holdsPlace && drivers_.back() == 0) pose.rootTranslation = Vec3f(rootShown_.x, pose.rootTranslation.y, rootShown_.z);
    const float stepS = shown_ ? std::clamp(secondsBetween(shownNs_, timeNs), 0.0f, 0.1f) : 0.0f;
    driver_->complete(pose, drivers_);
    fade_.step(pose, drivers_, stepS);
    shownNs_ = timeNs, shown_ = true;
    rootShown_ = pose.rootTranslation;
    if (guard_) pushArms(stepS, pose);
    describe(aheadS);
}

void Tracker::pushArms(float stepS, Pose& pose) {
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

void Tracker::describe(float aheadS) {
    status_.drivenJoints = uint32_t(std::count_if(drivers_.begin(), drivers_.end() - 1, [](uint32_t d) { return d != 0; }));
    status_.state = !clock_.any && status_.framesTaken == 0                   ? TrackerState::Waiting
                    : clock_.holds(clock_.lastNs) && status_.drivenJoints > 0 ? TrackerState::Tracking
                                                                              : TrackerState::Lost;
    status_.rateHz = clock_.stepS > 0 ? 1 / clock_.stepS : 0.0f;
    status_.predictedS = aheadS;
    const std::span<const TrackChannel<Quatf>> turns = driver_->turns();
    sorted_.clear();
    for (const auto& channel : turns)
        if (channel.driver() != 0) sorted_.push_back(channel.filter().noise());
    status_.noiseDeg = glm::degrees(medianOf(sorted_));
    for (const float slowest : {kMovesRadPerS, 0.0f}) {  // of joints that move, or of all if none does
        sorted_.clear();
        for (const auto& channel : turns)
            if (channel.driver() != 0 && channel.filter().speed() >= slowest) sorted_.push_back(channel.filter().delayS());
        if (!sorted_.empty()) break;
    }
    status_.delayS = medianOf(sorted_);
}

}  // namespace dpl
