// SPDX-License-Identifier: Apache-2.0
// The referee of composition: what a picture over an app's target must give, in double precision, from the formulas of DplImageFormat. It
// judges the CPU's composition (tests/unit/api) and the GPU's (tests/unit/interop), in all formats of targets and with several samples a
// pixel, and the depth that is written beside it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

#include "sdk/math/half.h"

namespace dpl::reference {

enum class TargetFormat : uint8_t { Rgba8, Bgra8, Rgba8Srgb, Bgra8Srgb, Rgba16f, A2b10g10r10 };

/** Red, green, blue and alpha as stored: a code over the largest code, or the value of a half. */
using StoredPixel = std::array<double, 4>;

constexpr size_t bytesOf(TargetFormat format) {
    return format == TargetFormat::Rgba16f ? 8 : 4;
}
constexpr bool isSrgb(TargetFormat format) {
    return format == TargetFormat::Rgba8Srgb || format == TargetFormat::Bgra8Srgb;
}
/** Whether light is blended, rather than display-referred values. */
constexpr bool isLinear(TargetFormat format) {
    return isSrgb(format) || format == TargetFormat::Rgba16f;
}
/** Byte of a channel in formats of four bytes; tells RGBA from BGRA. */
constexpr size_t byteOf(TargetFormat format, size_t channel) {
    const bool swapped = format == TargetFormat::Bgra8 || format == TargetFormat::Bgra8Srgb;
    return swapped && channel < 3 ? 2 - channel : channel;
}

inline double decodeSrgb(double v) {
    return v > 0.04045 ? std::exp(2.4 * std::log((v + 0.055) / 1.055)) : v / 12.92;
}
inline double encodeSrgb(double v) {
    return v > 0.0031308 ? 1.055 * std::exp(std::log(v) / 2.4) - 0.055 : v * 12.92;
}

inline StoredPixel unpack(TargetFormat format, const uint8_t* from) {
    StoredPixel pixel{};
    uint16_t halves[4];
    uint32_t word;
    switch (format) {
        case TargetFormat::Rgba16f:
            std::memcpy(halves, from, 8);
            for (size_t c = 0; c < 4; ++c) pixel[c] = double(floatFromHalf(halves[c]));
            break;
        case TargetFormat::A2b10g10r10:
            std::memcpy(&word, from, 4);
            for (size_t c = 0; c < 3; ++c) pixel[c] = double(word >> 10 * c & 1023) / 1023;
            pixel[3] = double(word >> 30) / 3;
            break;
        default:
            for (size_t c = 0; c < 4; ++c) pixel[c] = from[byteOf(format, c)] / 255.0;
    }
    return pixel;
}

/** Rounds to the nearest code. */
inline void pack(TargetFormat format, const StoredPixel& pixel, uint8_t* to) {
    const auto code = [](double value, double largest) { return uint32_t(std::lround(std::clamp(value, 0.0, 1.0) * largest)); };
    uint16_t halves[4];
    uint32_t word = code(pixel[3], 3) << 30;
    switch (format) {
        case TargetFormat::Rgba16f:
            for (size_t c = 0; c < 4; ++c) halves[c] = halfFromFloat(float(pixel[c]));
            std::memcpy(to, halves, 8);
            break;
        case TargetFormat::A2b10g10r10:
            for (size_t c = 0; c < 3; ++c) word |= code(pixel[c], 1023) << 10 * c;
            std::memcpy(to, &word, 4);
            break;
        default:
            for (size_t c = 0; c < 4; ++c) to[byteOf(format, c)] = uint8_t(code(pixel[c], 255));
    }
}

/** A premultiplied, display-referred pixel of a layer over a stored one, before it is rounded. */
inline StoredPixel over(TargetFormat format, const StoredPixel& layer, const StoredPixel& stored) {
    const double alpha = layer[3], through = 1 - alpha;
    StoredPixel out;
    for (size_t c = 0; c < 4; ++c) {
        const bool light = c < 3 && isLinear(format), encoded = c < 3 && isSrgb(format);
        const double value = layer[c];
        out[c] = !light ? value : alpha > 0 ? alpha * decodeSrgb(std::min(1.0, value / alpha)) : 0;
        if (through > 0) out[c] += through * (encoded ? decodeSrgb(stored[c]) : stored[c]);  // what is hidden may be infinite
        if (encoded) out[c] = encodeSrgb(out[c]);
    }
    return out;
}

/** The same for an RGBA8 pixel. */
inline StoredPixel over(TargetFormat format, const uint8_t* layer, const StoredPixel& stored) {
    return over(format, unpack(TargetFormat::Rgba8, layer), stored);
}

/** The least and the most that an RGBA8 pixel over a stored one may give if each of its codes may be off by `codes`. Colours only. */
inline std::pair<StoredPixel, StoredPixel> overWithin(TargetFormat format, const uint8_t* layer, const StoredPixel& stored, double codes) {
    StoredPixel low = unpack(TargetFormat::Rgba8, layer), high = low;
    for (size_t c = 0; c < 4; ++c) {
        const double change = c < 3 ? codes / 255 : -codes / 255;  // more alpha hides more of what is stored
        low[c] = std::clamp(low[c] - change, 0.0, 1.0), high[c] = std::clamp(high[c] + change, 0.0, 1.0);
    }
    return {over(format, low, stored), over(format, high, stored)};
}

/** Composes a layer over the pixels of a target. */
inline void compose(TargetFormat format, std::span<const uint8_t> layer, std::span<uint8_t> target) {
    const size_t bytes = bytesOf(format);
    for (size_t pixel = 0; pixel < layer.size() / 4; ++pixel)
        if (uint8_t* at = target.data() + pixel * bytes; layer[4 * pixel + 3] > 0)
            pack(format, over(format, &layer[4 * pixel], unpack(format, at)), at);
}

/** How an app stores depth: scale + offset / z. */
struct StoredDepth {
    double scale = 0, offset = 0;
    double of(double z) const { return std::clamp(scale + offset / z, 0.0, 1.0); }
    bool nearer(double a, double b) const { return offset > 0 ? a > b : a < b; }
};

/** Writes a picture's depth into each sample that it covers and that stores something farther. depthM: view z of each pixel, metres; 0:
 *  none. stored: before it is rounded to the format. */
inline void composeDepth(std::span<const uint8_t> layer, std::span<const float> depthM, const StoredDepth& how, uint32_t samples,
                         std::span<double> stored) {
    for (size_t pixel = 0; pixel < depthM.size(); ++pixel) {
        if (layer[4 * pixel + 3] < 128 || !(depthM[pixel] > 0)) continue;
        const double depth = how.of(double(depthM[pixel]));
        for (size_t s = 0; s < samples; ++s)
            if (double& old = stored[pixel * samples + s]; how.nearer(depth, old)) old = depth;
    }
}

/** Of stored values, of the first `channels` of a pixel: 3 leaves out alpha, for pictures that are opaque everywhere. */
inline double psnrDb(TargetFormat format, std::span<const uint8_t> a, std::span<const uint8_t> b, size_t channels) {
    const size_t pixels = std::min(a.size(), b.size()) / bytesOf(format);
    double sum = a.size() == b.size() ? 0 : INFINITY;
    for (size_t i = 0; i < pixels; ++i) {
        const StoredPixel x = unpack(format, &a[i * bytesOf(format)]), y = unpack(format, &b[i * bytesOf(format)]);
        for (size_t c = 0; c < channels; ++c) sum += (x[c] - y[c]) * (x[c] - y[c]);
    }
    return 10 * std::log10(double(pixels * channels) / std::max(sum, 1e-12));
}
inline double psnrDb(TargetFormat format, std::span<const uint8_t> a, std::span<const uint8_t> b) {
    return psnrDb(format, a, b, format == TargetFormat::A2b10g10r10 ? 3 : 4);  // its alpha has two bits
}

}  // namespace dpl::reference
