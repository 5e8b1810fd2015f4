// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/cloth_faults.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/garments/garment_cover.h"
#include "reconstruction/subject/garments/garment_pictures.h"
#include "reconstruction/subject/garments/side_view.h"
#include "reconstruction/subject/shape/closest_surface.h"
#include "reconstruction/subject/surface/clothed_layers.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "sdk/avatar/posed_mesh.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

constexpr float kReachM = 0.1f;
constexpr float kStretched = 2;
constexpr float kShortestEdgeM = 1e-4f;

/** An avatar as body and garments. */
struct Clothed {
    const AvatarData& avatar;
    std::span<const Triangle> body;
    std::vector<uint32_t> vertices;   // of garments
    std::vector<Triangle> triangles;  // of garments
    std::vector<const LayerData*> garments;
    std::vector<RestTriangle<float>> bind;  // of the whole mesh
    ClothLimits cloth;
    bool empty() const { return body.empty() || vertices.empty(); }

    explicit Clothed(const AvatarData& from) : avatar(from), vertices(garmentVertices(from.mesh)) {
        for (const LayerData& layer : from.mesh.layers) {
            const std::span<const Triangle> own(from.mesh.triangles.data() + layer.firstTriangle, layer.triangleCount);
            if (&layer == bodyLayer(from.mesh)) body = own;
            if (layer.role != "garment") continue;
            triangles.insert(triangles.end(), own.begin(), own.end());
            garments.push_back(&layer);
        }
        if (empty()) return;
        bind = restTriangles(from.mesh);
        cloth = ClothLimits(from.joints, from.mesh, from.correctives);
    }
    void pose(const Pose& pose, Jobs& jobs, PosedMesh& posed) const {
        posed.pose({avatar.joints, avatar.mesh, avatar.correctives, {bind}, nullptr, {}, &cloth}, pose, jobs);
    }
};

size_t verticesInside(const Clothed& clothed, const PosedMesh& posed, Jobs& jobs) {
    const ClosestSurface surface(posed.positions(), clothed.body);
    std::vector<uint8_t> inside(clothed.vertices.size());
    jobs.forRange(inside.size(), 256, [&](size_t begin, size_t end, uint32_t) {
        for (size_t i = begin; i < end; ++i) inside[i] = surface.signedDistance(posed.positions()[clothed.vertices[i]], kReachM) < 0;
    });
    return size_t(std::count(inside.begin(), inside.end(), uint8_t(1)));
}

/** Body triangles with a corner that a garment covers at rest. */
std::vector<uint8_t> coveredTriangles(const Clothed& clothed) {
    const auto& rest = clothed.avatar.mesh.restPositions;
    const GarmentCover cover(SurfaceMesh{rest, clothed.triangles});
    const std::vector<Vec3f> normals = vertexNormals(rest, clothed.body);
    std::vector<uint8_t> covered(clothed.body.size());
    for (size_t t = 0; t < covered.size(); ++t)
        for (int corner = 0; corner < 3 && !covered[t]; ++corner) {
            const uint32_t v = clothed.body[t][corner];
            const auto height = cover.heightOf(rest[v], normals[v]);
            covered[t] = height && height->aboveM < 0;
        }
    return covered;
}

/** Counts of a garment's edges in one pose. */
struct EdgeCount {
    size_t edges = 0, stretched = 0;
    double longest = 1;
};

EdgeCount countEdges(const Clothed& clothed, const LayerData& garment, std::span<const Vec3f> positions) {
    const auto& rest = clothed.avatar.mesh.restPositions;
    EdgeCount count;
    for (uint32_t i = 0; i < garment.triangleCount; ++i) {
        const Triangle& t = clothed.avatar.mesh.triangles[garment.firstTriangle + i];
        for (int c = 0; c < 3; ++c) {
            const uint32_t a = t[c], b = t[(c + 1) % 3];
            const float length = glm::length(rest[a] - rest[b]);
            if (length < kShortestEdgeM) continue;
            const float ratio = glm::length(positions[a] - positions[b]) / length;
            ++count.edges, count.stretched += ratio > kStretched;
            count.longest = std::max(count.longest, double(ratio));
        }
    }
    return count;
}

/** Length from end to end of the longest drawn splat of a garment, metres. */
double longestSplatM(const Clothed& clothed, const LayerData& garment, std::span<const TriangleFrame<float>> frames) {
    const SplatData& splats = clothed.avatar.splats;
    double longest = 0;
    for (uint32_t t = garment.firstTriangle; t < garment.firstTriangle + garment.triangleCount; ++t) {
        if (t + 1 >= splats.triangleStart.size() || !frames[t].valid) continue;
        for (uint32_t i = splats.triangleStart[t]; i < splats.triangleStart[t + 1]; ++i) {
            const double reach2 = visibleRadius2(double(splats.opacity[i] * frames[t].shown));  // in squares of the standard deviation
            if (!(reach2 > 0)) continue;
            Vec3f a1, a2;
            splatAxes(frames[t], splats.phi[i], splats.scaleM[i].x, splats.scaleM[i].y, a1, a2);
            const double p = glm::dot(a1, a1), q = glm::dot(a1, a2), r = glm::dot(a2, a2);
            longest = std::max(longest, 2 * std::sqrt(reach2 * (0.5 * (p + r) + std::hypot(0.5 * (p - r), q))));
        }
    }
    return longest;
}

/** Sums a fault over the poses. */
struct PixelTally {
    PixelFault fault;
    size_t px = 0, ofPx = 0;
    void add(size_t pose, size_t counted, size_t of) {
        if (counted > fault.mostPx) fault.mostPx = counted, fault.worstPose = pose;
        px += counted, ofPx += of;
        if (ofPx > 0) fault.share = double(px) / double(ofPx);
    }
};

/** What is drawn outside of where a garment may be seen, and what is not drawn inside of where it is. */
struct DrawnTally {
    PixelTally outside, uncovered;
    void add(size_t pose, const GarmentPixels& p) { outside.add(pose, p.outside, p.drawn), uncovered.add(pose, p.uncovered, p.outline); }
};

/** Sums over the poses what is wrong with each garment, and with all together. */
class NeedleTally {
public:
    NeedleTally(const Clothed& clothed, Jobs& jobs)
        : clothed_(clothed), pictures_(clothed.avatar, clothed.garments, jobs), drawn_(clothed.garments.size()) {
        for (const LayerData* garment : clothed.garments) needles_.push_back({.name = garment->name});
    }

    void add(size_t pose, const PosedMesh& posed) {
        const std::vector<GarmentPixels> pixels = pictures_.count(posed);
        GarmentPixels sum;
        for (size_t g = 0; g < needles_.size(); ++g) {
            const EdgeCount edges = countEdges(clothed_, *clothed_.garments[g], posed.positions());
            edges_ += edges.edges, stretched_ += edges.stretched;
            needles_[g].longestStretch = std::max(needles_[g].longestStretch, edges.longest);
            needles_[g].longestSplatM = std::max(needles_[g].longestSplatM, longestSplatM(clothed_, *clothed_.garments[g], posed.frames()));
            drawn_[g].add(pose, pixels[g]);
            needles_[g].outside = drawn_[g].outside.fault, needles_[g].uncovered = drawn_[g].uncovered.fault;
            sum.drawn += pixels[g].drawn, sum.outside += pixels[g].outside;
            sum.outline += pixels[g].outline, sum.uncovered += pixels[g].uncovered;
        }
        all_.add(pose, sum);
    }
    const std::vector<GarmentNeedles>& needles() const { return needles_; }

    /** Fills what the garments have in common with the faults of the whole avatar. */
    void write(ClothFaults& faults) const {
        faults.garments = needles_;
        faults.outside = all_.outside.fault, faults.uncovered = all_.uncovered.fault;
        if (edges_ > 0) faults.stretchedEdges = double(stretched_) / double(edges_);
        for (const GarmentNeedles& needles : needles_) {
            faults.longestStretch = std::max(faults.longestStretch, needles.longestStretch);
            faults.longestSplatM = std::max(faults.longestSplatM, needles.longestSplatM);
        }
    }

private:
    const Clothed& clothed_;
    GarmentPictures pictures_;
    std::vector<DrawnTally> drawn_;
    DrawnTally all_;
    std::vector<GarmentNeedles> needles_;
    size_t edges_ = 0, stretched_ = 0;
};

struct PixelCount {
    size_t skin = 0, all = 0;
};

PixelCount countPixels(const Clothed& clothed, std::span<const uint8_t> covered, std::span<const Vec3f> positions, const Camerad& camera) {
    const MeshRaster body = rasteriseMesh(positions, clothed.body, camera), cloth = rasteriseMesh(positions, clothed.triangles, camera);
    PixelCount count;
    for (size_t p = 0; p < cloth.triangle.size(); ++p) {
        if (cloth.triangle[p] == kNoTriangle) continue;
        const bool bodyFirst = body.depthM[p] < cloth.depthM[p];
        if (!bodyFirst) {
            ++count.all;
            continue;
        }
        if (!covered[body.triangle[p]] || cloth.depthM[p] - body.depthM[p] > kReachM) continue;
        const Triangle& t = clothed.triangles[cloth.triangle[p]];
        const Vec3d a(positions[t.x]), normal = glm::cross(Vec3d(positions[t.y]) - a, Vec3d(positions[t.z]) - a);
        if (glm::dot(normal, camera.eye() - a) > 0) ++count.skin, ++count.all;
    }
    return count;
}

/** Sums the lengths of the garments' learned offsets. Kept between poses. */
class OffsetSum {
public:
    explicit OffsetSum(const Clothed& clothed) : clothed_(clothed), unlimited_(clothed.avatar.correctives) {
        unlimited_.reach = unlimited_.reachOffModes = 1e30f;
        for (MotionGroupData& group : unlimited_.motion.groups) group.reach = 1e30f;
    }

    /** posed: the avatar in this pose. */
    void add(const Pose& pose, const PosedMesh& posed, Jobs& jobs) {
        if (unlimited_.empty()) return;
        correctiveCoefficients(unlimited_, pose, coefficients_);
        correctiveNodes(unlimited_, coefficients_, nodes_);
        spreadCorrectives(unlimited_, nodes_, clothed_.avatar.mesh.restPositions, jobs, moved_, light_);
        drawn_ += lengthOf(posed.rest()), learned_ += lengthOf(moved_);
    }
    double share() const { return learned_ > 0 ? drawn_ / learned_ : 1; }

private:
    double lengthOf(std::span<const Vec3f> moved) const {
        double sum = 0;
        for (const uint32_t v : clothed_.vertices) sum += double(glm::length(moved[v] - clothed_.avatar.mesh.restPositions[v]));
        return sum;
    }

    const Clothed& clothed_;
    PoseCorrectiveData unlimited_;
    double drawn_ = 0, learned_ = 0;
    std::vector<float> coefficients_, light_;
    std::vector<Vec4f> nodes_;
    std::vector<Vec3f> moved_;
};

}  // namespace

double garmentPenetration(const AvatarData& avatar, std::span<const Pose> poses, Jobs& jobs) {
    const Clothed clothed(avatar);
    if (clothed.empty() || poses.empty()) return 0;
    PosedMesh posed;
    size_t count = 0;
    for (const Pose& pose : poses) clothed.pose(pose, jobs, posed), count += verticesInside(clothed, posed, jobs);
    return double(count) / double(clothed.vertices.size() * poses.size());
}

std::vector<GarmentNeedles> clothNeedles(const AvatarData& avatar, std::span<const Pose> poses, Jobs& jobs) {
    const Clothed clothed(avatar);
    if (clothed.empty() || poses.empty()) return {};
    NeedleTally tally(clothed, jobs);
    PosedMesh posed;
    for (size_t i = 0; i < poses.size(); ++i) {
        clothed.pose(poses[i], jobs, posed);
        tally.add(i, posed);
    }
    return tally.needles();
}

Result<ClothFaults> clothFaults(const AvatarData& avatar, std::span<const Pose> poses, Jobs& jobs) {
    ClothFaults faults;
    const Clothed clothed(avatar);
    if (clothed.empty() || poses.empty()) return faults;
    const std::vector<uint8_t> covered = coveredTriangles(clothed);
    NeedleTally tally(clothed, jobs);
    OffsetSum offsets(clothed);
    PosedMesh posed;
    size_t inside = 0, mostInside = 0;
    PixelCount pixels;
    for (size_t i = 0; i < poses.size(); ++i) {
        DPL_RETURN_IF_ERROR(taskAt(double(i) / double(poses.size()), formatText("{} poses", poses.size())));
        clothed.pose(poses[i], jobs, posed);
        tally.add(i, posed);
        offsets.add(poses[i], posed, jobs);
        const size_t count = verticesInside(clothed, posed, jobs);
        inside += count;
        if (count > mostInside) mostInside = count, faults.worstPose = i;
        std::vector<PixelCount> sides(kSides);
        jobs.forRange(kSides, 1, [&](size_t begin, size_t end, uint32_t) {
            for (size_t side = begin; side < end; ++side)
                sides[side] = countPixels(clothed, covered, posed.positions(), sideView(posed.positions(), int(side)));
        });
        for (const PixelCount& side : sides) pixels.skin += side.skin, pixels.all += side.all;
    }
    tally.write(faults);
    faults.penetration = double(inside) / double(clothed.vertices.size() * poses.size());
    faults.offsetsAtWork = offsets.share();
    if (pixels.all > 0) faults.skinPixels = double(pixels.skin) / double(pixels.all);
    return faults;
}

}  // namespace dpl
