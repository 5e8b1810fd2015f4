// SPDX-License-Identifier: Apache-2.0
// What a picture states of its colours, and the way from there to sRGB. Reads ICC profiles of curves and a matrix (ICC.1:2022, 8.3, 9.2,
// 10.6, 10.18), which cameras, phones and editors write for RGB and grey. Private to the picture codec.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "sdk/core/result.h"

namespace dpl {

/** Maps 8-bit RGB of one colour space to 8-bit sRGB. */
class ToSrgb {
public:
    /** linear: light of each stored value, a curve a channel. xyz: columns are the XYZ (D50) of the three primaries. */
    ToSrgb(const std::array<std::array<double, 256>, 3>& linear, const std::array<std::array<double, 3>, 3>& xyz);

    /** Whether no colour changes by more than kSameLevels: the space is sRGB, whatever its name. */
    bool isSrgb() const;
    /** pixels: `channels` bytes each, of which the first three are RGB; alpha is left. */
    void apply(std::span<uint8_t> pixels, uint32_t channels) const;

private:
    std::array<uint8_t, 3> map(const uint8_t* rgb) const;
    std::array<std::array<float, 256>, 3> linear_;
    std::array<std::array<float, 3>, 3> srgbFromLinear_;  // rows
};

struct ColourSpace {
    std::string name;              // for people, "Display P3"
    std::optional<ToSrgb> toSrgb;  // nothing: it is sRGB, or tables alone describe it, which are not read
    bool known = true;             // false: tables alone describe it
};

/** Reads an embedded ICC profile. CorruptData: it is damaged, or of no picture. */
Result<ColourSpace> readColourProfile(std::span<const uint8_t> icc);

/** Display P3, as a PNG's cICP chunk states it without a profile. */
ColourSpace displayP3();

}  // namespace dpl
