// SPDX-License-Identifier: Apache-2.0
// For first programs and debugging: a picture in memory, what stands on a floor in it, and files. Not a part of what apps need; like
// doppel_png.h it may change in a minor version. Header only.
//
//   auto context = doppel::orExit(doppel::Context::create());
//   auto avatar = doppel::orExit(context.loadAvatarFile("avatar.glb"));
//   doppel::Picture picture(512, 768);
//   doppel::orExit(avatar.render(doppel::orExit(picture.camera({.eye = {0, 1, 3}, .target = {0, 1, 0}})), picture.image()));
//   doppel::orExit(picture.write("avatar.png"));
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <doppel/doppel_png.h>
#include <doppel/doppel.hpp>

namespace doppel {

/** The value, or the error's sentence on stderr and the end of the program with exit code 1. */
template <class T>
T orExit(Result<T> result) {
    if (result) return std::move(*result);
    std::fprintf(stderr, "%s\n", result.error().message.c_str());
    std::exit(1);
}
/** The same for a Status. */
inline void orExit(const Status& result) {
    if (result) return;
    std::fprintf(stderr, "%s\n", result.error().message.c_str());
    std::exit(1);
}

/** The bytes of a file, such as a clip's. path: as std::fopen takes it. */
inline Result<std::vector<uint8_t>> readFile(const std::string& path) {
    std::FILE* file = std::fopen(path.c_str(), "rb");
    if (!file) return Error{DPL_ERROR_NOT_FOUND, path + " cannot be opened"};
    std::vector<uint8_t> bytes;
    uint8_t block[1 << 14];
    for (size_t got; (got = std::fread(block, 1, sizeof block, file)) > 0;) bytes.insert(bytes.end(), block, block + got);
    const bool failed = std::ferror(file) != 0;
    std::fclose(file);
    if (failed) return Error{DPL_ERROR_IO, path + " cannot be read"};
    return bytes;
}

/** Premultiplied RGBA8 pixels that avatars are drawn over; at first nothing is there. */
class Picture {
public:
    Picture(uint32_t widthPx, uint32_t heightPx) : widthPx_(widthPx), heightPx_(heightPx), rgba_(size_t(widthPx) * heightPx * 4, 0) {
        image_.flags = DPL_IMAGE_OVER, image_.rgba = rgba_.data(), image_.rgbaBytes = rgba_.size();
    }
    Picture(const Picture&) = delete;
    Picture& operator=(const Picture&) = delete;

    /** For render() and readImages(), which draw over what is there. */
    std::span<const DplImage> image() const { return image_; }
    std::span<const uint8_t> rgba() const { return rgba_; }
    /** A camera for this picture; how.widthPx and heightPx are not read. */
    Result<Camera> camera(LookAt how) const {
        how.widthPx = widthPx_, how.heightPx = heightPx_;
        return Camera::lookAt(how);
    }
    /** One colour all over, sRGB. */
    void fill(uint8_t red, uint8_t green, uint8_t blue) {
        for (size_t i = 0; i < rgba_.size(); i += 4) rgba_[i] = red, rgba_[i + 1] = green, rgba_[i + 2] = blue, rgba_[i + 3] = 255;
    }
    /** Darkens the floor below an avatar; before the avatar is drawn. strength: the part of the floor's light that it may take. */
    void drawShadow(const ContactShadow& shadow, const Camera& camera, float strength = 0.7f) {
        const float *m = camera.viewFromWorld, *u = shadow.across, *v = shadow.along;
        const float up[3] = {v[1] * u[2] - v[2] * u[1], v[2] * u[0] - v[0] * u[2], v[0] * u[1] - v[1] * u[0]};
        float toCorner[3];  // from the eye
        for (int k = 0; k < 3; ++k) toCorner[k] = shadow.corner[k] + m[k] * m[3] + m[4 + k] * m[7] + m[8 + k] * m[11];
        const float side2 = dot(u, u), height = dot(up, toCorner);
        for (uint32_t y = 0; y < heightPx_ && shadow.darkest > 0; ++y)
            for (uint32_t x = 0; x < widthPx_; ++x) {
                const float a = (float(x) + 0.5f - camera.cx) / camera.fx, b = (float(y) + 0.5f - camera.cy) / camera.fy;
                float ray[3], at[3];
                for (int k = 0; k < 3; ++k) ray[k] = m[k] * a + m[4 + k] * b + m[8 + k];
                const float distance = height / dot(up, ray);
                if (!(distance > 0)) continue;
                for (int k = 0; k < 3; ++k) at[k] = distance * ray[k] - toCorner[k];
                const float left = 1 - strength * alphaAt(shadow, dot(at, u) / side2, dot(at, v) / side2);
                uint8_t* pixel = &rgba_[4 * (size_t(y) * widthPx_ + x)];
                for (int k = 0; k < 3; ++k) pixel[k] = uint8_t(float(pixel[k]) * left + 0.5f);
                pixel[3] = uint8_t(255 - (255 - float(pixel[3])) * left + 0.5f);
            }
    }
    /** Writes a PNG file, with straight alpha as PNG has it. */
    Status write(const std::string& path) const {
        std::vector<uint8_t> straight = rgba_;
        for (size_t i = 0; i < straight.size(); i += 4)
            for (size_t k = 0; k < 3 && straight[i + 3] > 0; ++k)
                straight[i + k] = uint8_t(std::min(255u, (255u * straight[i + k] + straight[i + 3] / 2u) / straight[i + 3]));
        const DplResult r = dplWritePng(path.c_str(), straight.data(), widthPx_, heightPx_);
        if (r == DPL_OK) return {};
        return Error{r, path + " cannot be written: " + std::strerror(errno)};
    }

private:
    static float dot(const float* a, const float* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
    /** Between the centres of pixels, 0 to 1; u and v go from 0 to 1 over the picture. */
    static float alphaAt(const ContactShadow& shadow, float u, float v) {
        constexpr float n = DPL_CONTACT_SHADOW_PX;
        if (!(u > 0 && u < 1 && v > 0 && v < 1)) return 0;
        const float x = std::clamp(u * n - 0.5f, 0.0f, n - 1.001f), y = std::clamp(v * n - 0.5f, 0.0f, n - 1.001f);
        const uint8_t* at = &shadow.alpha[size_t(y) * DPL_CONTACT_SHADOW_PX + size_t(x)];
        const float fx = x - std::floor(x), fy = y - std::floor(y);
        const float top = float(at[0]) * (1 - fx) + float(at[1]) * fx;
        const float bottom = float(at[DPL_CONTACT_SHADOW_PX]) * (1 - fx) + float(at[DPL_CONTACT_SHADOW_PX + 1]) * fx;
        return (top * (1 - fy) + bottom * fy) / 255;
    }

    uint32_t widthPx_, heightPx_;
    std::vector<uint8_t> rgba_;
    Image image_;
};

}  // namespace doppel
