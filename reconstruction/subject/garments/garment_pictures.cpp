// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/garment_pictures.h"

#include <opencv2/imgproc.hpp>

#include "reconstruction/subject/garments/side_view.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "sdk/splat/splat_engine.h"

namespace dpl {
namespace {

constexpr double kOutsideM = 0.02;

/** The splats of triangles [first, first + count). */
PackedSplats splatsOf(const SplatData& s, uint32_t first, uint32_t count) {
    std::vector<uint32_t> triangle;
    for (uint32_t t = first; t < first + count && t + 1 < s.triangleStart.size(); ++t)
        triangle.insert(triangle.end(), s.triangleStart[t + 1] - s.triangleStart[t], t);
    const size_t begin = first < s.triangleStart.size() ? s.triangleStart[first] : 0, splats = triangle.size();
    const std::vector<float> grey(3 * splats, 0.0f);  // only alpha is read
    const auto part = [&](const auto& all) { return std::span(all).subspan(begin, splats); };
    return PackedSplats(BoundSplatView{triangle, part(s.uv), part(s.phi), part(s.scaleM), part(s.opacity), part(s.flags), 0, grey});
}

}  // namespace

struct GarmentPictures::State {
    struct Garment {
        GrownTubes tubes;
        PackedSplats splats;
        std::span<const Triangle> triangles;
    };
    const AvatarData& avatar;
    SplatEngine engine;
    PackedSplats all;
    std::vector<Garment> garments;
    std::vector<uint8_t> rgba;

    State(const AvatarData& from, Jobs& jobs) : avatar(from), engine(jobs) {}

    /** Premultiplied RGBA of the last project(). */
    void draw(const PackedSplats& splats, std::span<const TriangleFrame<float>> frames, const Camerad& camera) {
        engine.project(splats, frames, camera.cast<float>(), avatar.kappaPx2, avatar.compensated);
        engine.bin();
        engine.blendRgba8(rgba);
    }
};

GarmentPictures::GarmentPictures(const AvatarData& avatar, std::span<const LayerData* const> garments, Jobs& jobs)
    : state_(std::make_unique<State>(avatar, jobs)) {
    state_->all = splatsOf(avatar.splats, 0, uint32_t(avatar.mesh.triangles.size()));
    for (const LayerData* layer : garments)
        state_->garments.push_back({GrownTubes(avatar.joints, avatar.mesh, *layer),
                                    splatsOf(avatar.splats, layer->firstTriangle, layer->triangleCount),
                                    std::span(avatar.mesh.triangles).subspan(layer->firstTriangle, layer->triangleCount)});
}

GarmentPictures::~GarmentPictures() = default;

std::vector<GarmentPixels> GarmentPictures::count(const PosedMesh& posed) {
    std::vector<GarmentPixels> counts(state_->garments.size());
    for (int side = 0; side < kSides && state_->avatar.splats.count() > 0; ++side) {
        const Camerad camera = sideView(posed.positions(), side);
        const size_t pixels = size_t(camera.widthPx) * camera.heightPx;
        const auto isDrawn = [&](size_t i) { return state_->rgba[4 * i + 3] >= 128; };
        state_->draw(state_->all, posed.frames(), camera);
        for (size_t g = 0; g < counts.size(); ++g) {
            const MeshRaster cloth = rasteriseMesh(posed.positions(), state_->garments[g].triangles, camera);
            for (size_t i = 0; i < pixels; ++i) {
                if (cloth.triangle[i] == kNoTriangle) continue;
                ++counts[g].outline, counts[g].uncovered += !isDrawn(i);
            }
        }
        for (size_t g = 0; g < counts.size(); ++g) {
            const State::Garment& garment = state_->garments[g];
            if (garment.tubes.empty() || garment.splats.count() == 0) continue;
            state_->draw(garment.splats, posed.frames(), camera);
            std::vector<uint8_t> inside = garment.tubes.outline(posed.worldFromRest(), camera);
            for (uint8_t& i : inside) i = uint8_t(1 - i);  // a distance is that to the nearest zero
            cv::Mat distancePx;
            cv::distanceTransform(cv::Mat(int(camera.heightPx), int(camera.widthPx), CV_8U, inside.data()), distancePx, cv::DIST_L2,
                                  cv::DIST_MASK_PRECISE);
            for (size_t i = 0; i < pixels; ++i) {
                if (!isDrawn(i)) continue;
                ++counts[g].drawn, counts[g].outside += double(distancePx.ptr<float>()[i]) * kSidePixelM > kOutsideM;
            }
        }
    }
    return counts;
}

}  // namespace dpl
