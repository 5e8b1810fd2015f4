// SPDX-License-Identifier: Apache-2.0
// One smoothed value of a tracked person: a rotation or a place, with the times at which it came.
#pragma once

#include <cstdint>

#include "sdk/motion/one_euro.h"

namespace dpl {

float secondsBetween(int64_t fromNs, int64_t toNs);

/** The times of a stream's frames and of the picture that is made. */
struct StreamClock {
    int64_t lastNs = 0;     // of the last frame
    bool any = false;       // a frame was taken since the stream began
    float stepS = 0;        // usual time between frames; 0: not known
    int64_t pictureNs = 0;  // of the picture that is made
    bool raw = false;       // neither smoothed nor extrapolated

    /** Whether news of that time still holds in the picture. */
    bool holds(int64_t newsNs) const;
};

template <class T>
class TrackChannel {
public:
    /** Takes the value of the frame at clock.lastNs. After a gap or a jump that no body can make, or if it shall begin anew, it has another
     *  driver. */
    void feed(const StreamClock& clock, const T& value, bool anew = false);
    /** The stream has another clock: the value stays until the next one. */
    void restart() { lastNs_ = 0, filter_.start(filter_.value()); }

    bool isFresh(const StreamClock& clock) const { return driver_ != 0 && clock.any && clock.holds(lastNs_); }
    /** The value at clock.pictureNs. aheadS: raised to the time by which it is extrapolated. */
    T sample(const StreamClock& clock, float& aheadS) const;

    uint32_t driver() const { return driver_; }  // counts how often it was acquired; 0: never
    const OneEuro<T>& filter() const { return filter_; }

private:
    OneEuro<T> filter_;
    int64_t lastNs_ = 0;
    uint32_t driver_ = 0;
};

extern template class TrackChannel<Quatf>;
extern template class TrackChannel<Vec3f>;

}  // namespace dpl
