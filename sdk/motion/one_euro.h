// SPDX-License-Identifier: Apache-2.0
// One-Euro filter (Casiez, Roussel and Vogel 2012) of a rotation or a place, whose constants follow from the stream. It also extrapolates.
// Formulas: docs/reference/driving.md.
#pragma once

#include <algorithm>

#include "sdk/math/types.h"

namespace dpl {

/** The turn or way from `from` to `to`, in the frame of `from`. */
Vec3f stepBetween(const Quatf& from, const Quatf& to);
inline Vec3f stepBetween(const Vec3f& from, const Vec3f& to) {
    return to - from;
}
Quatf stepped(const Quatf& from, const Vec3f& step);
inline Vec3f stepped(const Vec3f& from, const Vec3f& step) {
    return from + step;
}

/** What the filter may do, in the unit of the values: radians or metres. */
struct FilterLimits {
    float jitter = 0;  // standard deviation about one axis that may remain at rest
    float lag = 0;     // by which fast motion may lag behind
};
constexpr FilterLimits kRotationLimits{0.0026f, 0.035f};  // 0.15 and 2 degrees
constexpr FilterLimits kPlaceLimits{0.001f, 0.01f};

constexpr float kLongestAheadS = 0.05f;

/** By how much to extrapolate for a picture that is `wantedS` later: almost all of a short time, never more than kLongestAheadS. */
float aheadFor(float wantedS);

template <class T>
class OneEuro {
public:
    /** Starts anew at a value, at rest. What was learnt of the noise stays. */
    void start(const T& value);
    /** Takes the next value, stepS after the one before, > 0. */
    void add(const T& value, float stepS, const FilterLimits& limits);
    /** Takes a value as it is. */
    void set(const T& value) { start(value); }

    const T& value() const { return value_; }
    /** The value `aheadS` later, if the motion goes on, by no more than `fastest` per second: frames may lie a nanosecond apart. */
    T after(float aheadS, float fastest) const {
        const float share = std::min(1.0f, fastest / std::max(speed(), 1e-6f));
        return stepped(value_, velocity_ * (share * aheadS));
    }
    float noise() const { return noise_; }  // standard deviation about one axis; 0: not known
    float speed() const { return glm::length(velocity_); }
    float delayS() const { return delayS_; }  // of slow motion, at the current cut-off

private:
    void learnNoise(const Vec3f& step);

    T value_{}, raw_{};
    Vec3f velocity_{0}, rawVelocity_{0}, lastStep_{0};
    float second_ = 0, noise_ = 0, delayS_ = 0;  // second_: quartile of second differences
    int count_ = 0;
};

extern template class OneEuro<Quatf>;
extern template class OneEuro<Vec3f>;

}  // namespace dpl
