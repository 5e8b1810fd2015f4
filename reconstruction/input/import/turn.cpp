// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/import/turn.h"

#include <cmath>
#include <utility>

namespace dpl {

Turn turnOfExif(int orientation) {
    switch (orientation) {
        case 2:
            return {true, 0};
        case 3:
            return {false, 2};
        case 4:
            return {true, 2};
        case 5:
            return {true, 3};
        case 6:
            return {false, 1};
        case 7:
            return {true, 1};
        case 8:
            return {false, 3};
        default:
            return {};
    }
}

Turn uprightTurn(const Camerad& camera) {
    const Vec3d up = camera.viewFromWorldRotation[1];  // the world's +Y in view axes
    if (std::abs(up.z) > std::cos(glm::radians(30.0))) return {};
    // A clockwise quarter turn takes the view axes (x, y) to (−y, x). `up` should end near (0, −1).
    if (std::abs(up.y) >= std::abs(up.x)) return {false, up.y <= 0 ? 0 : 2};
    return {false, up.x < 0 ? 1 : 3};
}

Picture turned(const Picture& picture, Turn turn) {
    Picture out = picture;
    if (turn.none()) return out;
    const uint32_t w = picture.widthPx, h = picture.heightPx, channels = picture.channels;
    if (turn.quarters % 2 == 1) std::swap(out.widthPx, out.heightPx);
    for (uint32_t y = 0; y < h; ++y)
        for (uint32_t x = 0; x < w; ++x) {
            const uint32_t from = turn.mirror ? w - 1 - x : x;
            uint32_t tx = x, ty = y;
            if (turn.quarters == 1) tx = h - 1 - y, ty = x;
            if (turn.quarters == 2) tx = w - 1 - x, ty = h - 1 - y;
            if (turn.quarters == 3) tx = y, ty = w - 1 - x;
            const uint8_t* source = &picture.pixels[(size_t(y) * w + from) * channels];
            std::copy(source, source + channels, &out.pixels[(size_t(ty) * out.widthPx + tx) * channels]);
        }
    return out;
}

void turnCamera(Camerad& camera, LensDistortion& lens, Turn turn) {
    for (int i = 0; i < turn.quarters; ++i) {
        // Pixel (u, v) becomes (height − v, u), and the view axes (x, y) become (−y, x).
        const Camerad before = camera;
        camera.widthPx = before.heightPx, camera.heightPx = before.widthPx;
        camera.fx = before.fy, camera.fy = before.fx;
        camera.cx = before.heightPx - before.cy, camera.cy = before.cx;
        const Mat3d quarter(Vec3d(0, 1, 0), Vec3d(-1, 0, 0), Vec3d(0, 0, 1));
        camera.viewFromWorldRotation = quarter * before.viewFromWorldRotation;
        camera.viewFromWorldTranslation = quarter * before.viewFromWorldTranslation;
        // The tangential part of the model moves (x, y) by 2 (p·(x, y)) (x, y) + r² p with the vector p = (p2, p1), which turns along.
        lens = {lens.k1, lens.k2, lens.p2, -lens.p1};
    }
}

}  // namespace dpl
