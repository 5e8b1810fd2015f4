// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/cloth_weights.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "reconstruction/subject/garments/body_follow.h"
#include "reconstruction/subject/garments/priors.h"
#include "reconstruction/subject/shape/closest_surface.h"
#include "sdk/avatar/cloth_bounds.h"
#include "sdk/avatar/stress_poses.h"
#include "sdk/format/skin_weights.h"
#include "sdk/math/skinning.h"

namespace dpl {
namespace {

constexpr float kLargestStep = 0.1f;     // of a joint's weight along an edge; steeper steps tear cloth
constexpr float kStepBeforeCut = 0.07f;  // the cut to four joints makes steps steeper
constexpr int kSmoothingRounds = 400;
constexpr int kCutRounds = 12;
constexpr int kStressRounds = 4;
constexpr double kCloser = 0.5;                // factor of ℓ in each round
constexpr float kReachM = 0.1f;                // a vertex deeper in the body than this has met another limb
constexpr float kSmallestDeterminant = 0.25f;  // of a blend that halves two lengths; the inverse of a smaller one throws vertices far away

/** Dense rows, one column for each joint that the body below uses. */
struct Rows {
    size_t jointCount;
    std::vector<float> value;  // V × jointCount
    float* operator[](size_t vertex) { return &value[vertex * jointCount]; }
    const float* operator[](size_t vertex) const { return &value[vertex * jointCount]; }
};

float stepBetween(const Rows& rows, uint32_t a, uint32_t b) {
    float step = 0;
    for (size_t j = 0; j < rows.jointCount; ++j) step = std::max(step, std::abs(rows[a][j] - rows[b][j]));
    return step;
}

/** Averages the ends of steep edges with their neighbours until no joint's weight changes by more than kStepBeforeCut along an edge. */
void limitSteps(Rows& rows, const std::vector<std::vector<uint32_t>>& neighbours) {
    std::vector<uint8_t> check(neighbours.size(), 1);  // the row or one beside it changed in the round before
    std::vector<float> next = rows.value;
    for (int round = 0; round < kSmoothingRounds; ++round) {
        std::vector<uint32_t> steep;
        for (uint32_t v = 0; v < neighbours.size(); ++v)
            if (check[v] && std::any_of(neighbours[v].begin(), neighbours[v].end(),
                                        [&](uint32_t n) { return stepBetween(rows, v, n) > kStepBeforeCut; }))
                steep.push_back(v);
        if (steep.empty()) return;
        std::fill(check.begin(), check.end(), uint8_t(0));
        for (const uint32_t v : steep) {
            check[v] = 1;
            for (uint32_t n : neighbours[v]) check[n] = 1;
            for (size_t j = 0; j < rows.jointCount; ++j) {
                float mean = 0;
                for (uint32_t n : neighbours[v]) mean += rows[n][j] / float(neighbours[v].size());
                next[v * rows.jointCount + j] = 0.5f * (rows[v][j] + mean);
            }
        }
        for (const uint32_t v : steep) std::copy_n(&next[v * rows.jointCount], rows.jointCount, rows[v]);
    }
}

/** Cuts each row to four unorm8 weights, into `out`, and writes the cut weights back. */
void cutRows(Rows& rows, std::span<const uint32_t> jointOf, ClothWeights& out) {
    const size_t count = rows.value.size() / rows.jointCount;
    out.joints.resize(count), out.weights.resize(count);
    for (size_t v = 0; v < count; ++v) {
        const PackedWeights packed = cutToFour({rows[v], rows.jointCount}, jointOf);
        out.joints[v] = packed.joints, out.weights[v] = packed.weights;
        for (size_t j = 0; j < rows.jointCount; ++j) {
            rows[v][j] = 0;
            for (int k = 0; k < 4; ++k)
                if (packed.joints[k] == jointOf[j]) rows[v][j] += float(packed.weights[k]) / 255;
        }
    }
}

/** The body's weights below each vertex of a garment. */
struct BodyRows {
    std::vector<uint32_t> jointOf;  // of a column
    std::vector<double> value;      // V × columns
};

BodyRows bodyRows(std::span<const SurfacePoint> below, const MeshData& body, size_t jointCount) {
    std::vector<uint32_t> columnOf(jointCount, UINT32_MAX);
    const auto forEachWeight = [&](size_t v, auto visit) {
        for (int corner = 0; corner < 3; ++corner) {
            const uint32_t from = body.triangles[below[v].triangle][corner];
            for (int k = 0; k < 4; ++k)
                if (body.jointWeights[from][k] != 0)
                    visit(body.jointIndices[from][k], below[v].barycentric[corner] * float(body.jointWeights[from][k]) / 255);
        }
    };
    BodyRows rows;
    for (size_t v = 0; v < below.size(); ++v) forEachWeight(v, [&](uint32_t joint, float) { columnOf[joint] = 0; });
    for (uint32_t j = 0; j < jointCount; ++j)
        if (columnOf[j] == 0) columnOf[j] = uint32_t(rows.jointOf.size()), rows.jointOf.push_back(j);
    rows.value.assign(below.size() * rows.jointOf.size(), 0);
    for (size_t v = 0; v < below.size(); ++v)
        forEachWeight(v, [&](uint32_t joint, float weight) { rows.value[v * rows.jointOf.size() + columnOf[joint]] += double(weight); });
    return rows;
}

Result<ClothWeights> spreadWeights(const SurfaceMesh& piece, const BodyRows& ofBody, std::span<const double> lengthsM) {
    const size_t count = piece.positions.size(), columns = ofBody.jointOf.size();
    DPL_TRY(const std::vector<double> spread, followBody(piece, lengthsM, ofBody.value, columns));
    const auto neighbours = vertexNeighbours(count, piece.triangles);
    Rows rows{columns, std::vector<float>(spread.size())};
    for (size_t i = 0; i < spread.size(); ++i) rows.value[i] = float(std::max(0.0, spread[i]));
    ClothWeights out;
    for (int round = 0; round < kCutRounds; ++round) {  // the cut to four joints makes some steps steeper again
        limitSteps(rows, neighbours);
        cutRows(rows, ofBody.jointOf, out);
        out.largestStep = 0;
        for (uint32_t v = 0; v < count; ++v)
            for (uint32_t n : neighbours[v]) out.largestStep = std::max(out.largestStep, stepBetween(rows, v, n));
        if (out.largestStep <= kLargestStep) break;
    }
    return out;
}

/** 1 for each vertex that lies inside the body in one of the poses. rest: the garment's vertices. */
std::vector<uint8_t> sinking(std::span<const Vec3f> rest, const ClothWeights& weights, const MeshData& body,
                             std::span<const JointData> joints, std::span<const Pose> poses, Jobs& jobs) {
    std::vector<uint8_t> sinks(rest.size(), 0);
    std::vector<Mat3x4f> worldFromRest;
    std::vector<Vec3f> posed;
    for (const Pose& pose : poses) {
        jointTransforms(joints, pose, worldFromRest);
        skin(body, worldFromRest, jobs, posed);
        const ClosestSurface surface(posed, body.triangles);
        jobs.forRange(rest.size(), 256, [&](size_t begin, size_t end, uint32_t) {
            for (size_t v = begin; v < end; ++v) {
                const Mat3x4f blended = blendedTransform(weights.joints[v], weights.weights[v], worldFromRest.data());
                if (surface.signedDistance(blended * Vec4f(rest[v], 1), kReachM) < 0) sinks[v] = 1;
            }
        });
    }
    return sinks;
}

}  // namespace

Result<ClothWeights> clothWeights(const SurfaceMesh& piece, std::span<const SurfacePoint> below, const MeshData& body,
                                  std::span<const JointData> joints, std::span<const Mat3x4f> worldFromRest, Jobs& jobs) {
    const BodyRows rows = bodyRows(below, body, joints.size());
    std::vector<double> lengths = followLengths(below);
    DPL_TRY(ClothWeights weights, spreadWeights(piece, rows, lengths));
    const std::vector<Pose> stress = stressPoses(joints);
    for (int round = 0; round < kStressRounds && !stress.empty(); ++round) {
        const std::vector<uint8_t> sinks = sinking(unposed(piece, weights, worldFromRest), weights, body, joints, stress, jobs);
        bool changed = false;
        for (size_t v = 0; v < lengths.size(); ++v) {
            if (!sinks[v] || lengths[v] <= priors::kClothContactM) continue;
            lengths[v] = std::max(priors::kClothContactM, kCloser * lengths[v]);
            changed = true;
        }
        if (!changed) break;
        DPL_TRY(weights, spreadWeights(piece, rows, lengths));
    }
    const std::vector<Vec3f> rest = unposed(piece, weights, worldFromRest);
    boundCloth({rest, piece.triangles, weights.joints, weights.weights}, joints, clothPoses(joints), kMostClothStretch);
    for (const SurfacePoint& point : below) weights.distanceM.push_back(point.distanceM);
    return weights;
}

std::vector<Vec3f> unposed(const SurfaceMesh& posed, const ClothWeights& weights, std::span<const Mat3x4f> worldFromRest) {
    const size_t count = posed.positions.size();
    std::vector<Vec3f> move(count, Vec3f(0));  // from posed to rest
    std::vector<uint8_t> known(count, 0);
    for (size_t v = 0; v < count; ++v) {
        const Mat3x4f blended = blendedTransform(weights.joints[v], weights.weights[v], worldFromRest.data());
        const Mat3f linear(blended[0], blended[1], blended[2]);
        if (!(std::abs(glm::determinant(linear)) > kSmallestDeterminant)) continue;
        move[v] = glm::inverse(linear) * (posed.positions[v] - blended[3]) - posed.positions[v];
        known[v] = 1;
    }
    const auto neighbours = vertexNeighbours(count, posed.triangles);
    for (bool grew = true; grew;) {
        grew = false;
        std::vector<uint32_t> fresh;
        for (uint32_t v = 0; v < count; ++v) {
            if (known[v]) continue;
            Vec3f sum(0);
            float from = 0;
            for (uint32_t n : neighbours[v])
                if (known[n]) sum += move[n], from += 1;
            if (from > 0) move[v] = sum / from, fresh.push_back(v);
        }
        for (uint32_t v : fresh) known[v] = 1, grew = true;
    }
    std::vector<Vec3f> rest = posed.positions;
    for (size_t v = 0; v < count; ++v) rest[v] += move[v];
    return rest;
}

}  // namespace dpl
