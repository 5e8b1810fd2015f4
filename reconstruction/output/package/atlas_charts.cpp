// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/atlas_charts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "reconstruction/subject/shape/edge_uses.h"

namespace dpl {
namespace {

constexpr float kGrowCosine = 0.64f;     // 50°: of a triangle to the mean normal of a chart that grows
constexpr float kKeepCosine = 0.31f;     // 72°: to the final normal; a texel is stretched by 3.2 there
constexpr float kSmallShare = 0.0004f;   // of the surface: smaller charts join a neighbour, if its plane can hold them
constexpr uint32_t kOverlapCells = 256;  // along the longer side of a chart, to find places that it covers twice
constexpr int kTurns = 18;               // angles that are tried for the smallest box, over a right angle

using Neighbours = std::vector<std::array<uint32_t, 3>>;  // over each edge; ~0u: none

Neighbours neighboursOf(std::span<const Triangle> triangles) {
    struct Use {
        Edge edge;
        uint32_t triangle, side;
    };
    std::vector<Use> uses;
    for (uint32_t t = 0; t < triangles.size(); ++t)
        for (uint32_t k = 0; k < 3; ++k) uses.push_back({edgeOf(triangles[t][k], triangles[t][(k + 1) % 3]), t, k});
    std::sort(uses.begin(), uses.end(),
              [](const Use& a, const Use& b) { return std::tie(a.edge, a.triangle, a.side) < std::tie(b.edge, b.triangle, b.side); });
    Neighbours out(triangles.size(), {~0u, ~0u, ~0u});
    for (size_t i = 0; i + 1 < uses.size(); ++i)
        if (uses[i].edge == uses[i + 1].edge) {
            out[uses[i].triangle][uses[i].side] = uses[i + 1].triangle;
            out[uses[i + 1].triangle][uses[i + 1].side] = uses[i].triangle;
            ++i;  // an edge of more than two triangles joins them by pairs
        }
    return out;
}

/** Sets a plane at right angles to `normal`. */
void layPlane(const Vec3f& normal, AtlasChart& chart) {
    const Vec3f most = std::abs(normal.y) < 0.9f ? Vec3f(0, 1, 0) : Vec3f(0, 0, -1);
    chart.across = glm::normalize(glm::cross(most, normal));
    chart.up = glm::cross(normal, chart.across);
}

class Charts {
public:
    Charts(std::span<const Vec3f> positions, std::span<const Triangle> triangles, std::span<const uint32_t> group)
        : positions_(positions),
          triangles_(triangles),
          group_(group),
          neighbours_(neighboursOf(triangles)),
          chart_(triangles.size(), kNone) {
        for (const Triangle& t : triangles) {
            const Vec3f across = glm::cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]);
            area_.push_back(glm::length(across) / 2);
            normal_.push_back(area_.back() > 0 ? across / (2 * area_.back()) : Vec3f(0));
            total_ += area_.back();
        }
    }

    std::vector<AtlasChart> make() {
        std::vector<uint32_t> seeds(triangles_.size());
        std::iota(seeds.begin(), seeds.end(), 0u);
        std::stable_sort(seeds.begin(), seeds.end(), [&](uint32_t a, uint32_t b) { return area_[a] > area_[b]; });
        // What a chart drops may be a seed later, in the same order.
        for (bool again = true; again;) {
            again = false;
            for (const uint32_t seed : seeds)
                if (chart_[seed] == kNone) again |= grow(seed);
        }
        joinSmall();
        std::erase_if(charts_, [](const AtlasChart& c) { return c.triangles.empty(); });
        for (AtlasChart& chart : charts_) turn(chart);
        return std::move(charts_);
    }

private:
    static constexpr uint32_t kNone = ~0u;

    Vec3f meanNormal(std::span<const uint32_t> triangles) const {
        Vec3f sum(0);
        for (const uint32_t t : triangles) sum += area_[t] * normal_[t];
        return glm::length(sum) > 0 ? glm::normalize(sum) : Vec3f(0, 0, 1);
    }
    bool flat(uint32_t t, const Vec3f& axis, float cosine) const { return !(area_[t] > 0) || glm::dot(normal_[t], axis) > cosine; }

    /** Makes a chart around a seed. Returns whether it has dropped triangles. */
    bool grow(uint32_t seed) {
        using Entry = std::pair<float, uint32_t>;  // how far from flat, triangle
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
        std::vector<uint32_t> taken;
        Vec3f sum(0), axis = area_[seed] > 0 ? normal_[seed] : Vec3f(0, 0, 1);
        open.push({0.0f, seed});
        const uint32_t number = uint32_t(charts_.size());
        while (!open.empty()) {
            const uint32_t t = open.top().second;
            open.pop();
            if (chart_[t] != kNone || !flat(t, axis, kGrowCosine)) continue;
            chart_[t] = number;
            taken.push_back(t);
            sum += area_[t] * normal_[t];
            if (glm::length(sum) > 0) axis = glm::normalize(sum);
            for (const uint32_t n : neighbours_[t])
                if (n != kNone && chart_[n] == kNone && group_[n] == group_[seed] && flat(n, axis, kGrowCosine))
                    open.push({area_[n] > 0 ? 1 - glm::dot(normal_[n], axis) : 0, n});
        }
        AtlasChart chart;
        const Vec3f mean = meanNormal(taken);
        layPlane(flat(seed, mean, kKeepCosine) ? mean : normal_[seed], chart);
        const std::vector<uint32_t> kept = keepable(chart, taken, seed);
        for (const uint32_t t : taken) chart_[t] = kNone;
        for (const uint32_t t : kept) chart_[t] = number;
        chart.triangles = kept;
        charts_.push_back(std::move(chart));
        return kept.size() < taken.size();
    }

    /** Those of `taken`, in their order, that lie flat enough on the chart's plane and cover no place that an earlier one covers. The seed
     *  always stays. */
    std::vector<uint32_t> keepable(const AtlasChart& chart, std::span<const uint32_t> taken, uint32_t seed) const {
        const Vec3f axis = glm::cross(chart.across, chart.up);
        Vec2f low(std::numeric_limits<float>::max()), high(-std::numeric_limits<float>::max());
        for (const uint32_t t : taken)
            for (int k = 0; k < 3; ++k) {
                const Vec2f p = chart.place(positions_[triangles_[t][k]]);
                low = glm::min(low, p), high = glm::max(high, p);
            }
        const float longest = std::max(high.x - low.x, high.y - low.y), perM = longest > 0 ? kOverlapCells / longest : 1;
        std::vector<bool> covered(size_t(kOverlapCells + 1) * (kOverlapCells + 1), false);
        std::vector<uint32_t> kept, cells;
        for (const uint32_t t : taken) {
            if (t != seed && !flat(t, axis, kKeepCosine)) continue;
            cells.clear();
            std::array<Vec2f, 3> c;
            for (int k = 0; k < 3; ++k) c[k] = (chart.place(positions_[triangles_[t][k]]) - low) * perM;
            const Vec2f first = glm::min(c[0], glm::min(c[1], c[2])), last = glm::max(c[0], glm::max(c[1], c[2]));
            for (uint32_t y = uint32_t(first.y); y <= std::min(uint32_t(last.y), kOverlapCells); ++y)
                for (uint32_t x = uint32_t(first.x); x <= std::min(uint32_t(last.x), kOverlapCells); ++x)
                    if (inside(c, Vec2f(float(x) + 0.5f, float(y) + 0.5f))) cells.push_back(y * (kOverlapCells + 1) + x);
            if (t != seed && std::any_of(cells.begin(), cells.end(), [&](uint32_t cell) { return covered[cell]; })) continue;
            for (const uint32_t cell : cells) covered[cell] = true;
            kept.push_back(t);
        }
        return kept;
    }

    /** Whether a cell's centre lies within, and not just on an edge. */
    static bool inside(const std::array<Vec2f, 3>& c, const Vec2f& p) {
        constexpr float kEdge = 0.02f;  // cells: neighbours share centres on their edge otherwise
        float least = std::numeric_limits<float>::max();
        for (int k = 0; k < 3; ++k) {
            const Vec2f edge = c[(k + 1) % 3] - c[k], to = p - c[k];
            const float length = glm::length(edge);
            if (!(length > 0)) return false;
            least = std::min(least, (edge.x * to.y - edge.y * to.x) / length);
        }
        return least > kEdge;
    }

    /** Joins small charts to the neighbour with which they share most edges, if together they still lie flat and nothing is covered twice.
     */
    void joinSmall() {
        std::vector<uint32_t> order;
        std::vector<float> area(charts_.size(), 0);
        for (uint32_t c = 0; c < charts_.size(); ++c) {
            for (const uint32_t t : charts_[c].triangles) area[c] += area_[t];
            if (area[c] < kSmallShare * total_) order.push_back(c);
        }
        std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return area[a] < area[b]; });
        for (const uint32_t c : order) {
            std::unordered_map<uint32_t, uint32_t> shared;
            for (const uint32_t t : charts_[c].triangles)
                for (const uint32_t n : neighbours_[t])
                    if (n != kNone && chart_[n] != c && group_[n] == group_[t]) ++shared[chart_[n]];
            std::vector<std::pair<uint32_t, uint32_t>> others(shared.begin(), shared.end());
            std::sort(others.begin(), others.end(),
                      [](const auto& a, const auto& b) { return a.second != b.second ? a.second > b.second : a.first < b.first; });
            for (const auto& [other, edges] : others) {
                std::vector<uint32_t> both = charts_[other].triangles;
                both.insert(both.end(), charts_[c].triangles.begin(), charts_[c].triangles.end());
                AtlasChart joined;
                layPlane(meanNormal(both), joined);
                const Vec3f axis = glm::cross(joined.across, joined.up);
                // A quick look first: most neighbours cannot hold it.
                if (!std::all_of(both.begin(), both.end(), [&](uint32_t t) { return flat(t, axis, kKeepCosine); }) ||
                    keepable(joined, both, both.front()).size() < both.size())
                    continue;
                joined.triangles = std::move(both);
                for (const uint32_t t : charts_[c].triangles) chart_[t] = other;
                charts_[c].triangles.clear();
                charts_[other] = std::move(joined);
                break;
            }
        }
    }

    /** Turns a chart within its plane to its smallest box. */
    void turn(AtlasChart& chart) const {
        const Vec3f across = chart.across, up = chart.up;
        float best = std::numeric_limits<float>::max();
        for (int k = 0; k < kTurns; ++k) {
            const float angle = float(std::numbers::pi) / 2 * float(k) / kTurns;
            AtlasChart turned;
            turned.across = std::cos(angle) * across + std::sin(angle) * up, turned.up = std::cos(angle) * up - std::sin(angle) * across;
            Vec2f low(std::numeric_limits<float>::max()), high(-std::numeric_limits<float>::max());
            for (const uint32_t t : chart.triangles)
                for (int c = 0; c < 3; ++c) {
                    const Vec2f p = turned.place(positions_[triangles_[t][c]]);
                    low = glm::min(low, p), high = glm::max(high, p);
                }
            const Vec2f size = high - low;
            if (size.x * size.y >= best) continue;
            best = size.x * size.y;
            chart.across = turned.across, chart.up = turned.up;
            if (size.y > size.x) chart.across = turned.up, chart.up = -turned.across;
        }
    }

    std::span<const Vec3f> positions_;
    std::span<const Triangle> triangles_;
    std::span<const uint32_t> group_;
    Neighbours neighbours_;
    std::vector<uint32_t> chart_;  // of each triangle
    std::vector<Vec3f> normal_;    // unit, or 0 for a triangle without area
    std::vector<float> area_;
    float total_ = 0;
    std::vector<AtlasChart> charts_;
};

}  // namespace

std::vector<AtlasChart> chartsOf(std::span<const Vec3f> positions, std::span<const Triangle> triangles, std::span<const uint32_t> group) {
    return Charts(positions, triangles, group).make();
}

}  // namespace dpl
