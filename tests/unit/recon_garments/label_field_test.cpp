// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/label_field.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/unit/must.h"

namespace dpl::test {
namespace {

constexpr uint32_t kColumns = 61, kRows = 13;  // of vertices, 2 cm apart; the plane is 1.2 m wide and faces +z

SurfaceMesh plane() {
    SurfaceMesh mesh;
    for (uint32_t y = 0; y < kRows; ++y)
        for (uint32_t x = 0; x < kColumns; ++x) mesh.positions.push_back({0.02f * float(x), 0.02f * float(y), 0});
    for (uint32_t y = 0; y + 1 < kRows; ++y)
        for (uint32_t x = 0; x + 1 < kColumns; ++x) {
            const uint32_t v = y * kColumns + x;
            mesh.triangles.push_back({v, v + 1, v + kColumns}), mesh.triangles.push_back({v + 1, v + kColumns + 1, v + kColumns});
        }
    return mesh;
}

/** A picture from 1 m before the left third of the plane, that shows nothing else. */
GarmentView leftThird() {
    GarmentView view;
    view.camera = {80, 48, 200, 200, 40, 24};
    view.camera.viewFromWorldRotation = Mat3d(1, 0, 0, 0, -1, 0, 0, 0, -1);
    view.camera.viewFromWorldTranslation = -(view.camera.viewFromWorldRotation * Vec3d(0.2, 0.12, 1));
    view.mask = {80, 48, std::vector<uint8_t>(80 * 48, 255)};
    view.labels = {80, 48, std::vector<uint8_t>(80 * 48, 1)};
    return view;
}

TEST(LabelField, sightIsMeasuredAgainstWhatPicturesShow) {
    const SurfaceMesh mesh = plane();
    const GarmentView view = leftThird();
    const std::vector<ScanLabel> labels = {{"body", 1}, {"top", 2}};
    Jobs jobs(2);
    const LabelField field = must(voteLabels(mesh, std::span(&view, 1), std::span(&view.camera, 1), labels, 0.01, jobs));
    std::vector<float> shown;
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        if (mesh.positions[v].x < 0.39f) shown.push_back(field.seen[v]);
        if (mesh.positions[v].x > 0.6f) {
            ASSERT_LT(field.seen[v], 0.02f) << "nothing shows vertex " << v;
        }
    }
    ASSERT_LT(3 * shown.size(), 1.05 * double(mesh.positions.size())) << "two thirds are unseen";
    std::sort(shown.begin(), shown.end());
    EXPECT_NEAR(shown[shown.size() / 2], 1, 0.05);
    EXPECT_LT(shown.back(), 2);
}

}  // namespace
}  // namespace dpl::test
