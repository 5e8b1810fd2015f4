// SPDX-License-Identifier: Apache-2.0
#include "sdk/api/compose.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "sdk/math/half.h"
#include "sdk/math/srgb.h"

namespace dpl::api {
namespace {

/** x / 255, rounded to nearest. There are no ties, because 255 is odd. */
uint8_t nearest255th(uint32_t x) {
    return uint8_t((x + 127) / 255);
}

/** Tables for decoding and encoding sRGB. Computed in double and rounded to float once; 137 KB, made at first use. */
class LinearTables {
public:
    LinearTables() {
        for (uint32_t alpha = 0; alpha < 256; ++alpha)
            for (uint32_t c = 0; c <= alpha; ++c)
                premultiplied_[at(c, alpha)] = alpha == 0 ? 0.0f : float(linearFromSrgb(double(c) / alpha) * alpha / 255);
        for (uint32_t code = 1; code < 256; ++code) threshold_[code] = float(linearFromSrgb((code - 0.5) / 255));
        threshold_[0] = 0, threshold_[256] = std::numeric_limits<float>::infinity();
        for (uint32_t i = 0, code = 0; i <= kSteps; ++i) {
            while (threshold_[code + 1] <= float(i) / kSteps) ++code;
            first_[i] = uint8_t(code);
        }
    }
    /** Premultiplied linear light of a premultiplied display-referred colour. A colour above its alpha counts as white. */
    float premultiplied(uint8_t c, uint8_t alpha) const { return premultiplied_[at(std::min(c, alpha), alpha)]; }
    float decode(uint8_t code) const { return premultiplied_[at(code, 255)]; }
    /** Nearest sRGB code of a linear value ≥ 0. Thresholds are farther apart than 1 / kSteps, so a step holds at most one. */
    uint8_t encode(float linear) const {
        const uint32_t code = first_[uint32_t(std::min(linear, 1.0f) * kSteps)];
        return uint8_t(code + (linear >= threshold_[code + 1] ? 1 : 0));
    }

private:
    static constexpr uint32_t kSteps = 4096;
    static uint32_t at(uint32_t c, uint32_t alpha) { return alpha * (alpha + 1) / 2 + c; }
    float premultiplied_[256 * 257 / 2];
    float threshold_[257];       // smallest linear value whose nearest code is the index
    uint8_t first_[kSteps + 1];  // code at the start of a step
};

const LinearTables& tables() {
    static const LinearTables made;
    return made;
}

void composeDisplay(const uint8_t* in, size_t pixels, const Composition& how, uint8_t* out) {
    if (!how.over && !how.straight) {
        std::memcpy(out, in, pixels * 4);
        return;
    }
    for (size_t i = 0; i < pixels; ++i, in += 4, out += 4) {
        const uint32_t alpha = in[3];
        if (how.over) {
            if (alpha == 0) continue;
            for (int c = 0; c < 4; ++c) out[c] = uint8_t(std::min(255u, in[c] + uint32_t(nearest255th(out[c] * (255 - alpha)))));
        } else {
            for (int c = 0; c < 3; ++c) out[c] = alpha == 0 ? uint8_t(0) : uint8_t(std::min(255u, (in[c] * 255u + alpha / 2) / alpha));
            out[3] = in[3];
        }
    }
}

void composeSrgb(const uint8_t* in, size_t pixels, bool over, uint8_t* out) {
    const LinearTables& t = tables();
    for (size_t i = 0; i < pixels; ++i, in += 4, out += 4) {
        const uint8_t alpha = in[3];
        if (alpha == 0 && over) continue;
        if (alpha == 0 || alpha == 255) {
            std::memcpy(out, in, 4);
            continue;
        }
        const float through = over ? float(255 - alpha) / 255 : 0.0f;
        for (int c = 0; c < 3; ++c) out[c] = t.encode(t.premultiplied(in[c], alpha) + through * t.decode(over ? out[c] : 0));
        out[3] = over ? uint8_t(alpha + nearest255th(out[3] * uint32_t(255 - alpha))) : alpha;
    }
}

void composeHalf(const uint8_t* in, size_t pixels, const Composition& how, uint8_t* out) {
    const LinearTables& t = tables();
    for (size_t i = 0; i < pixels; ++i, in += 4, out += 8) {
        const uint8_t alpha = in[3];
        if (alpha == 0 && how.over) continue;
        float values[4] = {0, 0, 0, float(alpha) / 255};
        for (int c = 0; c < 3; ++c) values[c] = t.premultiplied(in[c], alpha);
        uint16_t halves[4];
        if (how.over && alpha < 255) {
            std::memcpy(halves, out, 8);
            for (int c = 0; c < 4; ++c) values[c] += float(255 - alpha) / 255 * floatFromHalf(halves[c]);
        }
        if (how.straight && alpha > 0)
            for (int c = 0; c < 3; ++c) values[c] = values[c] * 255 / float(alpha);
        for (int c = 0; c < 4; ++c) halves[c] = halfFromFloat(values[c]);
        std::memcpy(out, halves, 8);
    }
}

}  // namespace

void composeRow(const uint8_t* layer, size_t pixels, const Composition& how, uint8_t* target) {
    if (how.format == DPL_FORMAT_RGBA16F)
        composeHalf(layer, pixels, how, target);
    else if (how.format == DPL_FORMAT_RGBA8_SRGB && !how.straight)
        composeSrgb(layer, pixels, how.over, target);
    else
        composeDisplay(layer, pixels, how, target);  // also straight RGBA8_SRGB: without blending, encoding undoes decoding
}

}  // namespace dpl::api
