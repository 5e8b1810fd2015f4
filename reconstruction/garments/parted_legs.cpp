// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/garments/parted_legs.h"

#include <algorithm>

#include "reconstruction/capture/frame_picture.h"
#include "reconstruction/priors.h"
#include "reconstruction/surface/mesh_raster.h"
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
    return free > cloth && free >= priors::kFewestFreePixels;
}

BetweenLegs betweenLegs(const MeshData& joined, const MeshData& parted, uint8_t label, uint8_t bare, std::span<const JointData> joints,
                        std::span<const GarmentView> moving, Jobs& jobs) {
    std::vector<const GarmentView*> views;
    for (const GarmentView& view : moving)
        if (!view.labels.pixels.empty()) views.push_back(&view);
    const size_t count = std::min(views.size(), kMostViews);
    std::vector<BetweenLegs> ofView(count);
    jobs.forBlocks(count, [&](size_t k, uint32_t) {
        const GarmentView& view = *views[k * views.size() / count];
        std::vector<Mat3x4f> worldFromRest;
        jointTransforms(joints, view.pose, worldFromRest);
        const MeshRaster one = drawn(joined, worldFromRest, view.camera), two = drawn(parted, worldFromRest, view.camera);
        for (size_t p = 0; p < one.triangle.size(); ++p) {
            if (one.triangle[p] == kNoTriangle || two.triangle[p] != kNoTriangle) continue;
            const bool person = isPerson(view.mask.pixels[p]);
            ofView[k].free += !person || view.labels.pixels[p] == bare;
            ofView[k].cloth += person && view.labels.pixels[p] == label;
        }
    });
    BetweenLegs sum;
    for (const BetweenLegs& one : ofView) sum.cloth += one.cloth, sum.free += one.free;
    return sum;
}

}  // namespace dpl
