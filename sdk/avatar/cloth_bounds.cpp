// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/cloth_bounds.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sdk/avatar/stress_poses.h"
#include "sdk/format/skin_weights.h"
#include "sdk/math/skinning.h"

namespace dpl {
namespace {

constexpr float kShortestEdgeM = 1e-4f;
constexpr int kSweeps = 600;         // over all edges; a torn skirt takes some hundred
constexpr float kRelaxation = 1.5f;  // a sweep goes beyond what one edge asks for: half as many are enough
constexpr int kRefineRounds = 20;
// A hostile file costs no more than these: 60 MB, and some seconds of a core.
constexpr size_t kMostVertices = 200000, kMostRowFloats = 5'000'000, kMostVertexSweeps = 10'000'000;
constexpr size_t kMostNeighbours = 32, kMostTries = 2'000'000;

struct Edge {
    uint32_t a, b;
    float restM;
};

/** Edges and neighbours of a piece, in fixed order. */
struct ClothGraph {
    std::vector<Edge> edges;              // rising
    std::vector<uint32_t> start, beside;  // neighbours of vertex v: beside[start[v]] .. beside[start[v + 1]]

    explicit ClothGraph(const ClothPiece& piece) : start(piece.rest.size() + 1, 0) {
        std::vector<std::pair<uint32_t, uint32_t>> pairs;
        for (const Triangle& t : piece.triangles)
            for (int c = 0; c < 3; ++c)
                if (t[c] != t[(c + 1) % 3]) pairs.push_back(std::minmax(t[c], t[(c + 1) % 3]));
        std::sort(pairs.begin(), pairs.end());
        pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
        for (const auto& [a, b] : pairs) {
            ++start[a + 1], ++start[b + 1];
            const float lengthM = glm::length(piece.rest[a] - piece.rest[b]);
            if (lengthM >= kShortestEdgeM) edges.push_back({a, b, lengthM});
        }
        for (size_t v = 1; v < start.size(); ++v) start[v] += start[v - 1];
        beside.resize(2 * pairs.size());
        std::vector<uint32_t> next(start.begin(), start.end() - 1);
        for (const auto& [a, b] : pairs) beside[next[a]++] = b, beside[next[b]++] = a;
    }
    std::span<const uint32_t> around(uint32_t v) const { return {beside.data() + start[v], start[v + 1] - start[v]}; }
};

/** The piece in every pose, and its weights as dense rows that evening changes. */
class Evener {
public:
    Evener(const ClothPiece& piece, std::span<const JointData> joints, std::span<const Pose> poses)
        : piece_(piece), graph_(piece), columnOf_(joints.size(), UINT32_MAX), poses_(poses.size()), moves_(piece.rest.size(), 0) {
        transforms_.resize(poses_);
        for (size_t p = 0; p < poses_; ++p) jointTransforms(joints, poses[p], transforms_[p]);
        for (size_t v = 0; v < piece.rest.size(); ++v)
            for (int k = 0; k < 4; ++k)
                if (piece.jointWeights[v][k] > 0) columnOf_[piece.jointIndices[v][k]] = 0;
        for (uint32_t j = 0; j < joints.size(); ++j)
            if (columnOf_[j] == 0) columnOf_[j] = uint32_t(jointOf_.size()), jointOf_.push_back(j);
        posed_.resize(piece.rest.size() * poses_);
        for (uint32_t v = 0; v < piece.rest.size(); ++v) pose(v);
    }

    float longest() const {
        float longest = 1;
        for (const Edge& e : graph_.edges) longest = std::max(longest, stretchOf(e));
        return longest;
    }
    /** Moves the rows at both ends of every edge beyond `most` towards each other, in the order of the edges, further than brings it there.
     *  Returns whether there was one. Rows stay sums of 1: they are mixed only. */
    bool sweep(float most) {
        if (rows_.empty()) fillRows(), measuredAt_.assign(graph_.edges.size(), UINT32_MAX), stretch_.resize(graph_.edges.size());
        const size_t columns = jointOf_.size();
        bool any = false;
        for (size_t i = 0; i < graph_.edges.size(); ++i) {
            const Edge& e = graph_.edges[i];
            if (const uint32_t moves = moves_[e.a] + moves_[e.b]; measuredAt_[i] != moves)
                measuredAt_[i] = moves, stretch_[i] = stretchOf(e);
            const float stretch = stretch_[i];
            if (!(stretch > most)) continue;
            any = true;
            const float share = std::min(0.5f, 0.5f * kRelaxation * (1 - most / stretch));
            float *a = &rows_[e.a * columns], *b = &rows_[e.b * columns];
            for (size_t c = 0; c < columns; ++c) {
                const float step = share * (a[c] - b[c]);
                a[c] -= step, b[c] += step;
            }
            poseRow(e.a), poseRow(e.b);
            ++moves_[e.a], ++moves_[e.b];
        }
        return any;
    }
    /** Cuts the rows that were moved to four joints each, as files store them. */
    void pack() {
        for (uint32_t v = 0; v < moves_.size(); ++v)
            if (moves_[v] > 0) pack(v), pose(v);
    }
    /** Rounding to 1/255 is coarse beside a long limb. Single such steps, from one joint of a vertex to another of it or its neighbours,
     * mend what it stretches, as long as the longest edge around the vertex becomes shorter. */
    void refine(float most) {
        for (int round = 0; round < kRefineRounds; ++round) {
            bool any = false;
            for (const Edge& e : graph_.edges)
                if (stretchOf(e) > most) any |= refineAt(e.a, most), any |= refineAt(e.b, most);
            if (!any) break;
        }
    }
    /** Sweeps that stay within reason; 0: too large. */
    int sweeps() const {
        const size_t vertices = piece_.rest.size();
        return vertices * jointOf_.size() > kMostRowFloats ? 0 : int(std::min<size_t>(kSweeps, kMostVertexSweeps / vertices));
    }
    /** Vertices whose weights have changed. */
    uint32_t movedCount() const {
        return uint32_t(std::count_if(moves_.begin(), moves_.end(), [](uint32_t n) { return n > 0; }));
    }

private:
    float stretchOf(const Edge& e) const {
        float longest2 = 0;
        const Vec3f *a = &posed_[e.a * poses_], *b = &posed_[e.b * poses_];
        for (size_t p = 0; p < poses_; ++p) {
            const Vec3f d = a[p] - b[p];
            longest2 = std::max(longest2, glm::dot(d, d));
        }
        return std::sqrt(longest2) / e.restM;
    }
    float longestAround(uint32_t v) const {
        float longest = 0;
        for (const uint32_t n : graph_.around(v)) {
            const float restM = glm::length(piece_.rest[v] - piece_.rest[n]);
            if (restM >= kShortestEdgeM) longest = std::max(longest, stretchOf({v, n, restM}));
        }
        return longest;
    }
    /** The best single step of a vertex; false: none makes its longest edge shorter. */
    bool refineAt(uint32_t v, float most) {
        constexpr float kLeastGain = 1e-4f;
        if (graph_.around(v).size() > kMostNeighbours) return false;
        float longest = longestAround(v);
        if (!(longest > most)) return false;
        candidates_.clear();
        const auto add = [&](uint32_t n) {
            for (int k = 0; k < 4; ++k)
                if (piece_.jointWeights[n][k] > 0 &&
                    std::find(candidates_.begin(), candidates_.end(), piece_.jointIndices[n][k]) == candidates_.end())
                    candidates_.push_back(piece_.jointIndices[n][k]);
        };
        add(v);
        for (const uint32_t n : graph_.around(v)) add(n);
        const PackedWeights start{piece_.jointIndices[v], piece_.jointWeights[v]};
        const auto take = [&](const PackedWeights& w) { piece_.jointIndices[v] = w.joints, piece_.jointWeights[v] = w.weights, pose(v); };
        PackedWeights best = start;
        for (int from = 0; from < 4; ++from)
            for (const uint16_t joint : candidates_) {
                if (start.weights[from] == 0 || start.joints[from] == joint || tries_ == kMostTries) continue;
                int to = -1;
                for (int k = 0; k < 4; ++k)
                    if (start.weights[k] == 0 ? to < 0 : start.joints[k] == joint) to = k;
                if (to < 0) continue;
                PackedWeights step = start;
                --step.weights[from], ++step.weights[to], step.joints[to] = joint;
                take(step), ++tries_;
                if (const float now = longestAround(v); now < longest - kLeastGain) longest = now, best = step;
            }
        take(best);
        const bool better = best.weights != start.weights || best.joints != start.joints;
        if (better) ++moves_[v];
        return better;
    }
    void fillRows() {
        const size_t columns = jointOf_.size();
        rows_.assign(piece_.rest.size() * columns, 0.0f);
        for (size_t v = 0; v < piece_.rest.size(); ++v)
            for (int k = 0; k < 4; ++k)
                if (piece_.jointWeights[v][k] > 0)
                    rows_[v * columns + columnOf_[piece_.jointIndices[v][k]]] += float(piece_.jointWeights[v][k]) / 255;
    }
    void pack(uint32_t v) {
        const PackedWeights packed = cutToFour(std::span(rows_).subspan(v * jointOf_.size(), jointOf_.size()), jointOf_);
        piece_.jointIndices[v] = packed.joints, piece_.jointWeights[v] = packed.weights;
    }
    /** Poses a vertex by its dense row. */
    void poseRow(uint32_t v) {
        const size_t columns = jointOf_.size();
        for (size_t p = 0; p < poses_; ++p) {
            Vec3f sum(0);
            for (size_t c = 0; c < columns; ++c)
                if (const float w = rows_[v * columns + c]; w > 0) sum += w * transformed(transforms_[p][jointOf_[c]], piece_.rest[v]);
            posed_[v * poses_ + p] = sum;
        }
    }
    void pose(uint32_t v) {
        for (size_t p = 0; p < poses_; ++p)
            posed_[v * poses_ + p] = skinVertex(piece_.rest[v], piece_.jointIndices[v], piece_.jointWeights[v], transforms_[p].data());
    }

    ClothPiece piece_;
    ClothGraph graph_;
    std::vector<uint32_t> columnOf_, jointOf_;
    size_t poses_;
    std::vector<std::vector<Mat3x4f>> transforms_;
    std::vector<Vec3f> posed_;          // V × poses
    std::vector<float> rows_;           // V × columns
    std::vector<uint32_t> moves_;       // of each vertex, counted
    std::vector<uint32_t> measuredAt_;  // of each edge: moves of both ends when its stretch was measured
    std::vector<float> stretch_;
    std::vector<uint16_t> candidates_;  // joints, while a vertex is refined
    size_t tries_ = 0;                  // steps that refining has tried
};

}  // namespace

ClothBounds boundCloth(const ClothPiece& piece, std::span<const JointData> joints, std::span<const Pose> poses, float torn) {
    ClothBounds bounds;
    if (piece.rest.empty() || poses.empty() || piece.rest.size() > kMostVertices) return bounds;
    Evener evener(piece, joints, poses);
    bounds.longestBefore = bounds.longestAfter = evener.longest();
    if (!(bounds.longestBefore > torn) || evener.sweeps() == 0) return bounds;
    for (int left = evener.sweeps(); left > 0 && evener.sweep(kMostClothStretch); --left) {
    }
    evener.pack();
    evener.refine(kMostClothStretch);
    bounds.longestAfter = evener.longest(), bounds.evened = evener.movedCount();
    return bounds;
}

namespace {

ClothBounds boundGarmentsIn(std::span<const Pose> poses, std::span<const JointData> joints, MeshData& mesh, float torn) {
    ClothBounds all;
    for (const LayerData& layer : mesh.layers) {
        if (layer.role != "garment" || poses.empty()) continue;
        const auto own = [&](auto& values) { return std::span(values).subspan(layer.firstVertex, layer.vertexCount); };
        std::vector<Triangle> triangles(mesh.triangles.begin() + layer.firstTriangle,
                                        mesh.triangles.begin() + layer.firstTriangle + layer.triangleCount);
        for (Triangle& t : triangles) t -= Triangle(layer.firstVertex);
        const ClothPiece piece{own(std::as_const(mesh.restPositions)), triangles, own(mesh.jointIndices), own(mesh.jointWeights)};
        const ClothBounds bounds = boundCloth(piece, joints, poses, torn);
        all.longestBefore = std::max(all.longestBefore, bounds.longestBefore);
        all.longestAfter = std::max(all.longestAfter, bounds.longestAfter);
        all.evened += bounds.evened;
    }
    return all;
}

}  // namespace

ClothBounds boundGarments(std::span<const JointData> joints, MeshData& mesh) {
    const bool dressed = std::any_of(mesh.layers.begin(), mesh.layers.end(), [](const LayerData& l) { return l.role == "garment"; });
    if (!dressed || !checkRig(joints)) return {};
    return boundGarmentsIn(stressPoses(joints), joints, mesh, kTornClothStretch);
}

ClothBounds boundNewGarments(std::span<const JointData> joints, MeshData& mesh) {
    if (!checkRig(joints)) return {};
    return boundGarmentsIn(clothPoses(joints), joints, mesh, kMostClothStretch);
}

}  // namespace dpl
