// SPDX-License-Identifier: Apache-2.0
#include "sdk/visibility/components.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>

#include "sdk/math/coverage.h"
#include "sdk/math/projection.h"

namespace dpl {
namespace {

enum Region : uint8_t { kTrunk, kHead, kLeftHand, kRightHand, kLeftLeg, kRightLeg };

/** The region that a humanoid bone begins, or -1. Children of the bone belong to it, unless they begin their own. */
int regionBegunBy(std::string_view bone) {
    constexpr std::pair<std::string_view, Region> kBegins[] = {{"neck", kHead},
                                                               {"head", kHead},
                                                               {"leftHand", kLeftHand},
                                                               {"rightHand", kRightHand},
                                                               {"leftUpperLeg", kLeftLeg},
                                                               {"rightUpperLeg", kRightLeg}};
    for (const auto& [name, region] : kBegins)
        if (bone == name) return region;
    return -1;
}

std::vector<uint8_t> regionsOf(std::span<const JointData> joints) {
    std::vector<uint8_t> regions(joints.size(), kTrunk);
    for (size_t j = 0; j < joints.size(); ++j) {
        const int begun = regionBegunBy(joints[j].humanoidBone);
        regions[j] = begun >= 0 ? uint8_t(begun) : joints[j].parent >= 0 ? regions[size_t(joints[j].parent)] : uint8_t(kTrunk);
    }
    return regions;
}

/** Index of the first layer that holds the triangle; the number of layers when none does. */
size_t layerOf(const MeshData& mesh, size_t triangle) {
    for (size_t l = 0; l < mesh.layers.size(); ++l)
        if (triangle >= mesh.layers[l].firstTriangle && triangle - mesh.layers[l].firstTriangle < mesh.layers[l].triangleCount) return l;
    return mesh.layers.size();
}

struct Box {
    Vec3d low{INFINITY}, high{-INFINITY};
    void add(const Vec3d& p) { low = glm::min(low, p), high = glm::max(high, p); }
    Vec3d centre() const { return 0.5 * (low + high); }
    Vec3d half() const { return 0.5 * (high - low); }
};

double weightOf(const MeshData& mesh, uint32_t vertex, uint32_t joint) {
    double sum = 0;
    for (int k = 0; k < 4; ++k)
        if (mesh.jointIndices[vertex][k] == joint) sum += mesh.jointWeights[vertex][k] / 255.0;
    return sum;
}

/** Offsets of the nodes, metres, that a mode adds for a coefficient of 1. The modes of the expressions follow those of the pose. */
void nodesOf(const PoseCorrectiveData& c, const ExpressionData& expressions, size_t mode, std::vector<Vec3f>& nodes) {
    nodes.assign(c.nodeCount, Vec3f(0));
    if (mode < c.columnCount()) {
        for (size_t n = 0; n < nodes.size(); ++n) nodes[n] = Vec3f(c.nodes[n * c.columnCount() + mode]);
        return;
    }
    const size_t shape = mode - c.columnCount();
    for (uint32_t e = expressions.begin(shape); e < expressions.ends[shape]; ++e) nodes[expressions.nodes[e]] = expressions.offsetsM[e];
}

/** Offsets of the vertices, metres, by those of the nodes. */
void moveBy(const PoseCorrectiveData& c, std::span<const Vec3f> nodes, std::vector<Vec3f>& moved) {
    moved.assign(c.nodeWeights.size(), Vec3f(0));
    for (size_t v = 0; v < moved.size(); ++v)
        for (int k = 0; k < 4; ++k) moved[v] += float(c.nodeWeights[v][k]) * (1.0f / 255) * nodes[c.nodeIndices[v][k]];
}

/** Sum over the nodes of the difference between their weights at two vertices. */
double nodesApart(const PoseCorrectiveData& c, uint32_t a, uint32_t b) {
    const auto weightAt = [&](uint32_t v, uint32_t node) {
        int sum = 0;
        for (int k = 0; k < 4; ++k) sum += c.nodeIndices[v][k] == node ? int(c.nodeWeights[v][k]) : 0;
        return sum;
    };
    const auto firstOf = [&](uint32_t v, int slot) {
        for (int k = 0; k < slot; ++k)
            if (c.nodeIndices[v][k] == c.nodeIndices[v][slot]) return false;
        return true;
    };
    int sum = 0;
    for (int k = 0; k < 4; ++k) {
        if (const uint32_t node = c.nodeIndices[a][k]; firstOf(a, k)) sum += std::abs(weightAt(a, node) - weightAt(b, node));
        if (const uint32_t node = c.nodeIndices[b][k]; firstOf(b, k) && weightAt(a, node) == 0) sum += weightAt(b, node);
    }
    return double(sum) / 255;
}

bool addsUp(const std::vector<glm::u8vec4>& weights) {
    return std::all_of(weights.begin(), weights.end(), [](const glm::u8vec4& w) { return int(w.x) + w.y + w.z + w.w == 255; });
}

}  // namespace

ComponentMap componentsOf(const AvatarData& avatar) {
    const MeshData& mesh = avatar.mesh;
    const std::vector<uint8_t> regions = regionsOf(avatar.joints);
    ComponentMap map;
    map.ofVertex.assign(mesh.restPositions.size(), 0);
    map.ofLayer.assign(mesh.layers.size(), 0);
    std::map<std::pair<size_t, uint8_t>, uint32_t> numbers;
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        const size_t layer = layerOf(mesh, t);
        uint8_t region = kTrunk;
        if (layer == mesh.layers.size() || mesh.layers[layer].role == "body") {
            std::array<int, 6> share{};
            for (int corner = 0; corner < 3; ++corner)
                for (int k = 0; k < 4; ++k)
                    if (const int w = mesh.jointWeights[mesh.triangles[t][corner]][k]; w > 0)
                        share[regions[mesh.jointIndices[mesh.triangles[t][corner]][k]]] += w;
            region = uint8_t(std::max_element(share.begin(), share.end()) - share.begin());
        }
        const auto [it, isNew] = numbers.try_emplace({layer, region}, std::min(map.count, kMaxComponents - 1));
        if (isNew && map.count < kMaxComponents) ++map.count;
        map.ofTriangle.push_back(uint8_t(it->second));
        if (layer < mesh.layers.size()) map.ofLayer[layer] |= 1u << it->second;
        for (int corner = 0; corner < 3; ++corner) map.ofVertex[mesh.triangles[t][corner]] |= 1u << it->second;
    }
    for (uint32_t& bits : map.ofVertex)
        if (bits == 0) bits = ~0u;
    return map;
}

Components::Components(const AvatarData& avatar, const ComponentMap& map, std::span<const TriangleReach> reach) {
    const MeshData& mesh = avatar.mesh;
    ofLayer_ = map.ofLayer;
    if (!addsUp(mesh.jointWeights) || !addsUp(avatar.correctives.nodeWeights)) return;
    struct Growing {
        std::vector<Box> boxes;  // one a joint
        std::map<std::pair<uint32_t, uint32_t>, std::pair<Box, Crease>> creases;
    };
    std::vector<Growing> growing(map.count);
    components_.resize(map.count);
    std::vector<Vec3f> stretch(mesh.triangles.size(), Vec3f(0));  // x, y: norms of the rows of D⁻¹ times the reach; z: 1 for overshoot
    for (Growing& g : growing) g.boxes.resize(avatar.joints.size());
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Triangle corners = mesh.triangles[t];
        Component& c = components_[map.ofTriangle[t]];
        Growing& g = growing[map.ofTriangle[t]];
        Vec3d rest[3];
        for (int corner = 0; corner < 3; ++corner) {
            rest[corner] = Vec3d(mesh.restPositions[corners[corner]]);
            for (int k = 0; k < 4; ++k)
                if (mesh.jointWeights[corners[corner]][k] > 0) g.boxes[mesh.jointIndices[corners[corner]][k]].add(rest[corner]);
        }
        if (reach[t].rootLevel == 0) continue;  // all of its splats are invisible
        const auto frame = restTriangle<double>(rest[0], rest[1], rest[2]);
        if (!frame.valid) continue;
        // Bound of the stretch of F = [d1 d2] D⁻¹ (docs/reference/gate.md). A posed edge is d_i = (Σ_j w_0j R_j)(x_i − x_0) +
        // Σ_j (w_ij − w_0j) G_j x_i, with the weights w_0j of corner 0. The first term cannot stretch. The second grows with the distance
        // by which joints carry a point apart. The norms of the rows of D⁻¹ turn that into a stretch of F.
        const double row[3] = {0, std::hypot(frame.inverse.i00, frame.inverse.i01), std::abs(frame.inverse.i11)};
        const double over = reach[t].overshoots ? 1 : 0;
        c.rootLevel = std::max(c.rootLevel, double(reach[t].rootLevel));
        c.reachM = std::max(c.reachM, double(reach[t].reachM));
        c.overM = std::max(c.overM, over * (glm::length(rest[1] - rest[0]) + glm::length(rest[2] - rest[0])));
        stretch[t] = {float(row[1] * double(reach[t].reachM)), float(row[2] * double(reach[t].reachM)), float(over)};
        uint32_t main = mesh.jointIndices[corners[0]][0];
        double most = -1;
        for (int k = 0; k < 4; ++k)
            if (const uint32_t joint = mesh.jointIndices[corners[0]][k];
                mesh.jointWeights[corners[0]][k] > 0 && weightOf(mesh, corners[0], joint) > most)
                main = joint, most = weightOf(mesh, corners[0], joint);
        struct Apart {
            uint32_t joint = 0;
            double reach = 0, over = 0;  // over both edges: Σ |w_ij − w_0j| · row, and Σ |w_ij − w_0j|
        };
        std::array<Apart, 12> apart;
        size_t joints = 0;
        for (int i = 1; i <= 2; ++i) {
            for (const uint32_t vertex : {corners[0], corners[i]})
                for (int k = 0; k < 4; ++k) {
                    const uint32_t joint = mesh.jointIndices[vertex][k];
                    if (mesh.jointWeights[vertex][k] == 0 || joint == main) continue;
                    bool counted = false;  // for this edge
                    for (int other = 0; other < k; ++other)
                        counted |= mesh.jointIndices[vertex][other] == joint && mesh.jointWeights[vertex][other] > 0;
                    if (vertex == corners[i])
                        for (int other = 0; other < 4; ++other)
                            counted |= mesh.jointIndices[corners[0]][other] == joint && mesh.jointWeights[corners[0]][other] > 0;
                    if (counted) continue;
                    const double difference = std::abs(weightOf(mesh, corners[i], joint) - weightOf(mesh, corners[0], joint));
                    if (!(difference > 0)) continue;
                    const auto end = apart.begin() + ptrdiff_t(joints),
                               at = std::find_if(apart.begin(), end, [&](const Apart&a) { return a.joint == joint; });
                    if (at == end) *at = {joint, 0, 0}, ++joints;
                    at->reach += difference * row[i], at->over += difference;
                }
        }
        // unseen() takes the largest crease, but a triangle on n creases stretches by their sum. That is at most n times the largest, so
        // each counts n-fold.
        for (size_t k = 0; k < joints; ++k) {
            auto& [box, crease] = g.creases[{apart[k].joint, main}];
            box.add(rest[1]), box.add(rest[2]);
            crease.reachPerM = std::max(crease.reachPerM, apart[k].reach * double(joints) * double(reach[t].reachM));
            crease.overPerM = std::max(crease.overPerM, over * apart[k].over * double(joints));
        }
    }
    std::vector<Vec3f> nodes, moved;
    for (size_t m = 0; m < avatar.correctives.columnCount() + avatar.expressions.shapes.size(); ++m) {
        nodesOf(avatar.correctives, avatar.expressions, m, nodes);
        moveBy(avatar.correctives, nodes, moved);
        for (Component& c : components_) c.modes.push_back({});
        for (size_t t = 0; t < mesh.triangles.size(); ++t) {
            const Vec3f &a = moved[mesh.triangles[t].x], &b = moved[mesh.triangles[t].y], &c = moved[mesh.triangles[t].z];
            const double apart1 = glm::length(b - a), apart2 = glm::length(c - a);
            Mode& mode = components_[map.ofTriangle[t]].modes.back();
            mode.offsetM = std::max({mode.offsetM, double(glm::length(a)), double(glm::length(b)), double(glm::length(c))});
            mode.reachM = std::max(mode.reachM, apart1 * double(stretch[t].x) + apart2 * double(stretch[t].y)),
            mode.overM = std::max(mode.overM, (apart1 + apart2) * double(stretch[t].z));
        }
    }
    for (size_t t = 0; t < mesh.triangles.size() && !avatar.correctives.empty(); ++t) {
        const Triangle& corners = mesh.triangles[t];
        const double apart1 = nodesApart(avatar.correctives, corners.x, corners.y),
                     apart2 = nodesApart(avatar.correctives, corners.x, corners.z);
        Mode& pushed = components_[map.ofTriangle[t]].pushed;
        pushed.offsetM = 1;
        pushed.reachM = std::max(pushed.reachM, apart1 * double(stretch[t].x) + apart2 * double(stretch[t].y));
        pushed.overM = std::max(pushed.overM, (apart1 + apart2) * double(stretch[t].z));
    }
    for (uint32_t i = 0; i < map.count; ++i) {
        for (uint32_t joint = 0; joint < avatar.joints.size(); ++joint)
            if (const Box& box = growing[i].boxes[joint]; box.low.x <= box.high.x)
                components_[i].boxes.push_back({joint, box.centre(), box.half()});
        for (auto& [joints, what] : growing[i].creases) {
            auto& [box, crease] = what;
            crease.at = {joints.first, box.centre(), box.half()}, crease.against = joints.second;
            components_[i].creases.push_back(crease);
        }
    }
}

uint32_t Components::unseen(std::span<const Mat3x4f> worldFromRest, std::span<const float> coefficients, std::span<const Cameraf> views,
                            float kappaPx2, float growth, float scale, float pushedM) const {
    const auto carried = [&](uint32_t joint, const Vec3d& p) {
        const Mat3x4f& m = worldFromRest[joint];
        return Vec3d(m[0]) * p.x + Vec3d(m[1]) * p.y + Vec3d(m[2]) * p.z + Vec3d(m[3]);
    };
    /** Spectral norm of the difference of two rotations, which is its Frobenius norm / √2, plus 1e-5 for float rounding. */
    const auto turned = [&](uint32_t a, uint32_t b) {
        double sum = 0;
        for (int k = 0; k < 3; ++k) {
            const Vec3d d = Vec3d(worldFromRest[a][k]) - Vec3d(worldFromRest[b][k]);
            sum += glm::dot(d, d);
        }
        return std::sqrt(0.5 * sum) + 1e-5;
    };
    uint32_t bits = 0;
    for (uint32_t i = 0; i < count(); ++i) {
        const Component& c = components_[i];
        double offset = 0, reachM = c.reachM, overM = c.overM;
        for (size_t m = 0; m < std::min(c.modes.size(), coefficients.size()); ++m) {
            const double k = std::abs(double(coefficients[m]));
            offset += k * c.modes[m].offsetM, reachM += k * c.modes[m].reachM, overM += k * c.modes[m].overM;
        }
        const double pushed = double(pushedM);
        offset += pushed * c.pushed.offsetM, reachM += pushed * c.pushed.reachM, overM += pushed * c.pushed.overM;
        double reachShare = 0, overShare = 0;  // metres, added by creases
        const auto shownIn = [&](const Cameraf& view) {
            const double reach = double(growth) * (reachM + reachShare), over = overM + overShare;
            const JacobianClamp<double> limit(view.cast<double>());
            const Vec2d focal(view.fx, view.fy), centre(view.cx, view.cy),
                slope(std::max(std::abs(limit.minX), std::abs(limit.maxX)), std::max(std::abs(limit.minY), std::abs(limit.maxY)));
            const Vec2d margin = c.rootLevel * std::sqrt(double(kappaPx2)) + double(kCoverageReachPx) + 0.02 + 1e-5 * focal;
            const Vec2d low = centre + margin, high = Vec2d(view.widthPx, view.heightPx) - centre + margin;  // as formulas/cull.inl
            const Vec2d splat = 1.001 * reach * focal * glm::sqrt(1.0 + slope * slope);
            struct Side {
                Vec3d inwards;   // normal in view space, not of unit length
                double bySplat;  // how far beyond the side a centre may lie while its splat shows, in units of dot(inwards, point)
            };
            const Side sides[] = {{{0, 0, 1}, -kNearM / double(scale)},
                                  {{focal.x, 0, low.x}, splat.x},
                                  {{-focal.x, 0, high.x}, splat.x},
                                  {{0, focal.y, low.y}, splat.y},
                                  {{0, -focal.y, high.y}, splat.y}};
            for (const Side& side : sides) {
                const Vec3d normal = glm::transpose(Mat3d(view.viewFromWorldRotation)) * side.inwards;
                const double start = glm::dot(side.inwards, Vec3d(view.viewFromWorldTranslation)) + side.bySplat,
                             length = glm::length(normal);
                const auto outside = [&](const Corners& box) {
                    const Vec3d p = carried(box.joint, box.centre);
                    double support = 0;
                    for (int k = 0; k < 3; ++k) support += std::abs(glm::dot(normal, Vec3d(worldFromRest[box.joint][k]))) * box.half[k];
                    const double rounding = 1e-5 * (1 + glm::length(p) + glm::length(Vec3d(worldFromRest[box.joint][3])) +
                                                    glm::length(Vec3d(view.viewFromWorldTranslation)));
                    return start + glm::dot(normal, p) + support * 1.0001 + length * (offset + over + rounding) <= 0;
                };
                if (std::all_of(c.boxes.begin(), c.boxes.end(), outside)) return false;
            }
            return true;
        };
        if (std::any_of(views.begin(), views.end(), shownIn)) continue;  // creases only enlarge it, so most components need none of them
        for (const Crease& k : c.creases) {
            const double apart = glm::length(carried(k.at.joint, k.at.centre) - carried(k.against, k.at.centre)) +
                                 (glm::length(k.at.half) + offset) * turned(k.at.joint, k.against);
            reachShare = std::max(reachShare, k.reachPerM * apart), overShare = std::max(overShare, k.overPerM * apart);
        }
        if (std::none_of(views.begin(), views.end(), shownIn)) bits |= 1u << i;
    }
    return bits;
}

}  // namespace dpl
