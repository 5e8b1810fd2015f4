// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/error_map.h"

#include <cstdlib>

#include "reconstruction/judging/coach/map_pictures.h"

namespace dpl {

std::vector<float> differenceOnSurface(std::span<const Vec3f> positions, std::span<const Triangle> triangles, const Camerad& camera,
                                       const std::vector<uint8_t>& shown, const std::vector<uint8_t>& truth, const ImageGrey8& mask) {
    const std::vector<Sight> sights = lookAt(positions, triangles, camera, &mask);
    std::vector<float> out(triangles.size(), -1.0f);
    const int width = int(camera.widthPx), height = int(camera.heightPx);
    for (size_t t = 0; t < triangles.size(); ++t) {
        if (!(sights[t].pixelM > 0)) continue;
        const Triangle& corners = triangles[t];
        const Vec3d middle = (Vec3d(positions[corners.x]) + Vec3d(positions[corners.y]) + Vec3d(positions[corners.z])) / 3.0;
        const Vec2d px = camera.pixelOf(camera.toView(middle));
        int sum = 0, count = 0;
        for (int y = std::max(0, int(px.y) - 1); y <= std::min(height - 1, int(px.y) + 1); ++y)
            for (int x = std::max(0, int(px.x) - 1); x <= std::min(width - 1, int(px.x) + 1); ++x) {
                const size_t at = size_t(y) * size_t(width) + size_t(x);
                if (!isPerson(mask.pixels[at])) continue;
                for (size_t c = 0; c < 3; ++c) sum += std::abs(int(shown[3 * at + c]) - int(truth[3 * at + c]));
                count += 3;
            }
        if (count > 0) out[t] = float(sum) / float(count);
    }
    return out;
}

Result<std::vector<uint8_t>> drawErrorMap(const MeshData& mesh, std::span<const HeldOutFrame> frames) {
    std::vector<double> sums(mesh.triangles.size());
    std::vector<uint32_t> counts(sums.size());
    bool known = false;
    for (const HeldOutFrame& frame : frames) {
        if (frame.onSurface.size() != sums.size()) continue;
        known = true;
        for (size_t t = 0; t < sums.size(); ++t)
            if (frame.onSurface[t] >= 0) sums[t] += double(frame.onSurface[t]), ++counts[t];
    }
    if (!known) return std::vector<uint8_t>();
    std::vector<double> means(sums.size(), -1.0);
    for (size_t t = 0; t < sums.size(); ++t)
        if (counts[t] > 0) means[t] = sums[t] / counts[t];
    return drawOnSurface(mesh, {"mean difference of colour, of 255 levels", {2, 4, 8, 16, 32, 64}, /*smallIsGood=*/true}, means);
}

}  // namespace dpl
