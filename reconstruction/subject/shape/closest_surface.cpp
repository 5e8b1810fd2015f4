// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/shape/closest_surface.h"

#include <algorithm>
#include <numeric>

#include "reconstruction/subject/shape/closest_leaf.h"

namespace dpl {
namespace {

inline float distance2ToBox(const Vec3f& p, const Vec3f& low, const Vec3f& high) {
    const Vec3f d = glm::max(glm::max(low - p, p - high), Vec3f(0));
    return glm::dot(d, d);
}

}  // namespace

ClosestSurface::ClosestSurface(std::span<const Vec3f> positions, std::span<const Triangle> triangles)
    : positions_(positions.begin(), positions.end()), triangles_(triangles.begin(), triangles.end()), order_(triangles.size()) {
    findNormals();
    std::vector<Vec3f> centres;
    for (const Triangle& t : triangles_) centres.push_back((positions_[t.x] + positions_[t.y] + positions_[t.z]) / 3.0f);
    std::iota(order_.begin(), order_.end(), 0u);
    if (triangles_.empty()) return;
    nodes_.resize(1);
    build(0, 0, uint32_t(order_.size()), centres);
}

void ClosestSurface::findNormals() {
    vertexNormals_.assign(positions_.size(), Vec3f(0));
    faceNormals_.clear();
    for (const Triangle& t : triangles_) {
        const Vec3f a = positions_[t.x], b = positions_[t.y], c = positions_[t.z], n = glm::cross(b - a, c - a);
        for (int k = 0; k < 3; ++k) vertexNormals_[t[k]] += n;
        const float length = glm::length(n);
        faceNormals_.push_back(length > 0 ? n / length : Vec3f(0));
    }
    for (Vec3f& n : vertexNormals_)
        if (const float length = glm::length(n); length > 0) n /= length;
}

void ClosestSurface::move(std::span<const Vec3f> positions) {
    positions_.assign(positions.begin(), positions.end());
    findNormals();
    for (size_t i = nodes_.size(); i-- > 0;) {  // children come after their parents
        Node& node = nodes_[i];
        node.low = Vec3f(std::numeric_limits<float>::infinity()), node.high = -node.low;
        for (uint32_t k = node.first; k < node.first + node.count; ++k)
            for (int c = 0; c < 3; ++c) {
                const Vec3f p = positions_[triangles_[order_[k]][c]];
                node.low = glm::min(node.low, p), node.high = glm::max(node.high, p);
            }
        for (uint32_t child = node.first; node.count == 0 && child < node.first + 2; ++child)
            node.low = glm::min(node.low, nodes_[child].low), node.high = glm::max(node.high, nodes_[child].high);
    }
}

void ClosestSurface::build(uint32_t node, uint32_t first, uint32_t count, const std::vector<Vec3f>& centres) {
    Vec3f low(std::numeric_limits<float>::infinity()), high(-low), centreLow = low, centreHigh = high;
    for (uint32_t i = first; i < first + count; ++i) {
        for (int k = 0; k < 3; ++k) {
            const Vec3f p = positions_[triangles_[order_[i]][k]];
            low = glm::min(low, p), high = glm::max(high, p);
        }
        centreLow = glm::min(centreLow, centres[order_[i]]), centreHigh = glm::max(centreHigh, centres[order_[i]]);
    }
    nodes_[node].low = low, nodes_[node].high = high;
    if (count <= kLeafTriangles) {
        nodes_[node].first = first, nodes_[node].count = count;
        return;
    }
    const Vec3f size = centreHigh - centreLow;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const uint32_t half = count / 2;
    std::nth_element(order_.begin() + first, order_.begin() + first + half, order_.begin() + first + count,
                     [&](uint32_t a, uint32_t b) { return std::pair(centres[a][axis], a) < std::pair(centres[b][axis], b); });
    const auto child = uint32_t(nodes_.size());
    nodes_[node].first = child;
    nodes_.resize(nodes_.size() + 2);
    build(child, first, half, centres);
    build(child + 1, first + half, count - half, centres);
}

template <class Accept>
SurfacePoint ClosestSurface::search(const Vec3f& point, float reachM, Accept accept) const {
    SurfacePoint best;
    if (nodes_.empty()) return best;
    float best2 = reachM * reachM;
    std::pair<uint32_t, float> stack[64];  // node and its squared distance; the tree is balanced, so its depth is below 32
    int top = 0;
    stack[top++] = {0, distance2ToBox(point, nodes_[0].low, nodes_[0].high)};
    while (top > 0) {
        const auto [index, near2] = stack[--top];
        if (near2 > best2) continue;
        const Node& node = nodes_[index];
        if (node.count == 0) {
            float d0 = distance2ToBox(point, nodes_[node.first].low, nodes_[node.first].high);
            float d1 = distance2ToBox(point, nodes_[node.first + 1].low, nodes_[node.first + 1].high);
            const bool firstNearer = d0 <= d1;
            stack[top++] = firstNearer ? std::pair(node.first + 1, d1) : std::pair(node.first, d0);
            stack[top++] = firstNearer ? std::pair(node.first, d0) : std::pair(node.first + 1, d1);
            continue;
        }
        ClosestLeaf leaf;
        for (uint32_t k = 0; k < node.count; ++k)
            for (int c = 0; c < 3; ++c) {
                const Vec3f& at = positions_[triangles_[order_[node.first + k]][c]];
                leaf.corner[c][0][k] = at.x, leaf.corner[c][1][k] = at.y, leaf.corner[c][2][k] = at.z;
            }
        LeafPoints points;
        closestInLeaf(leaf, point, points);
        for (uint32_t k = 0; k < node.count; ++k) {
            const float d2 = points.distance2[k];
            const uint32_t id = order_[node.first + k];
            if (!(d2 <= best2) || (d2 == best2 && id > best.triangle) || !accept(id)) continue;
            best2 = d2;
            best.triangle = id, best.barycentric = {points.weight[0][k], points.weight[1][k], points.weight[2][k]};
        }
    }
    if (!best.found()) return best;
    const Triangle& t = triangles_[best.triangle];
    best.position = best.barycentric.x * positions_[t.x] + best.barycentric.y * positions_[t.y] + best.barycentric.z * positions_[t.z];
    best.distanceM = std::sqrt(best2);
    return best;
}

SurfacePoint ClosestSurface::find(const Vec3f& point, float reachM) const {
    return search(point, reachM, [](uint32_t) { return true; });
}

SurfacePoint ClosestSurface::findFacing(const Vec3f& point, const Vec3f& normal, float minCosine, float reachM) const {
    return search(point, reachM, [&](uint32_t id) { return glm::dot(faceNormals_[id], normal) >= minCosine; });
}

Vec3f ClosestSurface::normalAt(const SurfacePoint& at) const {
    const Triangle& t = triangles_[at.triangle];
    const Vec3f n =
        at.barycentric.x * vertexNormals_[t.x] + at.barycentric.y * vertexNormals_[t.y] + at.barycentric.z * vertexNormals_[t.z];
    const float length = glm::length(n);
    return length > 0 ? n / length : faceNormals_[at.triangle];
}

float ClosestSurface::signedDistance(const Vec3f& point, float reachM) const {
    const SurfacePoint at = find(point, reachM);
    if (!at.found()) return std::numeric_limits<float>::infinity();
    return isInside(point, at) ? -at.distanceM : at.distanceM;
}

}  // namespace dpl
