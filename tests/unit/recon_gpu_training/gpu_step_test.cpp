// SPDX-License-Identifier: Apache-2.0
// The kernels of a training step against the trainer on the CPU, which the gradient tests hold against finite differences in double.
#include <random>

#include "reconstruction/training/trainer/backward_splats.h"
#include "reconstruction/training/trainer/train_images.h"
#include "sdk/avatar/posed_mesh.h"
#include "tests/unit/recon_gpu_training/test_engine.h"
#include "tests/unit/recon_trainer/toy_scene.h"

namespace dpl::test {
namespace {

// Both compute in float, in different orders and with another exp2. Seen: 2e-5 of the largest entry of a kind, and cosines of 1 − 1e-10.
constexpr double kRelative = 1e-3, kCosine = 0.9999;

// One pixel may take an entry of opacity 1/255 on one side alone. Where a splat covers few pixels, that is seen: the trainer on the CPU
// against itself, with the subject moved by 10 nm, gave 4e-4, and against the kernels 1.5e-3.
constexpr double kRelativeOfFewPixels = 1.0 / 255;

/** One picture of a subject in a pose, and what it is compared with. */
struct Picture {
    std::vector<JointData> joints;
    MeshData mesh;   // as splat sizes refer to it
    MeshData moved;  // the same with offsets learned
    TrainableSplats splats;
    Pose pose;
    LevelFrame level;
    LossWeights weights{0.8f, 0.2f, 0.3f, 0.1f};
    Vec3f background{0.2f, 0.7f, 0.4f};
};

struct Gradients {
    LossValues loss;
    std::vector<float> rows, vertices;  // of inactive splats zero; place and brightness of each vertex
    std::vector<uint8_t> active;
    std::vector<float> screenLength;
    uint32_t entries = 0;
};

Gradients onCpu(const Picture& p) {
    Jobs jobs(2);
    const auto bind = restTriangles(p.mesh), now = restTriangles(p.moved);
    PosedMesh posed;
    posed.pose({p.joints, p.moved, {}, {bind, now}}, p.pose, jobs);
    SplatEngine engine(jobs);
    engine.project(p.splats.view(), posed.frames(), p.level.camera, p.level.kappaPx2, true, true);
    engine.bin();
    SplatImage image;
    engine.blend(image, {.cloth = !p.level.cloth.empty(), .depth = false, .recordStops = true});
    ImageGradient gradient;
    Gradients out;
    PictureLoss loss(jobs);
    out.loss = loss.run(image, p.level.target(), p.weights, p.background, gradient);
    PixelBackward pixels(jobs);
    pixels.run(engine, image, gradient);
    SplatBackward backward(jobs);
    backward.run({p.splats, posed.frames(), {bind, now}, p.level.camera, engine.projected(), engine.forwardRecords(), pixels.sums()}, true);
    std::vector<Vec3f> place;
    std::vector<float> light;
    backward.gatherVertices(VertexIncidence(p.mesh.triangles, p.mesh.restPositions.size()), place, light);
    out.active.assign(backward.active().begin(), backward.active().end());
    out.screenLength.assign(backward.screenGradientLength().begin(), backward.screenGradientLength().end());
    out.rows.assign(backward.rowGradients().begin(), backward.rowGradients().end());
    for (size_t i = 0; i < out.active.size(); ++i)
        if (!out.active[i]) std::fill_n(out.rows.begin() + long(i * p.splats.stride), p.splats.stride, 0.0f);
    for (size_t v = 0; v < place.size(); ++v) out.vertices.insert(out.vertices.end(), {place[v].x, place[v].y, place[v].z, light[v]});
    out.entries = engine.tiles().offset.back();
    return out;
}

Result<Gradients> onGpu(GpuEngine& engine, const Picture& p) {
    Jobs jobs(1);
    const auto bind = restTriangles(p.mesh), now = restTriangles(p.moved);
    PosedMesh posed;
    posed.pose({p.joints, p.moved, {}, {bind, now}}, p.pose, jobs);
    const VertexIncidence incidence(p.mesh.triangles, p.mesh.restPositions.size());
    const size_t triangles = p.mesh.triangles.size();
    AdamRows adam;
    DensityStatistics statistics;
    adam.resize(p.splats.count(), p.splats.stride), statistics.resize(p.splats.count());
    const std::vector<uint8_t> learns(triangles, 1);
    const std::vector<float> referenceSizeM(triangles, 0.01f);
    DPL_RETURN_IF_ERROR(engine.upload({p.splats, adam, statistics, learns, referenceSizeM, incidence, p.mesh.triangles, bind}));
    DPL_RETURN_IF_ERROR(engine.setRest(now));
    Gradients out;
    DPL_TRY(out.loss, engine.step({posed.positions(), posed.light(), p.level.camera, p.level.kappaPx2, p.level.target(), p.level.name,
                                   p.weights, p.background}));
    out.entries = engine.entries();
    for (const Vec4f& v : engine.vertexGradients()) out.vertices.insert(out.vertices.end(), {v.x, v.y, v.z, v.w});
    DPL_TRY(const GpuGradients g, engine.gradients());
    out.rows.assign(g.rows.begin(), g.rows.end());
    for (const float length : g.screenLength) {
        out.active.push_back(length >= 0);
        out.screenLength.push_back(length);
    }
    for (size_t i = 0; i < out.active.size(); ++i)
        if (!out.active[i]) std::fill_n(out.rows.begin() + long(i * p.splats.stride), p.splats.stride, 0.0f);
    return out;
}

/** Columns [first, last) of rows of `stride`: differences against the largest entry, and the angle between both. */
void expectClose(const std::vector<float>& cpu, const std::vector<float>& gpu, size_t stride, size_t first, size_t last, const char* name,
                 double relative) {
    ASSERT_EQ(cpu.size(), gpu.size());
    double largest = 0, worst = 0, dot = 0, cc = 0, gg = 0;
    for (size_t row = 0; row < cpu.size() / stride; ++row)
        for (size_t k = first; k < last; ++k) {
            const double c = double(cpu[row * stride + k]), g = double(gpu[row * stride + k]);
            ASSERT_TRUE(std::isfinite(g)) << name << " of row " << row;
            largest = std::max(largest, std::abs(c)), worst = std::max(worst, std::abs(c - g));
            dot += c * g, cc += c * c, gg += g * g;
        }
    EXPECT_GT(largest, 0) << name;
    EXPECT_LE(worst, relative * largest) << name;
    EXPECT_GE(dot / std::sqrt(cc * gg), kCosine) << name;
}

void expectSame(const Picture& p, double relative = kRelative) {
    GpuEngine* engine = testEngine();
    if (!engine) GTEST_SKIP() << "no device";
    const Gradients cpu = onCpu(p);
    const auto gpu = onGpu(*engine, p);
    ASSERT_TRUE(gpu) << gpu.error().message;
    EXPECT_NEAR(gpu->loss.l1, cpu.loss.l1, 1e-5 * cpu.loss.l1);
    EXPECT_NEAR(gpu->loss.ssim, cpu.loss.ssim, 1e-5 * cpu.loss.ssim + 1e-7);
    EXPECT_NEAR(gpu->loss.mask, cpu.loss.mask, 1e-5 * cpu.loss.mask);
    EXPECT_NEAR(gpu->loss.cloth, cpu.loss.cloth, 1e-5 * cpu.loss.cloth);
    EXPECT_NEAR(gpu->loss.total, cpu.loss.total, 1e-5 * cpu.loss.total);
    EXPECT_NEAR(gpu->loss.squaredError, cpu.loss.squaredError, 1e-4 * cpu.loss.squaredError);
    EXPECT_EQ(gpu->loss.squaredCount, cpu.loss.squaredCount);
    EXPECT_NEAR(double(gpu->entries), double(cpu.entries), 1e-3 * cpu.entries + 2);
    size_t differ = 0;
    for (size_t i = 0; i < cpu.active.size(); ++i) differ += (cpu.active[i] != 0) != (gpu->active[i] != 0);
    EXPECT_LE(differ, cpu.active.size() / 1000) << "splats that one side alone shows";
    const size_t stride = p.splats.stride, sh = kRowSh + shCoefficientCount(p.splats.shDegree) * 3;
    const char* names[] = {"u", "v", "phi", "log s1", "log s2", "opacity logit"};
    for (size_t k = 0; k < 6; ++k) expectClose(cpu.rows, gpu->rows, stride, k, k + 1, names[k], relative);
    expectClose(cpu.rows, gpu->rows, stride, kRowSh, kRowSh + 3, "sh band 0", relative);
    if (sh > kRowSh + 3) expectClose(cpu.rows, gpu->rows, stride, kRowSh + 3, sh, "sh above", relative);
    for (size_t k = sh; k < stride; ++k)
        for (size_t i = 0; i < cpu.active.size(); ++i) ASSERT_EQ(gpu->rows[i * stride + k], 0.0f) << "padding of a row";
    expectClose(cpu.vertices, gpu->vertices, 4, 0, 3, "vertices", relative);
    expectClose(cpu.vertices, gpu->vertices, 4, 3, 4, "brightness", relative);
}

/** A ball of 1,500 splats before the camera of a toy frame, in a bent pose, with learned offsets. */
Picture toyPicture(uint32_t shDegree, uint32_t sizePx, uint32_t seed) {
    Jobs jobs(2);
    CoOptimiseInput scene = toyScene(jobs, 4, 0.004f, 0.03f, sizePx);
    scene.frames = labelled(std::move(scene.frames), 2);
    Picture p;
    p.joints = scene.joints, p.mesh = p.moved = scene.mesh;
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    std::uniform_real_distribution<float> u01(0, 1);
    for (Vec3f& v : p.moved.restPositions) v += 0.002f * Vec3f(normal(random), normal(random), normal(random));
    const TrainFrame& frame = scene.frames[1];
    p.pose = frame.pose;
    p.pose.localRotations[1] = glm::angleAxis(0.3f, glm::normalize(Vec3f(1, 0.2f, 0.1f)));
    p.level = makeLevelFrame(frame, **frame.picture.get(), 1, std::array<uint8_t, 1>{2}, true);
    p.splats.resize(1500, shDegree);
    for (uint32_t i = 0; i < p.splats.count(); ++i) {
        p.splats.triangle[i] = uint32_t(uint64_t(i) * p.mesh.triangles.size() / p.splats.count());
        p.splats.flags[i] = uint8_t((i % 3 == 0 ? kSplatSingleFace : 0) | (i % 2 ? kSplatCloth : 0));
        float* row = p.splats.rows.data() + size_t(i) * p.splats.stride;
        row[kRowU] = 0.6f * u01(random), row[kRowV] = 0.4f * u01(random), row[kRowPhi] = 3 * u01(random);
        row[kRowLogScale1] = std::log(0.004f + 0.02f * u01(random)), row[kRowLogScale2] = std::log(0.002f + 0.01f * u01(random));
        row[kRowOpacityLogit] = 2 * normal(random);
        for (uint32_t k = 0; k < shCoefficientCount(shDegree) * 3; ++k) row[kRowSh + k] = (k < 3 ? 0.8f : 0.15f) * normal(random);
    }
    p.splats.sizeFloorM.assign(p.mesh.triangles.size(), 0.001f);
    p.splats.indexTriangles(p.mesh.triangles.size());
    p.splats.activateAll(jobs);
    return p;
}

TEST(GpuStep, equalsTheTrainerOnTheCpuAtEachDegreeOfTheHarmonics) {
    for (const uint32_t degree : {0u, 1u, 2u, 3u}) {
        SCOPED_TRACE(degree);
        expectSame(toyPicture(degree, 72, 3 + degree));
        if (IsSkipped()) return;
    }
}

/** Entries of the fullest tile. */
uint32_t longestTile(const Picture& p) {
    Jobs jobs(1);
    const auto bind = restTriangles(p.mesh), now = restTriangles(p.moved);
    PosedMesh posed;
    posed.pose({p.joints, p.moved, {}, {bind, now}}, p.pose, jobs);
    SplatEngine engine(jobs);
    engine.project(p.splats.view(), posed.frames(), p.level.camera, p.level.kappaPx2, true, true);
    engine.bin();
    uint32_t longest = 0;
    for (size_t t = 1; t < engine.tiles().offset.size(); ++t)
        longest = std::max(longest, engine.tiles().offset[t] - engine.tiles().offset[t - 1]);
    return longest;
}

TEST(GpuStep, equalsTheTrainerWhereManySplatsCoverAPixel) {
    Picture p = toyPicture(1, 72, 11);
    for (uint32_t i = 0; i < p.splats.count(); ++i) {  // tiles then hold more entries than the ring of a workgroup
        float* row = p.splats.rows.data() + size_t(i) * p.splats.stride;
        row[kRowOpacityLogit] = 0.2f * row[kRowOpacityLogit] - 3, row[kRowLogScale1] = std::log(0.08f),
        row[kRowLogScale2] = std::log(0.06f);
    }
    Jobs jobs(1);
    p.splats.activateAll(jobs);
    EXPECT_GT(longestTile(p), 2 * gpu::kTrainTilePixels);
    expectSame(p);
}

TEST(GpuStep, equalsTheTrainerOnNeedlesEdgesAndOpaqueSplats) {
    Picture p = toyPicture(1, 90, 17);
    for (uint32_t i = 0; i < p.splats.count(); ++i) {
        float* row = p.splats.rows.data() + size_t(i) * p.splats.stride;
        if (i % 4 == 0) row[kRowLogScale1] = std::log(0.05f), row[kRowLogScale2] = std::log(0.0004f);
        if (i % 4 == 1) row[kRowOpacityLogit] = 7;  // the cap of 0.99
        if (i % 4 == 2) row[kRowSh] = 4;            // a colour beyond its clamp
    }
    Jobs jobs(1);
    p.splats.activateAll(jobs);
    expectSame(p, kRelativeOfFewPixels);
}

TEST(GpuStep, equalsTheTrainerWhereTrianglesAreStretchedBeyondTheirBounds) {
    Picture p = toyPicture(1, 72, 23);
    p.pose.localRotations[1] = glm::angleAxis(2.4f, glm::normalize(Vec3f(1, 0.3f, 0.2f)));
    Jobs jobs(1);
    PosedMesh posed;
    const auto bind = restTriangles(p.mesh), now = restTriangles(p.moved);
    posed.pose({p.joints, p.moved, {}, {bind, now}}, p.pose, jobs);
    EXPECT_GT(std::count_if(posed.frames().begin(), posed.frames().end(), [](const auto& f) { return f.bounded && f.valid; }), 10);
    expectSame(p);
}

TEST(GpuStep, equalsTheTrainerWithAnUnsureEdgeAndWithoutLabels) {
    Picture p = toyPicture(1, 72, 29);
    p.level.cloth.clear();
    const size_t pixels = p.level.mask.size();
    p.level.unsure.assign(pixels, 0), p.level.shown = p.level.mask, p.level.behind.assign(3 * pixels, 0);
    for (size_t i = 1; i < pixels; ++i)
        if (p.level.mask[i] != p.level.mask[i - 1]) {
            p.level.unsure[i] = 200, p.level.shown[i] = 255;
            for (size_t c = 0; c < 3; ++c) p.level.behind[c * pixels + i] = uint8_t(40 + 50 * c);
        }
    p.level.edgeMaskWeight = 0.25f;
    p.weights.cloth = 0;
    GpuEngine* engine = testEngine();
    if (!engine) GTEST_SKIP() << "no device";
    expectSame(p);
}

TEST(GpuStep, givesTheSameBytesAgainAndAfterAnotherPicture) {
    GpuEngine* engine = testEngine();
    if (!engine) GTEST_SKIP() << "no device";
    const Picture p = toyPicture(2, 72, 31), other = toyPicture(2, 90, 37);
    const auto first = onGpu(*engine, p);
    ASSERT_TRUE(first) << first.error().message;
    ASSERT_TRUE(onGpu(*engine, other));
    const auto second = onGpu(*engine, p);
    ASSERT_TRUE(second) << second.error().message;
    EXPECT_EQ(first->rows, second->rows);
    EXPECT_EQ(first->vertices, second->vertices);
    EXPECT_EQ(first->loss.total, second->loss.total);
}

TEST(GpuStep, aTargetThatItKeptGivesTheSameBytes) {
    GpuEngine* engine = testEngine();
    if (!engine) GTEST_SKIP() << "no device";
    Picture p = toyPicture(1, 72, 31), other = toyPicture(1, 90, 37);
    const auto unnamed = onGpu(*engine, p);
    ASSERT_TRUE(unnamed) << unnamed.error().message;
    p.level.name = TargetName{5, 2}, other.level.name = TargetName{4, 2};
    ASSERT_TRUE(onGpu(*engine, p));
    ASSERT_TRUE(onGpu(*engine, other));
    const auto target = p.level.rgb;
    std::fill(p.level.rgb.begin(), p.level.rgb.end(), uint8_t(0));  // not looked at again
    const auto kept = onGpu(*engine, p);
    ASSERT_TRUE(kept) << kept.error().message;
    EXPECT_EQ(kept->rows, unnamed->rows);
    EXPECT_EQ(kept->loss.total, unnamed->loss.total);
    p.level.rgb = target, p.level.name->level = 3;  // of another level: taken anew
    const auto again = onGpu(*engine, p);
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(again->rows, unnamed->rows);
}

TEST(GpuStep, refusesWhatDoesNotFit) {
    GpuEngine* engine = testEngine();
    if (!engine) GTEST_SKIP() << "no device";
    Picture p = toyPicture(1, 72, 41);
    p.level.mask.pop_back();
    const auto wrong = onGpu(*engine, p);
    ASSERT_FALSE(wrong);
    EXPECT_EQ(wrong.error().code, Code::InvalidArgument);
    Picture wide = toyPicture(1, 72, 41);
    wide.level.widthPx = wide.level.camera.widthPx = 70000, wide.level.heightPx = wide.level.camera.heightPx = 257;
    const auto tooMany = onGpu(*engine, wide);
    ASSERT_FALSE(tooMany);
}

}  // namespace
}  // namespace dpl::test
