// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/parted_legs.h"

#include <algorithm>

#include "reconstruction/input/capture/frame_picture.h"
#include "reconstruction/subject/garments/priors.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "sdk/avatar/rig.h"
#include "sdk/math/skinning.h"

namespace dpl {
namespace {

constexpr size_t kMostViews = 48;

MeshRaster drawn(const MeshData& garment, std::span<const Mat3x4f> worldFromRest, const Camerad& camera) {
    std::vector<Vec3f> posed;
    for (size_t v = 0; v < garment.restPositions.size(); ++v)
        posed.push_back(skinVertex(garment.restPositions[v], garment.jointIndices[v], garment.jointWeights[v], worldFromRest.data()));
    return rasteriseMesh(posed, garment.triangles, camera);
}

}  // namespace

bool BetweenLegs::parted() const {
    return free >= priors::kFewestFreePixels && free > priors::kFreePerCloth * cloth;
}

BetweenLegs betweenLegs(const LegForms& garment, std::span<const JointData> joints, std::span<const GarmentView> moving, Jobs& jobs) {
    std::vector<const GarmentView*> views;
    for (const GarmentView& view : moving)
        if (!view.labels.pixels.empty()) views.push_back(&view);
    const size_t count = std::min(views.size(), kMostViews);
    std::vector<BetweenLegs> ofView(count);
    jobs.forBlocks(count, [&](size_t k, uint32_t) {
        const GarmentView& view = *views[k * views.size() / count];
        std::vector<Mat3x4f> worldFromRest;
        jointTransforms(joints, view.pose, worldFromRest);
        const MeshRaster one = drawn(garment.joined, worldFromRest, view.camera), two = drawn(garment.parted, worldFromRest, view.camera);
        for (size_t row = 0; row < one.heightPx; ++row) {
            const size_t first = row * one.widthPx;
            const auto shows = [&](size_t p, uint8_t what) { return isPerson(view.mask.pixels[p]) && view.labels.pixels[p] == what; };
            size_t left = first, right = first + one.widthPx;
            while (left < right && !shows(left, garment.label)) ++left;
            while (right > left && !shows(right - 1, garment.label)) --right;
            for (size_t p = left; p < right; ++p) {  // elsewhere no cloth is beside the pixel
                if (one.triangle[p] == kNoTriangle || !garment.between[one.triangle[p]] || two.triangle[p] != kNoTriangle) continue;
                ofView[k].free += !isPerson(view.mask.pixels[p]) || shows(p, garment.bare);
                ofView[k].cloth += shows(p, garment.label);
            }
        }
    });
    BetweenLegs sum;
    for (const BetweenLegs& one : ofView) sum.cloth += one.cloth, sum.free += one.free;
    return sum;
}

}  // namespace dpl
