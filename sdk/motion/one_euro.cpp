// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/one_euro.h"

#include <algorithm>
#include <cmath>

namespace dpl {
namespace {

constexpr float kTau = 6.2831853f;
constexpr float kSpeedCutoffHz = 3.0f;  // of the speed that opens the filter; 1 Hz (the paper) opens it too late for walks
constexpr float kSlowestHz = 0.7f;      // a stiller filter would be felt when motion starts
constexpr float kQuartile = 1.1011f;    // of the length of a vector of three standard normals
constexpr float kSecondGain = 2.4495f;  // √6: standard deviation of a second difference over that of the values
constexpr float kLearnRate = 0.15f;     // of a quartile, per value, relative: settles in about 40

/** Share of a step that a low-pass takes over. */
float shareOf(float cutoffHz, float stepS) {
    const float x = kTau * cutoffHz * stepS;
    return x / (1 + x);
}

}  // namespace

Vec3f stepBetween(const Quatf& from, const Quatf& to) {
    Quatf turn = glm::conjugate(from) * to;
    if (turn.w < 0) turn = -turn;
    const Vec3f v(turn.x, turn.y, turn.z);
    const float sine = glm::length(v);
    return sine < 1e-6f ? 2.0f * v : v * (2 * std::atan2(sine, turn.w) / sine);
}

Quatf stepped(const Quatf& from, const Vec3f& step) {
    const float angle = glm::length(step);
    if (angle < 1e-7f) return from;
    return glm::normalize(from * glm::angleAxis(angle, step / angle));
}

float aheadFor(float wantedS) {
    return wantedS > 0 ? kLongestAheadS * (1 - std::exp(-wantedS / kLongestAheadS)) : 0.0f;
}

template <class T>
void OneEuro<T>::start(const T& value) {
    value_ = raw_ = value;
    velocity_ = rawVelocity_ = lastStep_ = Vec3f(0);
    delayS_ = 0;
    count_ = 0;
}

template <class T>
void OneEuro<T>::learnNoise(const Vec3f& step) {
    const float length = glm::length(step - lastStep_);
    lastStep_ = step;
    if (++count_ < 2) return;
    if (second_ <= 0)
        second_ = length;
    else  // a quartile, as motion makes second differences larger and never smaller
        second_ *= length > second_ ? 1 + 0.25f * kLearnRate : 1 - 0.75f * kLearnRate;
    noise_ = second_ / (kQuartile * kSecondGain);
}

template <class T>
void OneEuro<T>::add(const T& value, float stepS, const FilterLimits& limits) {
    const Vec3f step = stepBetween(raw_, value);
    raw_ = value;
    learnNoise(step);
    const float speedShare = shareOf(kSpeedCutoffHz, stepS);
    rawVelocity_ += speedShare * (step / stepS - rawVelocity_);
    // White noise of standard deviation s leaves s·√(a/(2−a)) behind a low-pass of share a. At rest that shall be limits.jitter.
    const float wanted = noise_ > limits.jitter ? limits.jitter * limits.jitter / (noise_ * noise_) : 1.0f;
    const float restShare = std::min(2 * wanted / (1 + wanted), 0.99f);
    const float restHz = std::max(restShare / (1 - restShare) / (kTau * stepS), kSlowestHz);
    // Speed that noise alone feigns: √2·s/step behind the low-pass of the speed, along three axes.
    const float feigned = std::sqrt(3.0f) * noise_ * std::sqrt(2.0f) / stepS * std::sqrt(speedShare / (2 - speedShare));
    const float speed = std::sqrt(std::max(0.0f, glm::dot(rawVelocity_, rawVelocity_) - feigned * feigned));
    const float share = shareOf(restHz + speed / (kTau * limits.lag), stepS);
    const T before = value_;
    value_ = stepped(value_, share * stepBetween(value_, value));
    velocity_ += share * (stepBetween(before, value_) / stepS - velocity_);
    delayS_ = (1 - share) / share * stepS;
}

template class OneEuro<Quatf>;
template class OneEuro<Vec3f>;

}  // namespace dpl
