// SPDX-License-Identifier: Apache-2.0
// Garment nodes within their limits, in double precision (docs/reference/correctives.md, "Clearance", "Strain").
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "apps/reference/reference_renderer.h"

namespace dpl {
namespace {

constexpr double kTurn = 2 * 3.14159265358979323846;
constexpr int kRings = 10, kSectors = 24;
constexpr double kFadeM = 0.03, kKeptM = 0.005, kHeard = 0.01, kSinks = 0.01, kApartShare = 0.15, kBeyond = 1.3, kThinnest = 0.1,
                 kStrain = 0.6, kFilmed = 0.3;

struct Tube {
    uint32_t joint;
    glm::dvec3 from, along, across, third;
    double begin, end;
    std::array<std::array<double, kSectors>, kRings> radius;

    double radiusAt(double along01, double turns) const {
        const double ring = std::clamp(along01 * kRings - 0.5, 0.0, kRings - 1.0), sector = (turns + 1.5) * kSectors - 0.5;
        const int r = int(ring), s = int(std::floor(sector));
        double sum = 0;
        for (int i = 0; i < 2; ++i)
            for (int j = 0; j < 2; ++j)
                sum += (i ? ring - r : 1 - (ring - r)) * (j ? sector - s : 1 - (sector - s)) *
                       radius[size_t(std::min(r + i, kRings - 1))][size_t((s + j) % kSectors)];
        return sum;
    }
    /** How deep a point at rest lies in the tube widened by `more`, faded beyond its ends; and the way out. */
    struct Depth {
        bool touches = false;
        double outside = 0, fade = 0;  // distance from the surface
        glm::dvec3 out{0};
    };
    Depth depthOf(const glm::dvec3& point) const {
        const glm::dvec3 p = point - from;
        const double a = glm::dot(p, along), x = glm::dot(p, across), y = glm::dot(p, third), distance = std::hypot(x, y);
        Depth d;
        d.fade = std::min({(a - begin) / kFadeM + 1, (end - a) / kFadeM + 1, 1.0});
        if (d.fade <= 0 || distance < 1e-4) return d;
        const double width = radiusAt((a - begin) / (end - begin), std::atan2(y, x) / kTurn);
        if (width <= 0) return d;
        d.touches = true, d.outside = distance - width, d.out = (x * across + y * third) / distance;
        return d;
    }
};

std::vector<Tube> tubesOf(const AvatarData& avatar, const LayerData& body) {
    using Names = std::vector<std::string>;
    std::vector<std::pair<std::string, Names>> wanted = {{"hips", {"spine", "chest", "neck", "head"}},
                                                         {"spine", {"chest", "upperChest", "neck", "head"}},
                                                         {"chest", {"upperChest", "neck", "head"}},
                                                         {"upperChest", {"neck", "head"}}};
    for (const std::string side : {"left", "right"})
        for (const auto& [bone, next] :
             {std::pair("UpperLeg", "LowerLeg"), {"LowerLeg", "Foot"}, {"UpperArm", "LowerArm"}, {"LowerArm", "Hand"}})
            wanted.push_back({side + bone, Names{side + next}});
    const auto jointOf = [&](const std::string& bone) {
        for (uint32_t j = 0; j < avatar.joints.size(); ++j)
            if (avatar.joints[j].humanoidBone == bone) return int(j);
        return -1;
    };
    std::vector<Tube> tubes;
    for (const auto& [bone, names] : wanted) {
        const int joint = jointOf(bone);
        const auto next = std::find_if(names.begin(), names.end(), [&](const std::string& name) { return jointOf(name) >= 0; });
        if (joint < 0 || next == names.end()) continue;
        Tube t{};
        t.joint = uint32_t(joint), t.from = glm::dvec3(avatar.joints[size_t(joint)].restPosition);
        const glm::dvec3 bonePart = glm::dvec3(avatar.joints[size_t(jointOf(*next))].restPosition) - t.from;
        if (!(glm::length(bonePart) > 0.01)) continue;
        t.along = glm::normalize(bonePart);
        const glm::dvec3 side = std::abs(t.along.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
        t.across = glm::normalize(side - t.along * glm::dot(side, t.along)), t.third = glm::cross(t.along, t.across);
        std::vector<glm::dvec3> own;
        for (uint32_t v = body.firstVertex; v < body.firstVertex + body.vertexCount; ++v)
            for (int k = 0; k < 4; ++k)
                if (avatar.mesh.jointWeights[v][k] >= 128) {
                    if (avatar.mesh.jointIndices[v][k] == t.joint) own.push_back(glm::dvec3(avatar.mesh.restPositions[v]) - t.from);
                    break;
                }
        if (own.size() < 12) continue;
        t.begin = t.end = glm::dot(own[0], t.along);
        for (const glm::dvec3& p : own) t.begin = std::min(t.begin, glm::dot(p, t.along)), t.end = std::max(t.end, glm::dot(p, t.along));
        if (t.end - t.begin < 0.01) continue;
        auto seen = t.radius = {};
        for (const glm::dvec3& p : own) {
            const double x = glm::dot(p, t.across), y = glm::dot(p, t.third);
            const int ring = std::min(int((glm::dot(p, t.along) - t.begin) / (t.end - t.begin) * kRings), kRings - 1);
            double& cell = seen[size_t(ring)][size_t((std::atan2(y, x) / kTurn + 1.5) * kSectors) % kSectors];
            cell = std::max(cell, std::hypot(x, y));
        }
        t.radius = seen;
        for (size_t r = 0; r < kRings; ++r)
            for (int s = 0; s < kSectors; ++s)
                for (const int way : {1, -1})
                    for (int n = 1; n <= kSectors / 4 && seen[r][size_t(s)] == 0; ++n)
                        if (const double other = seen[r][size_t((s + way * n + kSectors) % kSectors)]; other > 0) {
                            t.radius[r][size_t(s)] += other / 2;
                            break;
                        }
        tubes.push_back(t);
    }
    return tubes;
}

/** By how much two nodes may differ, metres: an edge whose weights go over from nodes to others by `share` strains by at most share times
 *  their largest difference. */
std::map<std::pair<uint32_t, uint32_t>, double> mostApart(const AvatarData& avatar) {
    const PoseCorrectiveData& c = avatar.correctives;
    const size_t columns = c.nodes.size() / c.nodeCount;
    std::map<std::pair<uint32_t, uint32_t>, double> limits;
    for (const LayerData& layer : avatar.mesh.layers)
        for (uint32_t t = layer.firstTriangle; layer.role == "garment" && t < layer.firstTriangle + layer.triangleCount; ++t)
            for (int k = 0; k < 3; ++k) {
                const uint32_t from = avatar.mesh.triangles[t][k], to = avatar.mesh.triangles[t][(k + 1) % 3];
                const double length = glm::length(glm::dvec3(avatar.mesh.restPositions[from]) - glm::dvec3(avatar.mesh.restPositions[to]));
                std::map<uint32_t, double> gained;
                double share = 0;
                for (int i = 0; i < 4; ++i) {
                    gained[c.nodeIndices[to][i]] += c.nodeWeights[to][i] / 255.0;
                    gained[c.nodeIndices[from][i]] -= c.nodeWeights[from][i] / 255.0;
                }
                for (const auto& [node, weight] : gained) share += std::max(0.0, weight);
                for (const auto& [a, gain] : gained)
                    for (const auto& [b, loss] : gained) {
                        if (length < 1e-4 || gain < 1e-9 || loss > -1e-9) continue;
                        const auto learned = [&](uint32_t node, size_t i) { return glm::vec3(c.nodes[node * columns + i]); };
                        bool same = true;
                        for (size_t i = 0; i < columns; ++i) same = same && learned(a, i) == learned(b, i);
                        if (same) continue;
                        const auto known = limits.try_emplace({std::min(a, b), std::max(a, b)}, kStrain * length / share).first;
                        known->second = std::min(known->second, kStrain * length / share);
                    }
            }
    return limits;
}

/** drawn: share of the pose correctives; in poses of the film offsets are as they were learned. */
std::vector<glm::dvec3> eased(const AvatarData& avatar, double drawn, std::vector<glm::dvec3> offsets) {
    if (drawn / kFilmed >= 0.99) return offsets;
    const auto limits = mostApart(avatar);
    for (int sweep = 0; sweep < 2; ++sweep)
        for (const auto& [nodes, learned] : limits) {
            const double most = learned / (1 - drawn / kFilmed);
            glm::dvec3 &a = offsets[nodes.first], &b = offsets[nodes.second];
            const glm::dvec3 apart = a - b;
            if (glm::length(apart) <= most) continue;
            const glm::dvec3 step = 0.5 * (1 - most / glm::length(apart)) * apart;
            a -= step, b += step;
        }
    return offsets;
}

std::vector<glm::dvec3> pushedOut(const AvatarData& avatar, const Pose& pose, const std::vector<glm::dvec3>& offsets) {
    const PoseCorrectiveData& c = avatar.correctives;
    const MeshData& mesh = avatar.mesh;
    std::vector<glm::dvec3> out = offsets;
    const auto body = std::find_if(mesh.layers.begin(), mesh.layers.end(), [](const LayerData& l) { return l.role == "body"; });
    if (c.motion.groups.empty() || body == mesh.layers.end()) return out;
    const std::vector<Tube> tubes = tubesOf(avatar, *body);
    const std::vector<glm::dmat4> joints = referenceJointTransforms(avatar.joints, pose);
    const size_t columns = c.nodes.size() / c.nodeCount;
    std::vector<double> reach(c.modeCount, double(c.reach));
    for (const MotionGroupData& group : c.motion.groups) reach.insert(reach.end(), group.columnCount, double(group.reach));
    for (const LayerData& layer : mesh.layers) {
        if (layer.role != "garment") continue;
        struct Node {
            double weight = 0, longest = 0;
            glm::dvec3 rest{0}, push{0};
            std::map<uint32_t, double> joints;  // shares
            glm::dmat4 carry{0};
        };
        std::map<uint32_t, Node> nodes;
        std::set<std::pair<uint32_t, uint32_t>> neighbours;
        for (uint32_t v = layer.firstVertex; v < layer.firstVertex + layer.vertexCount; ++v)
            for (int i = 0; i < 4; ++i) {
                if (c.nodeWeights[v][i] == 0) continue;
                const double w = c.nodeWeights[v][i] / 255.0;
                Node& n = nodes[c.nodeIndices[v][i]];
                n.weight += w, n.rest += w * glm::dvec3(mesh.restPositions[v]);
                for (int k = 0; k < 4; ++k) n.joints[mesh.jointIndices[v][k]] += w * mesh.jointWeights[v][k] / 255.0;
                for (int k = 0; k < 4; ++k)
                    if (c.nodeWeights[v][k] > 0 && c.nodeIndices[v][i] < c.nodeIndices[v][k])
                        neighbours.insert({c.nodeIndices[v][i], c.nodeIndices[v][k]});
            }
        double longest = 0;
        for (auto& [index, n] : nodes)
            for (size_t i = 0; i < columns; ++i)
                longest = std::max(longest, reach[i] * glm::length(glm::dvec3(c.nodes[index * columns + i])));
        std::set<uint32_t> hearing;
        for (auto& [index, n] : nodes) {
            n.rest /= n.weight;
            std::vector<std::pair<double, uint32_t>> order;
            for (auto& [joint, share] : n.joints) share /= n.weight, order.push_back({-share, joint});
            std::sort(order.begin(), order.end());
            order.resize(std::min<size_t>(order.size(), 4));
            double sum = 0;
            for (const auto& [share, joint] : order) n.carry += -share * joints[joint], sum -= share;
            n.carry /= sum;
            const glm::dvec3 skinned(n.carry * glm::dvec4(n.rest + offsets[index], 1));
            glm::dvec3 at = skinned;
            const auto heard = [&shares = n.joints](int64_t joint) {
                const auto found = joint < 0 ? shares.end() : shares.find(uint32_t(joint));
                return found != shares.end() && found->second >= kHeard;
            };
            for (const Tube& t : tubes) {
                if (!heard(t.joint) && !heard(avatar.joints[t.joint].parent)) continue;
                hearing.insert(index);
                const Tube::Depth still = t.depthOf(n.rest);
                const double kept = (still.touches ? std::min(still.outside, kKeptM) : kKeptM) - kSinks;
                const Tube::Depth now = t.depthOf(glm::dvec3(glm::inverse(joints[t.joint]) * glm::dvec4(at, 1)));
                if (now.touches && now.outside < kept) at += now.fade * (kept - now.outside) * (glm::dmat3(joints[t.joint]) * now.out);
            }
            n.push = at - skinned;
        }
        for (int sweep = 0; sweep < 2; ++sweep)
            for (const auto& [a, b] : neighbours) {
                if (!hearing.count(a) || !hearing.count(b)) continue;
                const glm::dvec3 apart = nodes[a].push - nodes[b].push;
                const double most = kApartShare * glm::length(nodes[a].rest - nodes[b].rest), length = glm::length(apart);
                if (length <= most) continue;
                nodes[a].push -= 0.5 * (1 - most / length) * apart, nodes[b].push += 0.5 * (1 - most / length) * apart;
            }
        for (const auto& [index, n] : nodes) {
            const glm::dmat3 carry(n.carry);
            if (n.push == glm::dvec3(0) || glm::determinant(carry) <= kThinnest) continue;
            const glm::dvec3 wanted = offsets[index] + glm::inverse(carry) * n.push;
            const double limit = std::max(kBeyond * longest, glm::length(offsets[index]));
            out[index] = std::min(1.0, limit / glm::length(wanted)) * wanted;
        }
    }
    return out;
}

}  // namespace

std::vector<glm::dvec3> referenceClothNodes(const AvatarData& avatar, const Pose& pose, double drawn,
                                            const std::vector<glm::dvec3>& offsets) {
    return eased(avatar, drawn, pushedOut(avatar, pose, offsets));
}

}  // namespace dpl
