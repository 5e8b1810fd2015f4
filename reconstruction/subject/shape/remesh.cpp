// SPDX-License-Identifier: Apache-2.0
// Edge collapses, flips and smoothing on a mesh that follows an implicit field, after Botsch and Kobbelt 2004, A Remeshing Approach to
// Multiresolution Modeling.
#include <algorithm>
#include <array>
#include <cmath>

#include "reconstruction/subject/shape/implicit_mesh.h"

namespace dpl {
namespace {

/** Newton steps along the gradient towards field = 0, each at most 8 mm. */
Vec3f projected(const ScalarField& field, Vec3f p, int steps) {
    constexpr float h = 4e-4f;
    for (int i = 0; i < steps; ++i) {
        const Vec3f a(h, -h, -h), b(-h, -h, h), c(-h, h, -h), d(h, h, h);
        const float fa = field(p + a), fb = field(p + b), fc = field(p + c), fd = field(p + d);
        const Vec3f slope = (a * fa + b * fb + c * fc + d * fd) / (4 * h * h);
        const float value = 0.25f * (fa + fb + fc + fd), slope2 = glm::dot(slope, slope);
        if (slope2 < 1e-3f) break;
        Vec3f step = slope * (value / slope2);
        const float length = glm::length(step);
        if (length > 0.008f) step *= 0.008f / length;
        p -= step;
    }
    return p;
}

class Remesher {
public:
    Remesher(const SurfaceMesh& mesh, const ScalarField& field, const RemeshOptions& options, Jobs& jobs)
        : at_(mesh.positions), triangles_(mesh.triangles), field_(field), options_(options), jobs_(jobs) {
        trianglesOf_.resize(at_.size());
        for (uint32_t t = 0; t < triangles_.size(); ++t)
            for (int c = 0; c < 3; ++c) trianglesOf_[triangles_[t][c]].push_back(t);
        dead_.assign(triangles_.size(), 0);
        wanted_.resize(at_.size());
        for (size_t v = 0; v < at_.size(); ++v) wanted_[v] = options_.edgeLength(at_[v]);
        boundary_.assign(at_.size(), 0);
        for (const Triangle& t : triangles_)
            for (int c = 0; c < 3; ++c)
                if (across(t[c], t[(c + 1) % 3]).count == 1) boundary_[t[c]] = boundary_[t[(c + 1) % 3]] = 1;
    }

    SurfaceMesh run() {
        for (float threshold : {0.35f, 0.55f, 0.72f}) collapseAll(threshold);
        flipAll();
        relaxAll(2);
        for (int round = 0; round < options_.relaxations; ++round) {
            if (round < 4) collapseAll(0.76f);
            flipAll();
            relaxAll(round + 1 == options_.relaxations ? 3 : 1);
        }
        SurfaceMesh out;
        out.positions = at_;
        for (uint32_t t = 0; t < triangles_.size(); ++t)
            if (!dead_[t]) out.triangles.push_back(triangles_[t]);
        return withoutUnused(out);
    }

private:
    struct Across {
        uint32_t triangle[2], opposite[2];
        int count = 0;  // of all triangles at the edge; only two are kept
    };

    /** The triangles at edge a-b and their third corners. */
    Across across(uint32_t a, uint32_t b) const {
        Across result;
        for (uint32_t t : trianglesOf_[a]) {
            const Triangle& v = triangles_[t];
            for (int c = 0; c < 3; ++c)
                if (v[c] != a && v[c] != b && (v[0] == b || v[1] == b || v[2] == b)) {
                    if (result.count < 2) result.triangle[result.count] = t, result.opposite[result.count] = v[c];
                    ++result.count;
                }
        }
        return result;
    }

    bool adjacent(uint32_t a, uint32_t b) const {
        for (uint32_t t : trianglesOf_[a]) {
            const Triangle& v = triangles_[t];
            if (v[0] == b || v[1] == b || v[2] == b) return true;
        }
        return false;
    }

    int commonNeighbours(uint32_t a, uint32_t b) {
        ++mark_;
        if (seen_.size() < at_.size()) seen_.resize(at_.size(), 0);
        for (uint32_t t : trianglesOf_[a])
            for (int c = 0; c < 3; ++c) seen_[triangles_[t][c]] = mark_;
        int count = 0;
        const uint32_t fromA = mark_++;
        for (uint32_t t : trianglesOf_[b])
            for (int c = 0; c < 3; ++c) {
                const uint32_t v = triangles_[t][c];
                if (v != a && v != b && seen_[v] == fromA) seen_[v] = mark_, ++count;
            }
        return count;
    }

    static Vec3f areaNormal(const Vec3f& a, const Vec3f& b, const Vec3f& c) { return glm::cross(b - a, c - a); }

    /** May vertex `v` move to `to`? Checks its triangles without corner `other`: no edge longer than √longest2, no sliver, no flip. */
    bool survives(uint32_t v, uint32_t other, const Vec3f& to, float longest2) const {
        for (uint32_t t : trianglesOf_[v]) {
            const Triangle& tri = triangles_[t];
            if (tri[0] == other || tri[1] == other || tri[2] == other) continue;
            Vec3f before[3], after[3];
            for (int c = 0; c < 3; ++c) {
                before[c] = at_[tri[c]];
                after[c] = tri[c] == v ? to : before[c];
                if (tri[c] != v && glm::dot(to - before[c], to - before[c]) > longest2) return false;
            }
            const Vec3f n0 = areaNormal(before[0], before[1], before[2]), n1 = areaNormal(after[0], after[1], after[2]);
            const float l0 = glm::length(n0), l1 = glm::length(n1);
            const Vec3f e0 = after[1] - after[0], e1 = after[2] - after[1], e2 = after[0] - after[2];
            const float edge2 = std::max({glm::dot(e0, e0), glm::dot(e1, e1), glm::dot(e2, e2)});
            if (l1 < 0.12f * edge2) return false;                                // a sliver
            if (l0 > 1e-12f && glm::dot(n0, n1) < 0.5f * l0 * l1) return false;  // turned by more than 60°
        }
        return true;
    }

    bool collapse(uint32_t a, uint32_t b) {
        const Across edge = across(a, b);
        if (edge.count != 2 || commonNeighbours(a, b) != 2) return false;
        if (boundary_[a] && boundary_[b]) return false;
        for (uint32_t o : edge.opposite)
            if (trianglesOf_[o].size() <= 4 && !boundary_[o]) return false;
        const Vec3f to = boundary_[a] ? at_[a] : boundary_[b] ? at_[b] : 0.5f * (at_[a] + at_[b]);
        const float wanted = std::min(wanted_[a], wanted_[b]);
        const float longest = 1.45f * wanted;
        if (!survives(a, b, to, longest * longest) || !survives(b, a, to, longest * longest)) return false;
        if (boundary_[b]) std::swap(a, b);
        at_[a] = to;
        wanted_[a] = wanted;
        for (int side = 0; side < 2; ++side) {
            const uint32_t t = edge.triangle[side];
            dead_[t] = 1;
            for (int c = 0; c < 3; ++c) std::erase(trianglesOf_[triangles_[t][c]], t);
        }
        for (uint32_t t : trianglesOf_[b]) {
            for (int c = 0; c < 3; ++c)
                if (triangles_[t][c] == b) triangles_[t][c] = a;
            trianglesOf_[a].push_back(t);
        }
        trianglesOf_[b].clear();
        return true;
    }

    void collapseAll(float threshold) {
        for (int pass = 0; pass < 3; ++pass) {
            size_t done = 0;
            for (uint32_t t = 0; t < triangles_.size(); ++t)
                for (int c = 0; c < 3 && !dead_[t]; ++c) {
                    const uint32_t a = triangles_[t][c], b = triangles_[t][(c + 1) % 3];
                    const float limit = threshold * std::min(wanted_[a], wanted_[b]);
                    const Vec3f e = at_[a] - at_[b];
                    if (glm::dot(e, e) < limit * limit && collapse(a, b)) ++done;
                }
            if (done * 200 < triangles_.size()) break;
        }
    }

    void flipAll() {
        for (uint32_t t = 0; t < triangles_.size(); ++t)
            for (int c = 0; c < 3 && !dead_[t]; ++c) {
                const uint32_t a = triangles_[t][c], b = triangles_[t][(c + 1) % 3], o0 = triangles_[t][(c + 2) % 3];
                if (a > b) continue;
                const Across edge = across(a, b);
                if (edge.count != 2) continue;
                const uint32_t other = edge.triangle[0] == t ? edge.triangle[1] : edge.triangle[0];
                const uint32_t o1 = edge.triangle[0] == t ? edge.opposite[1] : edge.opposite[0];
                if (o0 == o1 || adjacent(o0, o1)) continue;
                auto off = [&](uint32_t v, int change) {
                    const int d = int(trianglesOf_[v].size()) + change - (boundary_[v] ? 3 : 6);
                    return d * d;
                };
                const int before = off(a, 0) + off(b, 0) + off(o0, 0) + off(o1, 0),
                          after = off(a, -1) + off(b, -1) + off(o0, 1) + off(o1, 1);
                if (after >= before) continue;
                // The two new triangles: (o0, a, o1) and (o1, b, o0).
                const Vec3f n0 = areaNormal(at_[a], at_[b], at_[o0]) + areaNormal(at_[b], at_[a], at_[o1]);
                const Vec3f m0 = areaNormal(at_[o0], at_[a], at_[o1]), m1 = areaNormal(at_[o1], at_[b], at_[o0]);
                const float l = glm::length(n0), l0 = glm::length(m0), l1 = glm::length(m1);
                const Vec3f e = at_[o0] - at_[o1];
                const float edge2 = glm::dot(e, e), limit = 1.6f * std::min(wanted_[o0], wanted_[o1]);
                if (edge2 > limit * limit || l0 < 0.3f * edge2 || l1 < 0.3f * edge2) continue;
                if (glm::dot(m0, n0) < 0.6f * l0 * l || glm::dot(m1, n0) < 0.6f * l1 * l) continue;
                triangles_[t] = {o0, a, o1};
                triangles_[other] = {o1, b, o0};
                std::erase(trianglesOf_[b], t);
                std::erase(trianglesOf_[a], other);
                trianglesOf_[o1].push_back(t);
                trianglesOf_[o0].push_back(other);
                break;
            }
    }

    void relaxAll(int projections) {
        std::vector<Vec3f> next = at_;
        jobs_.forRange(at_.size(), 512, [&](size_t begin, size_t end, uint32_t) {
            for (size_t v = begin; v < end; ++v) {
                if (trianglesOf_[v].empty() || boundary_[v]) continue;
                Vec3f sum(0), normal(0);
                float weights = 0;
                for (uint32_t t : trianglesOf_[v]) {
                    const Triangle& tri = triangles_[t];
                    const Vec3f n = areaNormal(at_[tri[0]], at_[tri[1]], at_[tri[2]]);
                    normal += n;
                    // Triangles larger than wanted pull more, so that sizes approach the wanted ones.
                    const float wanted = (wanted_[tri[0]] + wanted_[tri[1]] + wanted_[tri[2]]) / 3;
                    const float w = glm::length(n) / (wanted * wanted) + 0.05f;
                    sum += w * (at_[tri[0]] + at_[tri[1]] + at_[tri[2]]) / 3.0f;
                    weights += w;
                }
                const float length = glm::length(normal);
                if (length <= 0) continue;
                normal /= length;
                Vec3f move = sum / weights - at_[v];
                move -= normal * glm::dot(move, normal);
                next[v] = projected(field_, at_[v] + 0.7f * move, projections);
            }
        });
        at_ = std::move(next);
        for (size_t v = 0; v < at_.size(); ++v)
            if (!trianglesOf_[v].empty()) wanted_[v] = options_.edgeLength(at_[v]);
    }

    std::vector<Vec3f> at_;
    std::vector<Triangle> triangles_;
    const ScalarField& field_;
    const RemeshOptions& options_;
    Jobs& jobs_;
    std::vector<std::vector<uint32_t>> trianglesOf_;
    std::vector<uint8_t> dead_, boundary_;
    std::vector<float> wanted_;   // per vertex: wanted edge length, metres
    std::vector<uint32_t> seen_;  // per vertex: mark_ of the last visit by commonNeighbours()
    uint32_t mark_ = 0;
};

}  // namespace

SurfaceMesh remesh(const SurfaceMesh& mesh, const ScalarField& field, const RemeshOptions& options, Jobs& jobs) {
    return Remesher(mesh, field, options, jobs).run();
}

}  // namespace dpl
