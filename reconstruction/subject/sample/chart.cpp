// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/chart.h"

#include <algorithm>
#include <cmath>

namespace dpl {
namespace {

constexpr Vec2f kPanelLow{-0.098f, -0.100f}, kPanelHigh{0.098f, 0.108f};
constexpr Vec2f kCheckLow{-0.060f, -0.092f}, kCheckHigh{0.060f, -0.060f};
constexpr float kCheckM = 0.003f;
constexpr uint32_t kPlaces = 7;  // along an edge of a field: the chest is round

struct Word {
    Vec2f at;  // of its lower left corner
    float heightM;
};
constexpr std::array<Word, 6> kWords{{{{-0.062f, 0.072f}, 0.026f},
                                      {{-0.043f, 0.044f}, 0.018f},
                                      {{-0.029f, 0.023f}, 0.012f},
                                      {{-0.070f, 0.005f}, 0.008f},
                                      {{-0.010f, 0.005f}, 0.005f},
                                      {{0.040f, 0.005f}, 0.003f}}};

bool isWithin(const Vec2f& p, const Vec2f& low, const Vec2f& high) {
    return p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y;
}

/** The point of the front of the shirt with this canonical x and y. */
std::optional<Vec3d> frontPoint(const Subject& subject, const std::vector<Vec3d>& vertices, const Vec2f& at) {
    for (const LayerData& layer : subject.mesh.layers) {
        if (layer.name != "top") continue;
        for (uint32_t t = layer.firstTriangle; t < layer.firstTriangle + layer.triangleCount; ++t) {
            const Triangle& f = subject.mesh.triangles[t];
            const Vec3f &a = subject.canonical[f.x], &b = subject.canonical[f.y], &c = subject.canonical[f.z];
            if (std::min({a.z, b.z, c.z}) < 0.02f) continue;
            const Vec2f p = at - Vec2f(a), u(Vec2f(b) - Vec2f(a)), v(Vec2f(c) - Vec2f(a));
            const float area = u.x * v.y - u.y * v.x;
            if (area <= 0) continue;
            const float s = (p.x * v.y - p.y * v.x) / area, r = (u.x * p.y - u.y * p.x) / area;
            if (s < 0 || r < 0 || s + r > 1) continue;
            return vertices[f.x] * double(1 - s - r) + vertices[f.y] * double(s) + vertices[f.z] * double(r);
        }
    }
    return std::nullopt;
}

}  // namespace

ChartInk chartInk(const Vec2f& at, float footprintM) {
    if (!isWithin(at, kPanelLow, kPanelHigh)) return {};
    ChartInk out{1, 0};
    for (const Word& word : kWords) out.ink = std::max(out.ink, wordInk(at - word.at, word.heightM, footprintM));
    for (const BarField& field : kBarFields) {
        const Vec2f p = at - field.centre;
        if (std::abs(p.x) > 0.5f * kBarFieldM.x || std::abs(p.y) > 0.5f * kBarFieldM.y) continue;
        const float x = p.x + 0.5f * kBarFieldM.x - 0.5f * field.barM, period = 2 * field.barM;
        out.ink = bars(x, period, field.barM, footprintM);
    }
    if (isWithin(at, kCheckLow, kCheckHigh)) {
        const float across = bars(at.x, 2 * kCheckM, kCheckM, footprintM), down = bars(at.y, 2 * kCheckM, kCheckM, footprintM);
        out.ink = across + down - 2 * across * down;
    }
    return out;
}

std::vector<BarsSeen> seeBars(const Subject& subject, const std::vector<Vec3d>& vertices, const Camerad& camera) {
    std::vector<BarsSeen> out;
    for (const BarField& field : kBarFields) {
        BarsSeen seen;
        seen.barMm = std::round(1e5 * double(field.barM)) / 100;
        for (const float side : {0.5f, -0.5f})
            for (uint32_t k = 0; k < kPlaces; ++k) {
                const Vec2f from((float(k) / float(kPlaces - 1) - 0.5f) * kBarFieldM.x, side * kBarFieldM.y);
                const auto point = frontPoint(subject, vertices, kChartCentre + field.centre + from);
                const Vec3d view = point ? camera.toView(*point) : Vec3d(0);
                const Vec2d px(camera.fx * view.x / view.z + camera.cx, camera.fy * view.y / view.z + camera.cy);
                if (view.z < 0.05 || px.x < 0 || px.y < 0 || px.x >= camera.widthPx || px.y >= camera.heightPx) break;
                (side > 0 ? seen.topPx : seen.bottomPx).push_back(px);
            }
        if (seen.topPx.size() == kPlaces && seen.bottomPx.size() == kPlaces) out.push_back(std::move(seen));
    }
    return out;
}

}  // namespace dpl
