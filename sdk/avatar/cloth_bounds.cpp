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
constexpr int kSweeps = 600;  // over all edges; a torn skirt takes some hundred
constexpr int kMergeRounds = 4;
// A hostile file costs no more than these: 60 MB, and two seconds of a core.
constexpr size_t kMostVertices = 200000, kMostRowFloats = 5'000'000, kMostVertexSweeps = 10'000'000;

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
    /** Moves the rows at both ends of every edge beyond `most` towards each other, in the order of the edges, as far as brings it there.
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
            const float share = 0.5f * (1 - most / stretch);
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
    /** Rounding to 1/255 is coarse beside a long limb. An edge that it stretches takes one row at both ends where that mends more than it
     *  tears. */
    void merge(float most) {
        for (int round = 0; round < kMergeRounds; ++round)
            for (const Edge& e : graph_.edges) {
                if (!(stretchOf(e) > most)) continue;
                for (const auto& [to, from] : {std::pair(e.b, e.a), std::pair(e.a, e.b)}) {
                    const float before = longestAround(to);
                    const auto indices = piece_.jointIndices[to];
                    const auto weights = piece_.jointWeights[to];
                    piece_.jointIndices[to] = piece_.jointIndices[from], piece_.jointWeights[to] = piece_.jointWeights[from];
                    pose(to);
                    if (longestAround(to) < before) {
                        ++moves_[to];
                        break;
                    }
                    piece_.jointIndices[to] = indices, piece_.jointWeights[to] = weights;
                    pose(to);
                }
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
    evener.merge(kMostClothStretch);
    bounds.longestAfter = evener.longest(), bounds.evened = evener.movedCount();
    return bounds;
}

ClothBounds boundGarments(std::span<const JointData> joints, MeshData& mesh) {
    ClothBounds all;
    if (!checkRig(joints)) return all;
    std::vector<Pose> poses;
    for (const LayerData& layer : mesh.layers) {
        if (layer.role != "garment") continue;
        if (poses.empty()) poses = stressPoses(joints);
        if (poses.empty()) return all;
        const auto own = [&](auto& values) { return std::span(values).subspan(layer.firstVertex, layer.vertexCount); };
        std::vector<Triangle> triangles(mesh.triangles.begin() + layer.firstTriangle,
                                        mesh.triangles.begin() + layer.firstTriangle + layer.triangleCount);
        for (Triangle& t : triangles) t -= Triangle(layer.firstVertex);
        const ClothPiece piece{own(std::as_const(mesh.restPositions)), triangles, own(mesh.jointIndices), own(mesh.jointWeights)};
        ClothBounds bounds = boundCloth(piece, joints, poses, kTornClothStretch);
        all.longestBefore = std::max(all.longestBefore, bounds.longestBefore);
        all.longestAfter = std::max(all.longestAfter, bounds.longestAfter);
        all.evened += bounds.evened;
    }
    return all;
}

}  // namespace dpl
