// SPDX-License-Identifier: Apache-2.0
// A modelled person in a top and a skirt, drawn into masks and labels: the layers must be those clothes.
#include "reconstruction/subject/garments/clothed_mesh.h"

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

#include "modelled_person.h"
#include "reconstruction/subject/shape/closest_surface.h"
#include "tests/unit/heard_task.h"

namespace dpl {
namespace {

constexpr float kHemY = 0.33f, kWaistY = 0.95f;

/** Height and angle to the skirt: a cone that hangs free below the hips. */
SurfaceMesh skirt() {
    SurfaceMesh m;
    constexpr uint32_t kRows = 24, kSides = 64;
    for (uint32_t i = 0; i <= kRows; ++i)
        for (uint32_t k = 0; k < kSides; ++k) {
            const float t = float(i) / kRows, angle = 6.2831853f * float(k) / kSides, radius = 0.165f + 0.14f * t;
            m.positions.push_back({radius * std::sin(angle), kWaistY + t * (kHemY - kWaistY), radius * std::cos(angle)});
        }
    for (uint32_t i = 0; i < kRows; ++i)
        for (uint32_t k = 0; k < kSides; ++k) {
            const uint32_t a = i * kSides + k, b = i * kSides + (k + 1) % kSides, c = a + kSides, d = b + kSides;
            m.triangles.push_back({a, c, b});
            m.triangles.push_back({b, c, d});
        }
    return m;
}

std::vector<GarmentView> shots(int count, bool badge = false, bool belt = false) {
    ModelledPerson person;
    person.add({body().restPositions, body().triangles}, [](const Vec3f&) { return kSkin; });
    person.add(topSurface(), [&](const Vec3f& p) -> uint8_t {
        if (p.y < 0.93f || p.y > 1.33f) return 0;
        if (badge && p.z > 0.06f && std::abs(p.x) < 0.12f && p.y > 1.02f && p.y < 1.22f) return kBadge;
        return belt && p.y > 1.1f && p.y < 1.115f ? kBelt : kTop;
    });
    person.add(skirt(), [](const Vec3f&) { return kBottom; });
    return stillPictures(person, count);
}

const std::vector<GarmentView>& plainShots() {
    static const std::vector<GarmentView> made = shots(24);
    return made;
}

std::vector<ScanLabel> labels() {
    return {{"background", 0}, {"body", kSkin}, {"top", kTop}, {"bottom", kBottom}, {"shoes", kShoes}};
}

Result<GarmentFit> dress(std::span<const GarmentView> views, std::span<const ScanLabel> names, uint32_t threads = 2) {
    const auto rig = joints();
    const std::vector<Vec3f> offsets(body().restPositions.size(), Vec3f(0));
    Jobs jobs(threads);
    return makeClothedMesh({body(), rig, offsets, views, {}, names}, jobs);
}

const GarmentFit& plainFit() {
    static const GarmentFit made = [] {
        auto fit = dress(plainShots(), labels());
        EXPECT_TRUE(fit) << fit.error().message;
        return fit ? std::move(*fit) : GarmentFit{};
    }();
    return made;
}

TEST(ClothedMesh, layersTileTheMeshAndShareNoPosition) {
    const ClothedMesh& clothed = plainFit().clothed;
    const MeshData& mesh = clothed.mesh;
    ASSERT_EQ(mesh.layers.size(), 3u);
    EXPECT_EQ(mesh.layers[0].role, "body");
    EXPECT_EQ(mesh.layers[1].name, "top");
    EXPECT_EQ(mesh.layers[2].name, "bottom");
    EXPECT_EQ(mesh.layers[2].role, "garment");
    ASSERT_EQ(clothed.triangleLabel.size(), mesh.triangles.size());
    ASSERT_EQ(mesh.jointWeights.size(), mesh.restPositions.size());
    uint32_t vertex = 0, triangle = 0;
    std::map<std::tuple<float, float, float>, size_t> owner;
    for (size_t k = 0; k < mesh.layers.size(); ++k) {
        const LayerData& layer = mesh.layers[k];
        EXPECT_EQ(layer.firstVertex, vertex);
        EXPECT_EQ(layer.firstTriangle, triangle);
        vertex += layer.vertexCount, triangle += layer.triangleCount;
        for (uint32_t t = layer.firstTriangle; t < triangle; ++t) {
            EXPECT_EQ(clothed.triangleLabel[t], k == 0 ? kSkin : k == 1 ? kTop : kBottom);
            for (int c = 0; c < 3; ++c) ASSERT_TRUE(mesh.triangles[t][c] >= layer.firstVertex && mesh.triangles[t][c] < vertex);
        }
        for (uint32_t v = layer.firstVertex; v < vertex; ++v) {
            const Vec3f p = mesh.restPositions[v];
            EXPECT_EQ(owner.try_emplace({p.x, p.y, p.z}, k).first->second, k) << "layers share a position";
            const auto w = mesh.jointWeights[v];
            ASSERT_EQ(w.x + w.y + w.z + w.w, 255);
        }
    }
    EXPECT_EQ(vertex, mesh.restPositions.size());
    EXPECT_EQ(triangle, mesh.triangles.size());
}

TEST(ClothedMesh, theSkirtIsATubeWhereTheTrueSkirtIs) {
    const SurfaceMesh found = layerOf(plainFit().clothed.mesh, 2), truth = skirt();
    // A tube: one piece, Euler characteristic 0, two borders.
    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    for (const Triangle& t : found.triangles)
        for (int k = 0; k < 3; ++k) ++edges[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}];
    EXPECT_EQ(int(found.positions.size()) - int(edges.size()) + int(found.triangles.size()), 0);
    EXPECT_EQ(largestPiece(found).positions.size(), found.positions.size());
    const ClosestSurface there(truth.positions, truth.triangles), here(found.positions, found.triangles);
    double sum = 0, back = 0;
    for (const Vec3f& p : found.positions) sum += there.find(p).distanceM / double(found.positions.size());
    for (const Vec3f& p : truth.positions) back += here.find(p).distanceM / double(truth.positions.size());
    EXPECT_LT(sum, 0.012);  // a pixel is 1 cm
    EXPECT_LT(back, 0.012);
    float lowest = 9;
    for (const Vec3f& p : found.positions) lowest = std::min(lowest, p.y);
    EXPECT_NEAR(lowest, kHemY, 0.025);
    EXPECT_GT(plainFit().hullIou, 0.94);
}

TEST(ClothedMesh, theSkirtSpansTheLegs) {
    const MeshData& mesh = plainFit().clothed.mesh;
    const LayerData& layer = mesh.layers[2];
    EXPECT_LE(plainFit().largestWeightStep, 0.12f);
    size_t middle = 0;
    for (uint32_t v = layer.firstVertex; v < layer.firstVertex + layer.vertexCount; ++v) {
        const Vec3f p = mesh.restPositions[v];
        if (p.y > 0.55f || std::abs(p.x) > 0.02f) continue;
        float left = 0, right = 0;
        for (int k = 0; k < 4; ++k)
            (mesh.jointIndices[v][k] == 1   ? left
             : mesh.jointIndices[v][k] == 2 ? right
                                            : left) += mesh.jointIndices[v][k] == 0 ? 0 : mesh.jointWeights[v][k] / 255.0f;
        EXPECT_NEAR(left, right, 0.25f);
        ++middle;
    }
    EXPECT_GT(middle, 10u);
}

TEST(ClothedMesh, theBodyGoesOnBelowTheClothes) {
    const MeshData& mesh = plainFit().clothed.mesh;
    EXPECT_EQ(mesh.layers[0].vertexCount, body().restPositions.size());
    EXPECT_EQ(mesh.layers[0].triangleCount, body().triangles.size());
    EXPECT_LT(plainFit().insideBody, 0.01);
    size_t far = 0;
    for (size_t v = 0; v < body().restPositions.size(); ++v) {
        const float moved = glm::length(mesh.restPositions[v] - body().restPositions[v]);
        EXPECT_LT(moved, 0.02f);
        far += moved > 0.005f;
    }
    EXPECT_LT(double(far), 0.1 * double(body().restPositions.size()));  // 4 mm below a hull whose pixels are 1 cm
}

TEST(ClothedMesh, isTheSameOnAnyNumberOfThreads) {
    const auto other = dress(plainShots(), labels(), 5);
    ASSERT_TRUE(other);
    EXPECT_EQ(other->clothed.mesh.restPositions, plainFit().clothed.mesh.restPositions);
    EXPECT_EQ(other->clothed.mesh.triangles, plainFit().clothed.mesh.triangles);
    EXPECT_EQ(other->clothed.mesh.jointWeights, plainFit().clothed.mesh.jointWeights);
}

TEST(ClothedMesh, labelsThatAreNoGarmentGoToTheirSurroundings) {
    std::vector<ScanLabel> names = labels();
    names.push_back({"badge", kBadge}), names.push_back({"belt", kBelt});
    const auto fit = dress(shots(24, true, true), names);
    ASSERT_TRUE(fit) << fit.error().message;
    ASSERT_EQ(fit->decisions.size(), 5u);
    const auto& shoes = fit->decisions[2];
    EXPECT_FALSE(shoes.kept);
    EXPECT_NE(shoes.reason.find("no picture shows the label shoes"), std::string::npos) << shoes.reason;
    const auto& badge = fit->decisions[3];
    EXPECT_FALSE(badge.kept);
    EXPECT_NE(badge.reason.find("one side"), std::string::npos) << badge.reason;
    EXPECT_FALSE(fit->decisions[4].kept) << "a belt of one and a half pixels: " << fit->decisions[4].reason;
    ASSERT_EQ(fit->clothed.mesh.layers.size(), 3u);
    // The badge's surface belongs to the top.
    const SurfaceMesh top = layerOf(fit->clothed.mesh, 1);
    const ClosestSurface surface(top.positions, top.triangles);
    EXPECT_LT(surface.find({0, 1.12f, 0.156f}).distanceM, 0.015f);
}

TEST(ClothedMesh, withoutLabelsTheBodyIsTheOnlyLayer) {
    const auto rig = joints();
    std::vector<Vec3f> offsets(body().restPositions.size(), Vec3f(0.01f, 0, 0));
    Jobs jobs(2);
    std::vector<GarmentView> unlabelled = plainShots(), blank = plainShots();
    for (auto& view : unlabelled) view.labels = {};
    for (auto& view : blank) std::fill(view.mask.pixels.begin(), view.mask.pixels.end(), uint8_t(0));
    const std::vector<GarmentView> one(plainShots().begin(), plainShots().begin() + 1);
    const std::vector<ScanLabel> none;
    struct Case {
        std::span<const GarmentView> views;
        std::vector<ScanLabel> names;
        const char* says;
    };
    for (const Case& c : {Case{unlabelled, labels(), "has labels"}, Case{plainShots(), none, "no clothing labels"},
                          Case{one, labels(), "too few"}, Case{blank, labels(), "no common shape"}, Case{{}, labels(), "has labels"}}) {
        const auto fit = makeClothedMesh({body(), rig, offsets, c.views, {}, c.names}, jobs);
        ASSERT_TRUE(fit) << fit.error().message;
        EXPECT_NE(fit->summary.find(c.says), std::string::npos) << fit->summary;
        for (const GarmentDecision& decision : fit->decisions)
            EXPECT_NE(decision.reason.find(c.says), std::string::npos) << decision.label.name << ": " << decision.reason;
        ASSERT_EQ(fit->clothed.mesh.layers.size(), 1u);
        EXPECT_EQ(fit->clothed.triangleLabel.size(), body().triangles.size());
        for (size_t v = 0; v < offsets.size(); ++v) ASSERT_EQ(fit->clothed.mesh.restPositions[v], body().restPositions[v] + offsets[v]);
    }
}

TEST(ClothedMesh, refusesWhatDoesNotFit) {
    const auto rig = joints();
    Jobs jobs(1);
    const auto names = labels();
    std::vector<Vec3f> offsets(body().restPositions.size(), Vec3f(0));
    const auto code = [&](const std::vector<GarmentView>& views) {
        const auto fit = makeClothedMesh({body(), rig, offsets, views, {}, names}, jobs);
        return fit ? Code::Internal : fit.error().code;
    };
    std::vector<GarmentView> views(plainShots().begin(), plainShots().begin() + 2);
    views[1].mask.pixels.pop_back();
    EXPECT_EQ(code(views), Code::InvalidArgument);
    views = {plainShots()[0]};
    views[0].labels.widthPx = 3;
    EXPECT_EQ(code(views), Code::InvalidArgument);
    views = {plainShots()[0]};
    views[0].pose.localRotations.pop_back();
    EXPECT_EQ(code(views), Code::InvalidArgument);
    offsets[7].y = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(code(plainShots()), Code::InvalidArgument);
    offsets.pop_back();
    EXPECT_EQ(code(plainShots()), Code::InvalidArgument);
    offsets.assign(body().restPositions.size(), Vec3f(0));
    test::HeardTask task(1);
    const TaskScope scope(&task);
    const auto cancelled = makeClothedMesh({body(), rig, offsets, plainShots(), {}, names}, jobs);
    ASSERT_FALSE(cancelled);
    EXPECT_EQ(cancelled.error().code, Code::Cancelled);
}

}  // namespace
}  // namespace dpl
