// SPDX-License-Identifier: Apache-2.0
// Codes values between the ends of a chunk's range, so that coding a decoded value again gives the same code.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace dpl {

/** Codes 0..top spaced evenly from low to high, in the value or in its logarithm. The ends decode exactly. */
class RangeCode {
public:
    RangeCode(float low, float high, uint32_t top, bool logarithmic) : low_(low), high_(high), top_(top), logarithmic_(logarithmic) {
        from_ = map(low), width_ = map(high) - from_;
    }
    float decode(uint32_t code) const {
        if (code == 0 || !(width_ > 0)) return low_;
        if (code >= top_) return high_;
        const double x = from_ + width_ * code / top_;
        return std::clamp(float(logarithmic_ ? std::exp(x) : x), low_, high_);
    }
    /** The nearest code, moved until nearest(decode(code)) = code. In a range of a few ulps several codes decode to the same value, so
     *  the nearest code may differ from that of the decoded value. nearest∘decode is monotone, so the loop ends. */
    uint32_t encode(float value) const {
        uint32_t code = nearest(value);
        for (uint32_t round = 0; round < top_; ++round) {
            const uint32_t again = nearest(decode(code));
            if (again == code) break;
            code = again;
        }
        return code;
    }

private:
    double map(float v) const { return logarithmic_ ? std::log(double(v)) : double(v); }
    uint32_t nearest(float v) const {
        if (!(width_ > 0) || v <= low_) return 0;
        if (v >= high_) return top_;
        return uint32_t(std::clamp(std::llround((map(v) - from_) / width_ * top_), 0LL, (long long)top_));
    }
    float low_, high_;
    double from_, width_;
    uint32_t top_;
    bool logarithmic_;
};

}  // namespace dpl
