// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/cloth_clearance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "sdk/avatar/humanoid.h"
#include "sdk/avatar/motion_memory.h"

namespace dpl {
namespace {

constexpr float kTouchM = 0.005f;    // cloth that hangs farther from a tube may come as near as this
constexpr float kGiveM = 0.01f;      // cloth may sink so much deeper, because a tube is as wide as the widest place of each cell
constexpr float kHears = 0.01f;      // a node is pushed by tubes of joints with this share of its weights, and of their children
constexpr float kMostApart = 0.15f;  // of two neighbours' distance: by how much they may be pushed apart, as for *moved*
constexpr int kPushSweeps = 2;
constexpr size_t kMostTubes = 12;     // trunk and limbs
constexpr float kLeastVolume = 0.1f;  // of a blend of joints, to be inverted

std::vector<BodyTube> limbTubes(std::span<const JointData> joints, const MeshData& mesh, const LayerData& body) {
    std::vector<BodyTube> tubes;
    const BoneMap bones = bonesOf(joints);
    const auto add = [&](const std::string& bone, std::initializer_list<std::string> next) {
        const auto joint = findBone(bones, bone);
        if (!joint) return;
        for (const std::string& to : next)
            if (const auto target = findBone(bones, to)) {
                auto tube =
                    BodyTube::of(joints, mesh, body.firstVertex, body.firstVertex + body.vertexCount, *joint, joints[*target].restPosition);
                if (tube) tubes.push_back(std::move(*tube));
                return;
            }
    };
    add("hips", {"spine", "chest", "neck", "head"}), add("spine", {"chest", "upperChest", "neck", "head"});
    add("chest", {"upperChest", "neck", "head"}), add("upperChest", {"neck", "head"});
    for (const std::string side : {"left", "right"}) {
        add(side + "UpperLeg", {side + "LowerLeg"}), add(side + "LowerLeg", {side + "Foot"});
        add(side + "UpperArm", {side + "LowerArm"}), add(side + "LowerArm", {side + "Hand"});
    }
    return tubes;
}

/** The longest offset that a column gives the node in training, metres. */
float longestOffsetM(const PoseCorrectiveData& c, uint32_t node) {
    const Vec4f* row = c.nodes.data() + size_t(node) * c.columnCount();
    float longest = 0;
    for (uint32_t i = 0; i < c.modeCount; ++i) longest = std::max(longest, c.reach * glm::length(Vec3f(row[i])));
    uint32_t column = c.modeCount;
    for (const MotionGroupData& group : c.motion.groups)
        for (uint32_t i = 0; i < group.columnCount; ++i, ++column)
            longest = std::max(longest, group.reach * glm::length(Vec3f(row[column])));
    return longest;
}

}  // namespace

ClothClearance::ClothClearance(std::span<const JointData> joints, const MeshData& mesh, const PoseCorrectiveData& c) {
    if (c.empty() || c.motion.empty()) return;
    const auto body = std::find_if(mesh.layers.begin(), mesh.layers.end(), [](const LayerData& l) { return l.role == "body"; });
    if (body == mesh.layers.end()) return;
    tubes_ = limbTubes(joints, mesh, *body);
    if (tubes_.empty()) return;
    for (const LayerData& layer : mesh.layers)
        if (layer.role == "garment") addLayer(mesh, layer, c, joints);
}

void ClothClearance::addLayer(const MeshData& mesh, const LayerData& layer, const PoseCorrectiveData& c,
                              std::span<const JointData> joints) {
    struct Users {  // the layer's vertices that use a node
        float weight = 0;
        Vec3f rest{0};
        std::vector<float> joints;
    };
    std::vector<Users> users(c.nodeCount);
    for (uint32_t v = layer.firstVertex; v < layer.firstVertex + layer.vertexCount; ++v)
        for (int i = 0; i < 4; ++i) {
            if (c.nodeWeights[v][i] == 0) continue;
            const float w = float(c.nodeWeights[v][i]) / 255;
            Users& u = users[c.nodeIndices[v][i]];
            u.joints.resize(joints.size());
            u.weight += w, u.rest += w * mesh.restPositions[v];
            for (int k = 0; k < 4; ++k) u.joints[mesh.jointIndices[v][k]] += w * float(mesh.jointWeights[v][k]) / 255;
        }
    const size_t first = nodes_.size();
    float longestM = 0;
    for (uint32_t n = 0; n < c.nodeCount; ++n) {
        Users& u = users[n];
        if (!(u.weight > 0)) continue;
        longestM = std::max(longestM, longestOffsetM(c, n));
        Node node;
        node.index = n, node.rest = u.rest / u.weight, node.firstNear = uint32_t(near_.size());
        for (uint32_t t = 0; t < tubes_.size(); ++t) {
            const int32_t parent = joints[tubes_[t].joint].parent;
            const float least = kHears * u.weight;
            if (!(u.joints[tubes_[t].joint] >= least || (parent >= 0 && u.joints[size_t(parent)] >= least))) continue;
            const auto place = tubes_[t].placeOf(tubes_[t].localOf(node.rest));
            const float at = place ? std::min(place->distanceM - place->radiusM, kTouchM) : kTouchM;
            near_.push_back({t, at - kGiveM});
        }
        node.lastNear = uint32_t(near_.size());
        if (node.lastNear == node.firstNear) continue;
        for (int k = 0; k < 4; ++k) {
            const auto most = std::max_element(u.joints.begin(), u.joints.end());
            node.joints[k] = uint16_t(most - u.joints.begin()), node.weights[k] = *most;
            *most = 0;
        }
        node.weights /= node.weights.x + node.weights.y + node.weights.z + node.weights.w;
        nodes_.push_back(node);
    }
    for (size_t n = first; n < nodes_.size(); ++n) nodes_[n].mostM = float(kMostMotionOverReach) * longestM;
    addPairs(mesh, layer, c, first);
}

void ClothClearance::addPairs(const MeshData& mesh, const LayerData& layer, const PoseCorrectiveData& c, size_t firstNode) {
    constexpr uint32_t kNone = ~0u;
    std::vector<uint32_t> at(c.nodeCount, kNone);
    for (size_t n = firstNode; n < nodes_.size(); ++n) at[nodes_[n].index] = uint32_t(n);
    std::vector<std::pair<uint32_t, uint32_t>> both;
    for (uint32_t v = layer.firstVertex; v < layer.firstVertex + layer.vertexCount; ++v)
        for (int i = 0; i < 4; ++i)
            for (int k = 0; k < 4; ++k) {
                const uint32_t a = at[c.nodeIndices[v][i]], b = at[c.nodeIndices[v][k]];
                if (c.nodeWeights[v][i] > 0 && c.nodeWeights[v][k] > 0 && a < b && b != kNone) both.push_back({a, b});
            }
    std::sort(both.begin(), both.end());
    both.erase(std::unique(both.begin(), both.end()), both.end());
    for (const auto& [a, b] : both) pairs_.push_back({a, b, kMostApart * glm::length(nodes_[a].rest - nodes_[b].rest)});
}

uint64_t ClothClearance::bytes() const {
    uint64_t sum = near_.size() * sizeof(Near) + nodes_.size() * sizeof(Node) + pairs_.size() * sizeof(Pair);
    for (const BodyTube& tube : tubes_) sum += sizeof tube + tube.radiiM.size() * sizeof(float);
    return sum;
}

Mat3x4f ClothClearance::carryOf(const Node& node, std::span<const Mat3x4f> worldFromRest) const {
    Mat3x4f blend(0);
    for (int k = 0; k < 4; ++k) blend += node.weights[k] * worldFromRest[node.joints[k]];
    return blend;
}

float ClothClearance::push(std::span<const Mat3x4f> worldFromRest, std::span<Vec4f> nodes, std::vector<Vec3f>& pushes) const {
    pushes.assign(nodes_.size(), Vec3f(0));
    struct Frame {  // of a tube, in the world
        Vec3f from, along, across, third;
        float beginM, endM, widestM;  // beyond these there is nothing of it
    };
    std::array<Frame, kMostTubes> frames;
    for (size_t t = 0; t < tubes_.size(); ++t) {
        const BodyTube& tube = tubes_[t];
        const Mat3x4f& g = worldFromRest[tube.joint];
        const Mat3f turn(g);
        frames[t] = {g * Vec4f(tube.from, 1),
                     turn * tube.along,
                     turn * tube.across,
                     turn * tube.third,
                     tube.beginM - BodyTube::kTaperM,
                     tube.endM + BodyTube::kTaperM,
                     *std::max_element(tube.widestM.begin(), tube.widestM.end())};
    }
    bool any = false;
    for (size_t n = 0; n < nodes_.size(); ++n) {
        const Node& node = nodes_[n];
        const Vec3f skinned = carryOf(node, worldFromRest) * Vec4f(node.rest + Vec3f(nodes[node.index]), 1);
        Vec3f at = skinned;
        for (uint32_t i = node.firstNear; i < node.lastNear; ++i) {  // one after the other: a knee has two
            const Frame& frame = frames[near_[i].tube];
            const Vec3f p = at - frame.from;
            const float along = glm::dot(p, frame.along), widest = frame.widestM + near_[i].leastM;
            if (!(along >= frame.beginM && along <= frame.endM)) continue;                                          // nor what is no number
            if (const Vec3f off = p - along * frame.along; glm::dot(off, off) > 1.01f * widest * widest) continue;  // most end here
            const Vec3f local(along, glm::dot(p, frame.across), glm::dot(p, frame.third));
            const auto place = tubes_[near_[i].tube].placeOf(local, near_[i].leastM);
            if (!place) continue;
            const float depth = place->share * (place->radiusM + near_[i].leastM - place->distanceM);
            if (depth > 0) at += depth / place->distanceM * (frame.across * local.y + frame.third * local.z), any = true;
        }
        pushes[n] = at - skinned;
    }
    if (!any) return 0;
    for (int sweep = 0; sweep < kPushSweeps; ++sweep)
        for (const Pair& pair : pairs_) {
            const Vec3f apart = pushes[pair.a] - pushes[pair.b];
            const float length2 = glm::dot(apart, apart);
            if (!(length2 > pair.mostApartM * pair.mostApartM)) continue;
            const Vec3f step = 0.5f * (1 - pair.mostApartM / std::sqrt(length2)) * apart;
            pushes[pair.a] -= step, pushes[pair.b] += step;
        }
    float most = 0;
    for (size_t n = 0; n < nodes_.size(); ++n) {
        if (pushes[n] == Vec3f(0)) continue;
        const Node& node = nodes_[n];
        const Mat3f blend(carryOf(node, worldFromRest));
        if (!(glm::determinant(blend) > kLeastVolume)) continue;  // limbs that turn cloth inside out
        Vec4f& value = nodes[node.index];
        const Vec3f before(value);
        Vec3f offset = before + glm::inverse(blend) * pushes[n];
        const float length = glm::length(offset), limit = std::max(node.mostM, glm::length(before));
        if (length > limit) offset *= limit / length;
        value = Vec4f(offset, value.w);
        most = std::max(most, glm::length(offset - before));
    }
    return most;
}

}  // namespace dpl
