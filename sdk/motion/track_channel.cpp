// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/track_channel.h"

#include <algorithm>
#include <type_traits>

namespace dpl {
namespace {

constexpr double kNsPerS = 1e9;
constexpr int64_t kHoldNs = 300'000'000;
constexpr float kLeastGapS = 0.1f, kGapSteps = 3;  // a longer pause, or more missing frames, is a gap

/** Of rotations in radians, of places in metres. */
template <class T>
struct Bounds {
    static constexpr bool kTurns = std::is_same_v<T, Quatf>;
    static constexpr FilterLimits kLimits = kTurns ? kRotationLimits : kPlaceLimits;
    static constexpr float kFastest = kTurns ? 50.0f : 15.0f;  // a second; no joint turns and no person moves as fast: the stream jumped
    static constexpr float kJump = kTurns ? 0.6f : 0.3f;
};

}  // namespace

float secondsBetween(int64_t fromNs, int64_t toNs) {
    return float((double(toNs) - double(fromNs)) / kNsPerS);  // in double first: int64 would overflow
}

bool StreamClock::holds(int64_t newsNs) const {
    return double(pictureNs) - double(newsNs) <= double(kHoldNs);
}

template <class T>
void TrackChannel<T>::feed(const StreamClock& clock, const T& value, bool anew) {
    const float stepS = secondsBetween(lastNs_, clock.lastNs);
    const float gapS = std::max(kLeastGapS, kGapSteps * clock.stepS);
    const bool fresh = driver_ != 0 && stepS > 0 && stepS <= gapS;
    const float way = fresh ? glm::length(stepBetween(filter_.value(), value)) : 0.0f;
    const bool jumped = way > Bounds<T>::kJump && way > Bounds<T>::kFastest * stepS;
    if (!fresh || jumped || anew) {
        filter_.start(value);
        ++driver_;
    } else if (clock.raw) {
        filter_.set(value);
    } else {
        filter_.add(value, stepS, Bounds<T>::kLimits);
    }
    lastNs_ = clock.lastNs;
}

template <class T>
T TrackChannel<T>::sample(const StreamClock& clock, float& aheadS) const {
    if (clock.raw) return filter_.value();
    const float ahead = aheadFor(secondsBetween(lastNs_, clock.pictureNs) + filter_.delayS());
    aheadS = std::max(aheadS, ahead);
    return filter_.after(ahead, Bounds<T>::kFastest);
}

template class TrackChannel<Quatf>;
template class TrackChannel<Vec3f>;

}  // namespace dpl
