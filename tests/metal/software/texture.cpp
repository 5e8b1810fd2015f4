// SPDX-License-Identifier: Apache-2.0
#include "tests/metal/software/texture.h"

#include <algorithm>
#include <cmath>
#include <glm/packing.hpp>

namespace dpl::mtl {
namespace {

float linearFromSrgb(float v) {
    return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}
float srgbFromLinear(float v) {
    return v <= 0.0031308f ? v * 12.92f : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
}
bool isSrgb(PixelFormat format) {
    return format == PixelFormat::RGBA8UnormSrgb || format == PixelFormat::BGRA8UnormSrgb;
}
bool isBgra(PixelFormat format) {
    return format == PixelFormat::BGRA8Unorm || format == PixelFormat::BGRA8UnormSrgb;
}
uint32_t code(float v, float most) {
    return uint32_t(std::floor(std::clamp(v, 0.0f, 1.0f) * most + 0.5f));  // NaN: clamp keeps it, and Metal gives 0
}

}  // namespace

bool isDepth(PixelFormat format) {
    return format == PixelFormat::Depth16Unorm || format == PixelFormat::Depth32Float || format == PixelFormat::Depth24UnormStencil8 ||
           format == PixelFormat::Depth32FloatStencil8;
}

uint32_t texelBytes(PixelFormat format) {
    switch (format) {
        case PixelFormat::RG32Float:
        case PixelFormat::RGBA16Float:
            return 8;
        case PixelFormat::RG16Float:
        case PixelFormat::RGBA8Unorm:
        case PixelFormat::RGBA8UnormSrgb:
        case PixelFormat::BGRA8Unorm:
        case PixelFormat::BGRA8UnormSrgb:
        case PixelFormat::RGB10A2Unorm:
            return 4;
        default:
            return isDepth(format) ? 4 : 0;
    }
}

Pixels::Pixels(const TextureDesc& desc) : format_(desc.format), texelBytes_(texelBytes(desc.format)) {
    widthPx = desc.widthPx, heightPx = desc.heightPx, layers = desc.layers, samples = desc.samples;
    data_.resize(size_t(widthPx) * heightPx * layers * samples * texelBytes_);
    for (uint32_t layer = 0; layer < layers; ++layer) spoil(layer);
}

glm::vec4 Pixels::texel(uint32_t x, uint32_t y, uint32_t layer, uint32_t sample) const {
    const std::byte* from = at(x, y, layer, sample);
    if (isDepth(format_) || format_ == PixelFormat::RG32Float) {
        float values[2] = {0, 0};
        std::memcpy(values, from, texelBytes_);
        return {values[0], values[1], 0, 1};
    }
    uint32_t words[2] = {0, 0};
    std::memcpy(words, from, texelBytes_);
    if (format_ == PixelFormat::RG16Float) return {glm::unpackHalf2x16(words[0]), 0, 1};
    if (format_ == PixelFormat::RGBA16Float) return {glm::unpackHalf2x16(words[0]), glm::unpackHalf2x16(words[1])};
    if (format_ == PixelFormat::RGB10A2Unorm)
        return {float(words[0] & 1023) / 1023, float(words[0] >> 10 & 1023) / 1023, float(words[0] >> 20 & 1023) / 1023,
                float(words[0] >> 30) / 3};
    glm::vec4 value = glm::unpackUnorm4x8(words[0]);
    if (isBgra(format_)) std::swap(value.r, value.b);
    if (isSrgb(format_)) value = {linearFromSrgb(value.r), linearFromSrgb(value.g), linearFromSrgb(value.b), value.a};
    return value;
}

void Pixels::store(uint32_t x, uint32_t y, uint32_t layer, uint32_t sample, glm::vec4 value) {
    std::byte* to = const_cast<std::byte*>(at(x, y, layer, sample));
    if (isDepth(format_)) {
        float depth = value.r;
        if (format_ == PixelFormat::Depth16Unorm) depth = float(code(depth, 65535)) / 65535;
        if (format_ == PixelFormat::Depth24UnormStencil8)
            depth = float(double(std::llround(double(std::clamp(depth, 0.0f, 1.0f)) * 16777215)) / 16777215);
        std::memcpy(to, &depth, 4);
        return;
    }
    if (format_ == PixelFormat::RG32Float) {
        std::memcpy(to, &value, 8);
        return;
    }
    uint32_t words[2] = {0, 0};
    if (format_ == PixelFormat::RG16Float || format_ == PixelFormat::RGBA16Float) {
        words[0] = glm::packHalf2x16({value.x, value.y}), words[1] = glm::packHalf2x16({value.z, value.w});
    } else if (format_ == PixelFormat::RGB10A2Unorm) {
        words[0] = code(value.r, 1023) | code(value.g, 1023) << 10 | code(value.b, 1023) << 20 | code(value.a, 3) << 30;
    } else {
        if (isSrgb(format_)) value = {srgbFromLinear(value.r), srgbFromLinear(value.g), srgbFromLinear(value.b), value.a};
        if (isBgra(format_)) std::swap(value.r, value.b);
        words[0] = code(value.r, 255) | code(value.g, 255) << 8 | code(value.b, 255) << 16 | code(value.a, 255) << 24;
    }
    std::memcpy(to, words, texelBytes_);
}

void Pixels::clear(uint32_t layer, glm::vec4 value) {
    for (uint32_t y = 0; y < heightPx; ++y)
        for (uint32_t x = 0; x < widthPx; ++x)
            for (uint32_t s = 0; s < samples; ++s) store(x, y, layer, s, value);
}

void Pixels::spoil(uint32_t layer) {
    clear(layer, isDepth(format_) ? glm::vec4(0.77f) : glm::vec4(0.9f, 0.1f, 0.8f, 0.3f));
}

void Pixels::resolve(uint32_t layer, Pixels& to, uint32_t toLayer) const {
    for (uint32_t y = 0; y < heightPx; ++y)
        for (uint32_t x = 0; x < widthPx; ++x) {
            glm::vec4 sum(0);
            for (uint32_t s = 0; s < samples; ++s) sum += texel(x, y, layer, s);
            to.store(x, y, toLayer, 0, sum / float(samples));
        }
}

}  // namespace dpl::mtl
