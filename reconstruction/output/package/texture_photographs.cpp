// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/texture_photographs.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "reconstruction/subject/surface/mesh_raster.h"
#include "sdk/avatar/posed_mesh.h"
#include "sdk/core/task.h"
#include "sdk/math/half.h"

namespace dpl {
namespace {

constexpr uint32_t kSamples = 3;                  // of the mesh a pixel, along each axis
constexpr float kCoarsePx = 4;                    // standard deviation of what does not count as detail
constexpr int kEdgePx = 2;                        // from the edge of the mask and of the mesh, and from an outline within it
constexpr float kJumpM = 0.015f;                  // of the depth at an outline
constexpr float kPhotographDepthErrorM = 0.004f;  // of a depth beside the sample
constexpr uint8_t kInsideMask = 250;
constexpr size_t kBest = 5;           // photographs that a texel takes its mean of
constexpr float kLeastShare = 0.15f;  // of the weight of the best of them
constexpr float kSpread = 0.05f;      // of their colours; further away counts less
constexpr float kAlone = 0.5f;        // what the detail of one photograph counts that no other confirms
constexpr float kStraight = 4;        // power of the cosine in the weight
constexpr float kLeastStraight = 0.3f;
constexpr float kPixelM = 0.0025f;  // at which a pixel weighs 1; the weight falls with its area
constexpr uint32_t kTrianglesAJob = 64;

/** What a photograph says of a texel; weight 0: nothing. */
struct Seen {
    uint16_t weight = 0, rgb[3] = {};  // halves
};

/** One plane or three of a picture. */
struct Plane {
    uint32_t widthPx, heightPx, channels;
    std::vector<float> value;
    float& at(uint32_t x, uint32_t y, uint32_t c) { return value[(size_t(y) * widthPx + x) * channels + c]; }
    float at(uint32_t x, uint32_t y, uint32_t c) const { return value[(size_t(y) * widthPx + x) * channels + c]; }
};

Plane blurred(const Plane& in, float sigmaPx) {
    const int reach = int(std::ceil(3 * sigmaPx));
    std::vector<float> kernel;
    float sum = 0;
    for (int k = -reach; k <= reach; ++k) kernel.push_back(std::exp(-0.5f * float(k * k) / (sigmaPx * sigmaPx))), sum += kernel.back();
    for (float& k : kernel) k /= sum;
    Plane across = in, out = in;
    const int width = int(in.widthPx), height = int(in.heightPx);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (uint32_t c = 0; c < in.channels; ++c) {
                float mean = 0;
                for (int k = -reach; k <= reach; ++k)
                    mean += kernel[size_t(k + reach)] * in.at(uint32_t(std::clamp(x + k, 0, width - 1)), uint32_t(y), c);
                across.at(uint32_t(x), uint32_t(y), c) = mean;
            }
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (uint32_t c = 0; c < in.channels; ++c) {
                float mean = 0;
                for (int k = -reach; k <= reach; ++k)
                    mean += kernel[size_t(k + reach)] * across.at(uint32_t(x), uint32_t(std::clamp(y + k, 0, height - 1)), c);
                out.at(uint32_t(x), uint32_t(y), c) = mean;
            }
    return out;
}

/** What is finer than kCoarsePx, of pixels inside; 0 elsewhere. Beyond the edge lies nothing, rather than what is there. */
Plane detailOf(Plane picture, const std::vector<bool>& inside) {
    Plane part{picture.widthPx, picture.heightPx, 1, std::vector<float>(inside.begin(), inside.end())};
    for (size_t p = 0; p < inside.size(); ++p)
        for (uint32_t c = 0; c < 3; ++c) picture.value[3 * p + c] *= part.value[p];
    const Plane coarse = blurred(picture, kCoarsePx), covered = blurred(part, kCoarsePx);
    for (size_t p = 0; p < inside.size(); ++p)
        for (uint32_t c = 0; c < 3; ++c)
            if (inside[p]) picture.value[3 * p + c] -= coarse.value[3 * p + c] / covered.value[p];
    return picture;
}

double squares(const Plane& plane) {
    double sum = 0;
    for (const float v : plane.value) sum += double(v) * double(v);
    return sum;
}

/** The textured mesh as a photograph shows it. */
struct Drawn {
    MeshRaster raster;  // of the finer camera
    Camerad finer;
    Plane colour;             // 0 to 1
    std::vector<bool> clear;  // pixels that lie on the mesh as a whole, and away from outlines
};

Drawn draw(std::span<const Vec3f> positions, std::span<const Triangle> triangles, const MeshAtlas& atlas, std::span<const uint8_t> texture,
           const Camerad& camera) {
    Drawn d;
    d.finer = camera;
    d.finer.widthPx *= kSamples, d.finer.heightPx *= kSamples;
    for (double* number : {&d.finer.fx, &d.finer.fy, &d.finer.cx, &d.finer.cy}) *number *= kSamples;
    d.raster = rasteriseMesh(positions, triangles, d.finer);
    d.colour = {camera.widthPx, camera.heightPx, 3, std::vector<float>(size_t(camera.widthPx) * camera.heightPx * 3, 0.0f)};
    d.clear.assign(size_t(camera.widthPx) * camera.heightPx, true);
    const int side = int(atlas.sidePx), fineWidth = int(d.finer.widthPx), fineHeight = int(d.finer.heightPx);
    for (int y = 0; y < fineHeight; ++y)
        for (int x = 0; x < fineWidth; ++x) {
            const size_t fine = size_t(y) * size_t(fineWidth) + size_t(x);
            const size_t pixel = size_t(y / int(kSamples)) * camera.widthPx + size_t(x / int(kSamples));
            const uint32_t t = d.raster.triangle[fine];
            if (t == kNoTriangle) {
                d.clear[pixel] = false;
                continue;
            }
            for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}})
                if (x + dx < fineWidth && y + dy < fineHeight) {
                    const size_t next = size_t(y + dy) * size_t(fineWidth) + size_t(x + dx);
                    if (std::abs(d.raster.depthM[fine] - d.raster.depthM[next]) > kJumpM) d.clear[pixel] = false;
                }
            const Vec2f at = d.raster.barycentric[fine];
            const auto& c = atlas.corners[t];
            const Vec2f texel = (1 - at.x - at.y) * c[0] + at.x * c[1] + at.y * c[2] - Vec2f(0.5f);
            const int x0 = std::clamp(int(std::floor(texel.x)), 0, side - 2), y0 = std::clamp(int(std::floor(texel.y)), 0, side - 2);
            const float fx = std::clamp(texel.x - float(x0), 0.0f, 1.0f), fy = std::clamp(texel.y - float(y0), 0.0f, 1.0f);
            const uint8_t *upper = &texture[3 * (size_t(y0) * size_t(side) + size_t(x0))], *lower = upper + 3 * size_t(side);
            for (uint32_t k = 0; k < 3; ++k)
                d.colour.value[3 * pixel + k] +=
                    ((1 - fy) * ((1 - fx) * upper[k] + fx * upper[3 + k]) + fy * ((1 - fx) * lower[k] + fx * lower[3 + k])) /
                    float(255 * kSamples * kSamples);
        }
    return d;
}

/** The pixels that are true and have no false one within `reach`, along axes. The border counts as false. */
std::vector<bool> eroded(std::vector<bool> set, uint32_t widthPx, uint32_t heightPx, int reach) {
    for (int step = 0; step < reach; ++step) {
        const std::vector<bool> before = set;
        for (uint32_t y = 0; y < heightPx; ++y)
            for (uint32_t x = 0; x < widthPx; ++x) {
                const size_t p = size_t(y) * widthPx + x;
                set[p] = before[p] && x > 0 && y > 0 && x + 1 < widthPx && y + 1 < heightPx && before[p - 1] && before[p + 1] &&
                         before[p - widthPx] && before[p + widthPx];
            }
    }
    return set;
}

/** The detail that a photograph has and the drawn mesh lacks, the pixels that count, and how sharp the photograph is beside the mesh. */
struct Missing {
    Plane detail;
    std::vector<bool> counts;
    float sharpness = 1;  // 1: at least as much detail as the mesh
};

Missing missingIn(const Drawn& drawn, const FramePicture& picture) {
    const uint32_t width = drawn.colour.widthPx, height = drawn.colour.heightPx;
    Plane photo = drawn.colour;
    std::vector<bool> inside = drawn.clear;
    for (size_t p = 0; p < inside.size(); ++p) {
        inside[p] = inside[p] && picture.mask.pixels[p] >= kInsideMask;
        for (size_t c = 0; c < 3; ++c) photo.value[3 * p + c] = float(picture.image.pixels[3 * p + c]) / 255;
    }
    inside = eroded(std::move(inside), width, height, kEdgePx);
    Missing m{detailOf(photo, inside), inside, 1};
    const Plane own = detailOf(drawn.colour, inside);
    if (const double most = squares(own); most > 0) m.sharpness = float(std::min(1.0, squares(m.detail) / most));
    for (size_t k = 0; k < own.value.size(); ++k) m.detail.value[k] -= own.value[k];
    m.counts = eroded(std::move(inside), width, height, 1);  // bilinear samples reach one pixel further
    return m;
}

float median(std::array<float, kBest>& values, size_t count) {
    std::sort(values.begin(), values.begin() + std::ptrdiff_t(count));
    return count % 2 ? values[count / 2] : 0.5f * (values[count / 2 - 1] + values[count / 2]);
}

/** The mean of what the best photographs say of a texel; those far from their median count less. */
Vec3f robustMean(std::span<const Seen, kBest> seen) {
    float most = 0;
    for (const Seen& s : seen) most = std::max(most, floatFromHalf(s.weight));
    Vec3f out(0);
    for (int c = 0; c < 3 && most > 0; ++c) {
        std::array<float, kBest> values{};
        size_t count = 0;
        const auto forGood = [&](auto&& what) {
            for (const Seen& s : seen)
                if (const float weight = floatFromHalf(s.weight); weight > kLeastShare * most) what(weight, floatFromHalf(s.rgb[c]));
        };
        forGood([&](float, float value) { values[count++] = value; });
        const float middle = median(values, count);
        float sum = 0, weights = 0;
        forGood([&](float weight, float value) {
            const float off = (value - middle) / kSpread, share = weight / (1 + off * off);
            sum += share * value, weights += share;
        });
        out[c] = sum / weights * (count > 1 ? 1 : kAlone);
    }
    return out;
}

}  // namespace

Status addPhotographs(const AvatarData& avatar, const MeshAtlas& atlas, const AtlasTexels& texels, std::span<const uint8_t> texture,
                      std::span<const TrainFrame> photographs, std::span<Vec3f> colours, Jobs& jobs) {
    const std::vector<Triangle>& triangles = avatar.mesh.triangles;
    std::vector<Seen> seen(texels.all.size() * kBest);
    const ClothLimits cloth(avatar.joints, avatar.mesh, avatar.correctives);
    PosedMesh posed;
    for (size_t f = 0; f < photographs.size(); ++f) {
        const TrainFrame& frame = photographs[f];
        DPL_RETURN_IF_ERROR(taskAt(double(f) / double(photographs.size()), "photograph " + frame.name));
        DPL_TRY(const auto picture, frame.picture.get());
        posed.pose({avatar.joints, avatar.mesh, avatar.correctives, {}, nullptr, {}, &cloth}, frame.pose, jobs);
        const std::span<const Vec3f> positions = posed.positions();
        const Drawn drawn = draw(positions, triangles, atlas, texture, frame.camera);
        const Missing missing = missingIn(drawn, *picture);
        const Cameraf camera = frame.camera.cast<float>();
        jobs.forRange(triangles.size(), kTrianglesAJob, [&](size_t begin, size_t end, uint32_t) {
            for (size_t t = begin; t < end; ++t) {
                const Triangle& c = triangles[t];
                const float cosine = float(frontCosine(positions, c, Vec3d(camera.eye())));
                if (cosine < kLeastStraight) continue;
                for (uint32_t i = texels.start[t]; i < texels.start[t + 1]; ++i) {
                    const Vec2f at = texels.all[i].barycentric;
                    const Vec3f view = camera.toView((1 - at.x - at.y) * positions[c.x] + at.x * positions[c.y] + at.y * positions[c.z]);
                    if (!(view.z > float(kNearM))) continue;
                    const Vec2f px = camera.pixelOf(view) - Vec2f(0.5f);
                    if (!(px.x >= 1 && px.y >= 1 && px.x < float(camera.widthPx - 2) && px.y < float(camera.heightPx - 2))) continue;
                    if (!missing.counts[size_t(px.y + 0.5f) * camera.widthPx + size_t(px.x + 0.5f)]) continue;
                    const size_t fine = size_t((px.y + 0.5f) * kSamples) * drawn.raster.widthPx + size_t((px.x + 0.5f) * kSamples);
                    if (view.z > drawn.raster.depthM[fine] + kPhotographDepthErrorM + float(recedingM(cosine, view.z, drawn.finer)))
                        continue;
                    const float pixelM = view.z / camera.fx;
                    const float weight = std::pow(cosine, kStraight) * missing.sharpness * (kPixelM * kPixelM) / (pixelM * pixelM);
                    const auto mine = std::span(seen).subspan(i * kBest).first<kBest>();
                    Seen& least =
                        *std::min_element(mine.begin(), mine.end(), [](const Seen& a, const Seen& b) { return a.weight < b.weight; });
                    const uint16_t half = halfFromFloat(std::min(weight, 1000.0f));  // halves above 0 order like their bits
                    if (half <= least.weight) continue;
                    least.weight = half;
                    const uint32_t x = uint32_t(px.x), y = uint32_t(px.y);
                    const float fx = px.x - float(x), fy = px.y - float(y);
                    for (uint32_t k = 0; k < 3; ++k) {
                        const auto& m = missing.detail;
                        least.rgb[k] = halfFromFloat((1 - fy) * ((1 - fx) * m.at(x, y, k) + fx * m.at(x + 1, y, k)) +
                                                     fy * ((1 - fx) * m.at(x, y + 1, k) + fx * m.at(x + 1, y + 1, k)));
                    }
                }
            }
        });
    }
    for (size_t i = 0; i < colours.size(); ++i)
        colours[i] = glm::clamp(colours[i] + robustMean(std::span(seen).subspan(i * kBest).first<kBest>()), Vec3f(0), Vec3f(1));
    return {};
}

}  // namespace dpl
