// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/score.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "reconstruction/input/capture/frame_picture.h"
#include "reconstruction/judging/report/picture_error.h"
#include "reconstruction/subject/surface/lone_parts.h"
#include "reconstruction/subject/surface/mesh_raster.h"

namespace dpl {
namespace {

/** colour·alpha + background·(1 − alpha), three float channels in [0, 1]. */
cv::Mat composite(const std::vector<uint8_t>& rgba, int width, int height, float background) {
    cv::Mat out(height, width, CV_32FC3);
    float* to = out.ptr<float>();
    for (size_t i = 0; i < size_t(width) * size_t(height); ++i) {
        const float alpha = float(rgba[i * 4 + 3]) / 255.0f;
        for (int c = 0; c < 3; ++c) to[i * 3 + c] = float(rgba[i * 4 + c]) / 255.0f * alpha + background * (1 - alpha);
    }
    return out;
}

}  // namespace

FrameScore scorePicture(const std::vector<uint8_t>& rgba, const std::vector<uint8_t>& truthRgba, uint32_t widthPx, uint32_t heightPx) {
    FrameScore score;
    const int width = int(widthPx), height = int(heightPx);
    const size_t pixels = size_t(widthPx) * heightPx;
    if (pixels == 0 || rgba.size() != pixels * 4 || truthRgba.size() != pixels * 4) return score;
    const auto isPersonAt = [&](size_t i) { return truthRgba[i * 4 + 3] >= 128; };
    const auto isDrawnAt = [&](size_t i) { return rgba[i * 4 + 3] >= 128; };
    size_t inside = 0, both = 0, either = 0;
    std::vector<uint8_t> shown(pixels), persons(pixels);
    for (size_t i = 0; i < pixels; ++i) {
        const bool person = isPersonAt(i), drawn = isDrawnAt(i);
        inside += person, both += person && drawn, either += person || drawn;
        shown[i] = rgba[i * 4 + 3] >= kShownAlpha, persons[i] = person;
    }
    if (inside == 0) return score;
    const std::vector<uint8_t> lone = loneParts(shown, persons, widthPx, heightPx);
    score.lonePx = double(std::count(lone.begin(), lone.end(), uint8_t(1)));
    score.alphaIou = double(both) / double(either);
    score.coverage = double(inside) / double(pixels);
    score.uncovered = double(inside - both) / double(inside);
    score.drawnOutside = double(either - inside) / double(inside);
    score.maskedPsnrDb = score.unionPsnrDb = kEqualPsnrDb;
    score.maskedSsim = score.unionSsim = 1;
    for (float background : {1.0f, 0.0f, 0.5f}) {
        const cv::Mat render = composite(rgba, width, height, background), expected = composite(truthRgba, width, height, background);
        const cv::Mat ssim = ssimMap(render, expected);
        const float *a = render.ptr<float>(), *b = expected.ptr<float>(), *s = ssim.ptr<float>();
        double maskedSquares = 0, maskedSsim = 0, unionSquares = 0, unionSsim = 0, squares = 0, wholeSsim = 0;
        for (size_t i = 0; i < pixels; ++i) {
            double square = 0;
            for (int c = 0; c < 3; ++c) square += (double(a[i * 3 + c]) - b[i * 3 + c]) * (double(a[i * 3 + c]) - b[i * 3 + c]);
            squares += square, wholeSsim += s[i];
            if (isPersonAt(i)) maskedSquares += square, maskedSsim += s[i];
            if (isPersonAt(i) || isDrawnAt(i)) unionSquares += square, unionSsim += s[i];
        }
        score.maskedPsnrDb = std::min(score.maskedPsnrDb, psnrDb(maskedSquares / (3.0 * double(inside))));
        score.maskedSsim = std::min(score.maskedSsim, maskedSsim / double(inside));
        score.unionPsnrDb = std::min(score.unionPsnrDb, psnrDb(unionSquares / (3.0 * double(either))));
        score.unionSsim = std::min(score.unionSsim, unionSsim / double(either));
        if (background == 1.0f) score.fullPsnrDb = psnrDb(squares / (3.0 * double(pixels))), score.fullSsim = wholeSsim / double(pixels);
    }
    return score;
}

FrameScore scorePicture(const std::vector<uint8_t>& rgba, const ImageRgb8& truth, const ImageGrey8& mask) {
    return scorePicture(rgba, cutOut(truth, mask), truth.widthPx, truth.heightPx);
}

std::vector<uint8_t> cutOut(const ImageRgb8& image, const ImageGrey8& mask) {
    std::vector<uint8_t> rgba;
    if (image.pixels.size() != mask.pixels.size() * 3) return rgba;
    rgba.reserve(mask.pixels.size() * 4);
    for (size_t i = 0; i < mask.pixels.size(); ++i)
        rgba.insert(rgba.end(),
                    {image.pixels[i * 3], image.pixels[i * 3 + 1], image.pixels[i * 3 + 2], uint8_t(isPerson(mask.pixels[i]) ? 255 : 0)});
    return rgba;
}

void LabelColours::add(const ImageRgb8& image, const ImageGrey8& mask, const ImageGrey8& labels) {
    for (size_t i = 0; i < mask.pixels.size() && i < labels.pixels.size(); ++i) {
        if (!isPerson(mask.pixels[i])) continue;
        Sum& sum = sums_[labels.pixels[i]];
        for (int c = 0; c < 3; ++c) sum.rgb[c] += image.pixels[i * 3 + c];
        sum.count += 1;
    }
}

std::vector<uint8_t> LabelColours::paint(const ImageGrey8& mask, const ImageGrey8& labels) const {
    std::vector<uint8_t> rgba(mask.pixels.size() * 4, 0);
    for (size_t i = 0; i < mask.pixels.size(); ++i) {
        if (!isPerson(mask.pixels[i])) continue;
        const auto found = sums_.find(i < labels.pixels.size() ? labels.pixels[i] : uint8_t(0));
        for (int c = 0; c < 3; ++c)
            rgba[i * 4 + c] = found == sums_.end() ? 128 : uint8_t(found->second.rgb[c] / found->second.count + 0.5);
        rgba[i * 4 + 3] = 255;
    }
    return rgba;
}

std::vector<uint8_t> paintMesh(std::span<const Vec3f> positions, std::span<const Triangle> triangles, std::span<const glm::u8vec4> colours,
                               const Camerad& camera) {
    const MeshRaster raster = rasteriseMesh(positions, triangles, camera);
    std::vector<uint8_t> rgba(raster.triangle.size() * 4, 0);
    for (size_t i = 0; i < raster.triangle.size(); ++i) {
        if (raster.triangle[i] == kNoTriangle) continue;
        const Triangle& t = triangles[raster.triangle[i]];
        const Vec2f uv = raster.barycentric[i];
        const Vec4f colour = (1 - uv.x - uv.y) * Vec4f(colours[t.x]) + uv.x * Vec4f(colours[t.y]) + uv.y * Vec4f(colours[t.z]);
        for (int c = 0; c < 3; ++c) rgba[i * 4 + c] = uint8_t(colour[c] + 0.5f);
        rgba[i * 4 + 3] = 255;
    }
    return rgba;
}

std::vector<uint8_t> areaAveraged(const std::vector<uint8_t>& rgba, uint32_t widthPx, uint32_t heightPx, uint32_t toWidthPx,
                                  uint32_t toHeightPx) {
    cv::Mat weighted(int(heightPx), int(widthPx), CV_32FC4), small;
    float* to = weighted.ptr<float>();
    for (size_t i = 0; i < size_t(widthPx) * heightPx; ++i) {
        const float alpha = float(rgba[i * 4 + 3]) / 255.0f;
        for (int c = 0; c < 3; ++c) to[i * 4 + size_t(c)] = float(rgba[i * 4 + size_t(c)]) * alpha;
        to[i * 4 + 3] = alpha;
    }
    cv::resize(weighted, small, cv::Size(int(toWidthPx), int(toHeightPx)), 0, 0, cv::INTER_AREA);
    std::vector<uint8_t> out(size_t(toWidthPx) * toHeightPx * 4, 0);
    const float* from = small.ptr<float>();
    for (size_t i = 0; i < out.size() / 4; ++i) {
        const float alpha = from[i * 4 + 3];
        for (size_t c = 0; c < 3 && alpha > 0; ++c) out[i * 4 + c] = uint8_t(std::clamp(from[i * 4 + c] / alpha + 0.5f, 0.0f, 255.0f));
        out[i * 4 + 3] = uint8_t(std::clamp(alpha * 255.0f + 0.5f, 0.0f, 255.0f));
    }
    return out;
}

std::vector<uint8_t> insideOutline(const std::vector<uint8_t>& rgba, uint32_t widthPx, uint32_t heightPx) {
    std::vector<uint8_t> out = rgba;
    const int w = int(widthPx), h = int(heightPx);
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
            bool whole = x > 0 && y > 0 && x + 1 < w && y + 1 < h;
            for (int dy = -1; dy <= 1 && whole; ++dy)
                for (int dx = -1; dx <= 1; ++dx) whole = whole && rgba[4 * (size_t(y + dy) * size_t(w) + size_t(x + dx)) + 3] == 255;
            if (!whole) out[4 * (size_t(y) * size_t(w) + size_t(x)) + 3] = 0;
        }
    return out;
}

std::vector<uint8_t> overWhite(const std::vector<uint8_t>& rgba) {
    std::vector<uint8_t> rgb(rgba.size() / 4 * 3);
    for (size_t i = 0; i < rgba.size() / 4; ++i)
        for (int c = 0; c < 3; ++c) {
            const float alpha = float(rgba[i * 4 + 3]) / 255.0f;
            rgb[i * 3 + c] = uint8_t(float(rgba[i * 4 + c]) * alpha + 255.0f * (1 - alpha) + 0.5f);
        }
    return rgb;
}

std::vector<uint8_t> differenceTimesFour(const std::vector<uint8_t>& rgb, const std::vector<uint8_t>& truthRgb) {
    std::vector<uint8_t> out(rgb.size());
    for (size_t i = 0; i < rgb.size(); ++i) out[i] = uint8_t(std::min(255, 4 * std::abs(int(rgb[i]) - int(truthRgb[i]))));
    return out;
}

}  // namespace dpl
