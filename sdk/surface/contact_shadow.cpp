// SPDX-License-Identifier: Apache-2.0
#include "sdk/surface/contact_shadow.h"

#include <algorithm>
#include <cmath>

namespace dpl {
namespace {

constexpr uint32_t kSide = kShadowSidePx, kFine = kSide * kShadowPlaces;
constexpr float kSkirtM = 0.12f;     // by which the wide half of a blot is wider than its core
constexpr float kMostWidthM = 1e4f;  // of what lies near the floor; more is no person, and pixels would overflow

/** Distance from the floor of the nearest point of a triangle whose corners have these heights. */
float nearest(float a, float b, float c) {
    const float low = std::min({a, b, c}), high = std::max({a, b, c});
    return low > 0 ? low : high < 0 ? -high : 0;
}

/** Twice the signed area of a, b, p in the plane of the floor. */
float areaOf(const Vec3f& a, const Vec3f& b, float x, float y) {
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

/** Adds `share` around a place, all in pixels. Over the pixels that it covers it sums to share, whatever their size. */
void spread(float x0, float y0, float share, float radius, std::vector<float>& sum) {
    const auto first = [&](float at) { return size_t(std::clamp(std::ceil(at - radius - 0.5f), 0.0f, float(kSide))); };
    const auto end = [&](float at) { return size_t(std::clamp(std::floor(at + radius - 0.5f) + 1, 0.0f, float(kSide))); };
    const size_t left = first(x0), right = end(x0), top = first(y0), bottom = end(y0);
    const float inverse = 1 / (radius * radius);
    const auto at = [&](size_t x, size_t y) {
        const float dx = float(x) + 0.5f - x0, dy = float(y) + 0.5f - y0;
        const float k = std::max(0.0f, 1 - (dx * dx + dy * dy) * inverse);
        return k * k;
    };
    float whole = 0;
    for (size_t y = top; y < bottom; ++y)
        for (size_t x = left; x < right; ++x) whole += at(x, y);
    if (!(whole > 0)) return;
    for (size_t y = top; y < bottom; ++y)
        for (size_t x = left; x < right; ++x) sum[y * kSide + x] += share / whole * at(x, y);
}

}  // namespace

void ContactShadowCaster::cast(std::span<const Vec3f> positions, std::span<const Triangle> triangles, const ShadowFloor& floor,
                               const Vec3d& about, ContactShadow& shadow, std::span<const uint8_t> leftOut) {
    const Vec3d axis = std::abs(floor.up.x) < 0.9 ? Vec3d(1, 0, 0) : Vec3d(0, 0, 1);
    const Vec3d across = glm::normalize(axis - floor.up * glm::dot(axis, floor.up)), along = glm::cross(across, floor.up);
    const Vec3d origin = about - floor.up * (glm::dot(floor.up, about) - floor.height);  // positions count from it, so floats suffice
    onFloor_.resize(positions.size());
    const Vec3f a(across), l(along), u(floor.up), o(origin);
    for (size_t v = 0; v < positions.size(); ++v) {
        const Vec3f p = positions[v] - o;
        onFloor_[v] = {glm::dot(a, p), glm::dot(l, p), glm::dot(u, p)};
    }
    keepNear(triangles, leftOut);
    Vec2f low(INFINITY), high(-INFINITY);
    for (const Triangle& t : near_) {
        const Vec3f &p = onFloor_[t.x], &q = onFloor_[t.y], &r = onFloor_[t.z];
        low = glm::min(low, glm::min(Vec2f(p), glm::min(Vec2f(q), Vec2f(r))));
        high = glm::max(high, glm::max(Vec2f(p), glm::max(Vec2f(q), Vec2f(r))));
    }
    const float width = std::max(high.x - low.x, high.y - low.y);
    const bool any = width >= 0 && width < kMostWidthM;
    double side = kShadowLeastM;
    if (any) {
        // The widest blot, and one pixel, lie between what casts and the edge.
        const double needed = (double(width) + 2 * double(kShadowReachM + kShadowBlurM + kSkirtM)) / (1 - 4.0 / kSide);
        if (needed > side)
            side = kShadowLeastM * std::pow(kShadowStep, std::ceil(std::log(needed / kShadowLeastM) / std::log(kShadowStep)));
    }
    // Pixels lie on a grid of the world, so that a foot that stands keeps its pixels while the other one moves.
    const double pixelM = side / kSide;
    const Vec2d middle = any ? Vec2d(low + high) * 0.5 : Vec2d(0);
    const Vec2d start(glm::dot(across, origin), glm::dot(along, origin));
    const Vec2d corner = glm::floor((start + middle - side / 2) / pixelM + 0.5) * pixelM - start;
    shadow.corner = origin + corner.x * across + corner.y * along;
    shadow.across = side * across, shadow.along = side * along;
    shadow.alpha.fill(0), shadow.darkest = 0;
    if (!any) return;

    drawLowest(Vec2f(corner), float(pixelM));
    gatherBlots(float(pixelM));
    sum_.assign(size_t(kSide) * kSide, 0);
    for (const Blot& b : blots_) {
        spread(b.x, b.y, b.share / 2, b.radius, sum_);
        spread(b.x, b.y, b.share / 2, b.radius + kSkirtM / float(pixelM), sum_);
    }
    for (size_t i = 0; i < sum_.size(); ++i) {
        shadow.alpha[i] = uint8_t(255 * std::min(1.0f, sum_[i]) + 0.5f);
        shadow.darkest = std::max(shadow.darkest, shadow.alpha[i]);
    }
}

void ContactShadowCaster::keepNear(std::span<const Triangle> triangles, std::span<const uint8_t> leftOut) {
    near_.clear();
    for (size_t t = 0; t < triangles.size(); ++t) {
        const Vec3f &p = onFloor_[triangles[t].x], &q = onFloor_[triangles[t].y], &r = onFloor_[triangles[t].z];
        if (nearest(p.z, q.z, r.z) < kShadowReachM && (leftOut.empty() || !leftOut[t])) near_.push_back(triangles[t]);
    }
}

/** Fills lowest_. corner: of the picture, among onFloor_. */
void ContactShadowCaster::drawLowest(const Vec2f& corner, float pixelM) {
    const float fine = pixelM / kShadowPlaces;
    lowest_.assign(size_t(kFine) * kFine, kShadowReachM);
    for (const Triangle& t : near_) {
        const Vec3f &p = onFloor_[t.x], &q = onFloor_[t.y], &r = onFloor_[t.z];
        const float area = areaOf(p, q, r.x, r.y);
        if (area == 0) continue;
        const auto first = [&](float low, float from) {
            return size_t(std::clamp(std::ceil((low - from) / fine - 0.5f), 0.0f, float(kFine)));
        };
        const auto end = [&](float high, float from) {
            return size_t(std::clamp(std::floor((high - from) / fine - 0.5f) + 1, 0.0f, float(kFine)));
        };
        const size_t x0 = first(std::min({p.x, q.x, r.x}), corner.x), x1 = end(std::max({p.x, q.x, r.x}), corner.x);
        const size_t y0 = first(std::min({p.y, q.y, r.y}), corner.y), y1 = end(std::max({p.y, q.y, r.y}), corner.y);
        const float inverse = 1 / area;
        for (size_t y = y0; y < y1; ++y)
            for (size_t x = x0; x < x1; ++x) {
                const float px = corner.x + (float(x) + 0.5f) * fine, py = corner.y + (float(y) + 0.5f) * fine;
                const float wp = areaOf(q, r, px, py) * inverse, wq = areaOf(r, p, px, py) * inverse, wr = areaOf(p, q, px, py) * inverse;
                if (wp < 0 || wq < 0 || wr < 0) continue;
                float& lowest = lowest_[y * kFine + x];
                lowest = std::min(lowest, std::abs(wp * p.z + wq * q.z + wr * r.z));
            }
    }
}

void ContactShadowCaster::gatherBlots(float pixelM) {
    blots_.clear();
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x) {
            float weight = 0, height = 0;
            Vec2f at(0);
            for (uint32_t i = 0; i < kShadowPlaces * kShadowPlaces; ++i) {
                const uint32_t fx = x * kShadowPlaces + i % kShadowPlaces, fy = y * kShadowPlaces + i / kShadowPlaces;
                const float h = lowest_[size_t(fy) * kFine + fx], fade = 1 - h * (1 / kShadowReachM), w = fade * fade;
                weight += w, height += w * h, at += w * Vec2f(float(fx) + 0.5f, float(fy) + 0.5f);
            }
            if (!(weight > 0)) continue;
            at /= weight * kShadowPlaces;
            const float radius = std::max(1.5f, (kShadowBlurM + height / weight) / pixelM);
            blots_.push_back({at.x, at.y, weight / (kShadowPlaces * kShadowPlaces), radius});
        }
}

}  // namespace dpl
