// SPDX-License-Identifier: Apache-2.0
// A modelled person in a top and a skirt, drawn into masks and labels: the layers must be those clothes.
#include "reconstruction/garments/clothed_mesh.h"

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

#include "capsule.h"
#include "reconstruction/shape/closest_surface.h"
#include "reconstruction/shape/implicit_mesh.h"
#include "reconstruction/surface/mesh_raster.h"

namespace dpl {
namespace {

constexpr uint8_t kSkin = 1, kTop = 2, kSkirt = 3, kShoes = 5, kBadge = 6, kBelt = 7;
constexpr float kHemY = 0.33f, kWaistY = 0.95f;

float bodyField(const Vec3f& p) {
    const Vec3f side(std::abs(p.x), p.y, p.z);
    const float trunk = capsule(p, {0, 0.95f, 0}, {0, 1.25f, 0}, 0.14f), neck = capsule(p, {0, 1.3f, 0}, {0, 1.5f, 0}, 0.06f);
    const float head = glm::length(p - Vec3f(0, 1.6f, 0)) - 0.11f, leg = capsule(side, {0.1f, 0.1f, 0}, {0.09f, 0.9f, 0}, 0.07f);
    return std::min(std::min(trunk, neck), std::min(head, leg));
}

SurfaceMesh meshOf(const ScalarField& field, float step) {
    SampleGrid grid;
    appendSamples(grid.xs, -0.4f, 0.4f, step);
    appendSamples(grid.ys, -0.1f, 1.8f, step);
    appendSamples(grid.zs, -0.4f, 0.4f, step);
    Jobs jobs(1);
    return remesh(largestPiece(marchField(field, grid, jobs)), field, {[&](const Vec3f&) { return 1.4f * step; }, 3}, jobs);
}

const MeshData& body() {
    static const MeshData made = [] {
        const SurfaceMesh mesh = meshOf(bodyField, 0.018f);
        MeshData m;
        m.restPositions = mesh.positions;
        m.triangles = mesh.triangles;
        for (const Vec3f& p : mesh.positions) {
            const float leg = std::clamp((0.95f - p.y) / 0.15f, 0.0f, 1.0f);
            const float left = leg * std::clamp(0.5f + p.x / 0.06f, 0.0f, 1.0f), right = leg - left;
            const auto l = uint8_t(std::lround(255 * left)), r = uint8_t(std::min(255 - int(l), int(std::lround(255 * right))));
            m.jointIndices.push_back({0, 1, 2, 0});
            m.jointWeights.push_back({uint8_t(255 - l - r), l, r, 0});
        }
        m.layers = {{"body", "body", 0, uint32_t(m.restPositions.size()), 0, uint32_t(m.triangles.size())}};
        return m;
    }();
    return made;
}

std::vector<JointData> joints() {
    return {{"hips", -1, {0, 0.95f, 0}, "hips"}, {"left", 0, {0.09f, 0.9f, 0}, ""}, {"right", 0, {-0.09f, 0.9f, 0}, ""}};
}

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

struct Dressed {
    std::vector<Vec3f> positions;
    std::vector<Triangle> triangles;
    std::vector<uint8_t> labels;
    void add(const SurfaceMesh& part, const std::function<uint8_t(const Vec3f&)>& labelAt) {
        const auto first = uint32_t(positions.size());
        positions.insert(positions.end(), part.positions.begin(), part.positions.end());
        for (const Triangle& t : part.triangles) {
            const uint8_t label = labelAt((part.positions[t.x] + part.positions[t.y] + part.positions[t.z]) / 3.0f);
            if (label != 0) triangles.push_back(t + first), labels.push_back(label);
        }
    }
};

/** Pictures from a ring at two heights. The subject sways, so that root poses differ. */
std::vector<GarmentView> shots(int count, bool badge = false, bool belt = false) {
    Dressed person;
    person.add({body().restPositions, body().triangles}, [](const Vec3f&) { return kSkin; });
    person.add(meshOf([](const Vec3f& p) { return bodyField(p) - 0.016f; }, 0.018f), [&](const Vec3f& p) -> uint8_t {
        if (p.y < 0.93f || p.y > 1.33f) return 0;
        if (badge && p.z > 0.06f && std::abs(p.x) < 0.12f && p.y > 1.02f && p.y < 1.22f) return kBadge;
        return belt && p.y > 1.1f && p.y < 1.115f ? kBelt : kTop;
    });
    person.add(skirt(), [](const Vec3f&) { return kSkirt; });
    std::vector<GarmentView> out;
    const auto rig = joints();
    for (int i = 0; i < count; ++i) {
        GarmentView view;
        const double a = 6.283185307179586 * i / count, c = std::cos(a), s = std::sin(a), height = i % 2 ? 1.4 : 0.6;
        view.camera = {150, 220, 230, 230, 75, 110};
        const Vec3d eye(2.4 * s, height, 2.4 * c), target(0, 0.85, 0), z = glm::normalize(target - eye);
        const Vec3d x = glm::normalize(glm::cross(z, Vec3d(0, 1, 0))), y = glm::cross(z, x);
        view.camera.viewFromWorldRotation = glm::transpose(Mat3d(x, y, z));
        view.camera.viewFromWorldTranslation = -(view.camera.viewFromWorldRotation * eye);
        view.pose = Pose::rest(3);
        view.pose.localRotations[0] = glm::angleAxis(0.02f * float(i % 3 - 1), glm::normalize(Vec3f(1, 2, 0)));
        view.pose.rootTranslation = {0.01f * float(i % 3 - 1), 0, 0.008f * float(i % 5 - 2)};
        std::vector<Mat3x4f> world;
        jointTransforms(rig, view.pose, world);
        std::vector<Vec3f> posed;
        for (const Vec3f& p : person.positions) posed.push_back(world[0] * Vec4f(p, 1));
        const MeshRaster image = rasteriseMesh(posed, person.triangles, view.camera);
        view.mask = view.labels = {150, 220, std::vector<uint8_t>(150 * 220, 0)};
        for (size_t k = 0; k < image.triangle.size(); ++k)
            if (image.triangle[k] != kNoTriangle) view.mask.pixels[k] = 255, view.labels.pixels[k] = person.labels[image.triangle[k]];
        out.push_back(std::move(view));
    }
    return out;
}

const std::vector<GarmentView>& plainShots() {
    static const std::vector<GarmentView> made = shots(24);
    return made;
}

std::vector<ScanLabel> labels() {
    return {{"background", 0}, {"body", kSkin}, {"top", kTop}, {"bottom", kSkirt}, {"shoes", kShoes}};
}

Result<GarmentFit> dress(std::span<const GarmentView> views, std::span<const ScanLabel> names, uint32_t threads = 2) {
    const auto rig = joints();
    const std::vector<Vec3f> offsets(body().restPositions.size(), Vec3f(0));
    Jobs jobs(threads);
    return makeClothedMesh({body(), rig, offsets, views, names}, {}, jobs);
}

const GarmentFit& plainFit() {
    static const GarmentFit made = [] {
        auto fit = dress(plainShots(), labels());
        EXPECT_TRUE(fit) << fit.error().message;
        return fit ? std::move(*fit) : GarmentFit{};
    }();
    return made;
}

SurfaceMesh layerOf(const ClothedMesh& clothed, size_t index) {
    const LayerData& layer = clothed.mesh.layers[index];
    SurfaceMesh out;
    out.positions.assign(clothed.mesh.restPositions.begin() + layer.firstVertex,
                         clothed.mesh.restPositions.begin() + layer.firstVertex + layer.vertexCount);
    for (uint32_t t = 0; t < layer.triangleCount; ++t)
        out.triangles.push_back(clothed.mesh.triangles[layer.firstTriangle + t] - layer.firstVertex);
    return out;
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
            EXPECT_EQ(clothed.triangleLabel[t], k == 0 ? kSkin : k == 1 ? kTop : kSkirt);
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
    const SurfaceMesh found = layerOf(plainFit().clothed, 2), truth = skirt();
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
    const SurfaceMesh top = layerOf(fit->clothed, 1);
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
        const auto fit = makeClothedMesh({body(), rig, offsets, c.views, c.names}, {}, jobs);
        ASSERT_TRUE(fit) << fit.error().message;
        EXPECT_NE(fit->summary.find(c.says), std::string::npos) << fit->summary;
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
        const auto fit = makeClothedMesh({body(), rig, offsets, views, names}, {}, jobs);
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
    const auto cancelled = makeClothedMesh(
        {body(), rig, offsets, plainShots(), names}, [](double) { return false; }, jobs);
    ASSERT_FALSE(cancelled);
    EXPECT_EQ(cancelled.error().code, Code::Cancelled);
}

}  // namespace
}  // namespace dpl
