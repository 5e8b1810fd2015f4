// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/gpu/gpu_pass.h"

#include <algorithm>
#include <cstring>

#include "sdk/math/projection.h"

namespace dpl {
namespace training {  // generated from shaders/training
std::span<const uint8_t> shaderPack();
uint64_t shaderInterface();
}  // namespace training

namespace {

constexpr uint64_t kMostTiles = 65536;       // two digits of the sort
constexpr uint64_t kFirstEntriesPerSplat = 4;  // of the lists before a picture has shown how many are needed

template <class T>
T* mappedAs(Backend& backend, BufferId buffer) {
    return reinterpret_cast<T*>(backend.mapped(buffer).data());
}

template <class T>
void fill(Backend& backend, BufferId buffer, std::span<const T> values) {
    std::memcpy(backend.mapped(buffer).data(), values.data(), values.size_bytes());
}

uint32_t tilesAlong(uint32_t px) {
    return (px + gpu::kTrainTilePx - 1) / gpu::kTrainTilePx;
}

gpu::vec4 rowOf(const Cameraf& camera, int row) {
    const Mat3f& r = camera.viewFromWorldRotation;
    return {r[0][row], r[1][row], r[2][row], camera.viewFromWorldTranslation[row]};
}

gpu::TrainFrame frameOf(const GpuPassInput& in, const GpuSizes& sizes) {
    const Cameraf& c = in.camera;
    const auto lens = lensOf(c);
    const Vec3f eye = c.eye();
    const double pixels = double(in.target.widthPx) * in.target.heightPx;
    gpu::TrainFrame f{};
    f.viewFromWorldRow0 = rowOf(c, 0), f.viewFromWorldRow1 = rowOf(c, 1), f.viewFromWorldRow2 = rowOf(c, 2);
    f.eye = {eye.x, eye.y, eye.z, 0};
    f.background = {in.background.x, in.background.y, in.background.z, 0};
    f.focalPx = {lens.focalPx.x, lens.focalPx.y}, f.centrePx = {lens.centrePx.x, lens.centrePx.y};
    f.minSlope = {lens.minSlope.x, lens.minSlope.y}, f.maxSlope = {lens.maxSlope.x, lens.maxSlope.y};
    f.kappaPx2 = in.kappaPx2;
    f.widthPx = in.target.widthPx, f.heightPx = in.target.heightPx;
    f.columns = tilesAlong(f.widthPx), f.tiles = f.columns * tilesAlong(f.heightPx);
    f.splatCount = sizes.splats, f.triangleCount = sizes.triangles, f.vertexCount = sizes.vertices;
    f.shDegree = in.splats.shDegree, f.shFloats = sizes.shFloats, f.rowFloats = sizes.rowFloats;
    f.entryCapacity = uint32_t(sizes.entries);
    f.l1Step = float(in.weights.l1 / (pixels * 3)), f.maskStep = float(in.weights.mask / pixels);
    f.clothStep = in.target.cloth.empty() ? 0.0f : float(in.weights.cloth / pixels);
    f.ssimStep = float(-double(in.weights.ssim) / (pixels * 3));
    f.edgeMaskWeight = in.target.edgeMaskWeight;
    f.hasShown = !in.target.shown.empty(), f.hasUnsure = !in.target.unsure.empty();
    return f;
}

gpu::TrainTriangle triangleOf(const TriangleFrame<float>& t) {
    const Mat3f& r = t.worldFromRest;
    gpu::TrainTriangle out{};
    out.v0X = t.v0.x, out.v0Y = t.v0.y, out.v0Z = t.v0.z, out.shown = t.shown;
    out.v1X = t.v1.x, out.v1Y = t.v1.y, out.v1Z = t.v1.z;
    out.flags = (t.valid ? gpu::kTrainValid : 0) | (t.bounded ? gpu::kTrainBounded : 0);
    out.v2X = t.v2.x, out.v2Y = t.v2.y, out.v2Z = t.v2.z, out.light0 = t.light.x;
    out.f0X = t.f0.x, out.f0Y = t.f0.y, out.f0Z = t.f0.z, out.light1 = t.light.y;
    out.f1X = t.f1.x, out.f1Y = t.f1.y, out.f1Z = t.f1.z, out.light2 = t.light.z;
    out.normalX = t.normal.x, out.normalY = t.normal.y, out.normalZ = t.normal.z;
    out.restX0 = r[0].x, out.restX1 = r[0].y, out.restX2 = r[0].z;
    out.restY0 = r[1].x, out.restY1 = r[1].y, out.restY2 = r[1].z;
    out.restZ0 = r[2].x, out.restZ1 = r[2].y, out.restZ2 = r[2].z;
    return out;
}

uint32_t bytes4(uint8_t a, uint8_t b, uint8_t c, uint8_t d) {
    return uint32_t(a) | uint32_t(b) << 8 | uint32_t(c) << 16 | uint32_t(d) << 24;
}

void packTarget(const PictureTarget& t, uint32_t* words) {
    const size_t pixels = size_t(t.widthPx) * t.heightPx;
    const auto at = [](std::span<const uint8_t> plane, size_t i) { return plane.empty() ? uint8_t(0) : plane[i]; };
    for (size_t i = 0; i < pixels; ++i, words += gpu::kTrainPictureWords) {
        words[0] = bytes4(t.rgb[i], t.rgb[pixels + i], t.rgb[2 * pixels + i], t.mask[i]);
        words[1] = bytes4(at(t.cloth, i), at(t.shown, i), at(t.unsure, i), 0);
        words[2] = t.behind.empty() ? 0 : bytes4(t.behind[i], t.behind[pixels + i], t.behind[2 * pixels + i], 0);
    }
}

Status checkInput(const GpuPassInput& in) {
    const TrainableSplats& s = in.splats;
    const size_t triangles = in.frames.size(), pixels = size_t(in.target.widthPx) * in.target.heightPx;
    if (s.count() == 0 || triangles == 0 || pixels == 0) return fail(Code::InvalidArgument, "no splats, no triangles or no picture");
    if (s.triangleStart.size() != triangles + 1 || s.sizeFloorM.size() != triangles || in.rest.bind.size() != triangles ||
        !(in.rest.now.empty() || in.rest.now.size() == triangles) || in.incidence.corners.size() != triangles * 3)
        return fail(Code::InvalidArgument, "splats, triangles at rest and corners do not fit {} triangles", triangles);
    if (in.target.rgb.size() != 3 * pixels || in.target.mask.size() != pixels || in.camera.widthPx != in.target.widthPx ||
        in.camera.heightPx != in.target.heightPx)
        return fail(Code::InvalidArgument, "the target does not fit its {} pixels or its camera", pixels);
    for (const auto plane : {in.target.cloth, in.target.shown, in.target.unsure})
        if (!plane.empty() && plane.size() != pixels) return fail(Code::InvalidArgument, "a plane of the target is not complete");
    if (!in.target.unsure.empty() && in.target.behind.size() != 3 * pixels)
        return fail(Code::InvalidArgument, "the target lacks what lies behind its edge");
    const uint64_t tiles = uint64_t(tilesAlong(in.target.widthPx)) * tilesAlong(in.target.heightPx);
    if (tiles > kMostTiles)
        return fail(Code::InvalidArgument, "a picture of {} × {} pixels has more than {} tiles", in.target.widthPx, in.target.heightPx,
                    kMostTiles);
    return {};
}

GpuSizes sizesOf(const GpuPassInput& in) {
    GpuSizes s;
    s.splats = in.splats.count(), s.triangles = uint32_t(in.frames.size()), s.vertices = uint32_t(in.incidence.offset.size() - 1);
    s.shFloats = shCoefficientCount(in.splats.shDegree) * 3, s.rowFloats = in.splats.stride;
    s.pixels = uint64_t(in.target.widthPx) * in.target.heightPx;
    s.tiles = uint64_t(tilesAlong(in.target.widthPx)) * tilesAlong(in.target.heightPx);
    return s;
}

}  // namespace

GpuPass::GpuPass(std::unique_ptr<Backend> backend) : backend_(std::move(backend)) {}
GpuPass::~GpuPass() = default;

Result<std::unique_ptr<GpuPass>> GpuPass::create(const vk::DeviceRequest& request) {
    DPL_TRY(ShaderPack pack, readShaderPack(training::shaderPack(), "the shader pack of training", training::shaderInterface()));
    size_t mostBuffers = 0, mostShared = 0;
    for (const Shader& shader : pack.shaders) {
        mostBuffers = std::max<size_t>(mostBuffers, std::count_if(shader.bindings.begin(), shader.bindings.end(), [](auto& b) { return !b.uniform; }));
        mostShared = std::max<size_t>(mostShared, shader.sharedBytes);
    }
    DPL_TRY(auto backend, vk::createBackend(request, std::move(pack)));
    const DeviceInfo& device = backend->info();
    if (device.maxStorageBuffers < mostBuffers || device.maxSharedBytes < mostShared)
        return fail(Code::Unsupported, "{} gives a kernel {} buffers and {} bytes of shared memory; training needs {} and {}", device.name,
                    device.maxStorageBuffers, device.maxSharedBytes, mostBuffers, mostShared);
    return std::unique_ptr<GpuPass>(new GpuPass(std::move(backend)));
}

const DeviceInfo& GpuPass::device() const {
    return backend_->info();
}
uint64_t GpuPass::residentBytes() const {
    return backend_->residentBytes();
}

Status GpuPass::prepare(const GpuSizes& needed) {
    if (buffers_ && buffers_->sizes.holds(needed)) return {};
    GpuSizes wanted = needed;
    if (buffers_) {
        wanted.pixels = std::max(wanted.pixels, buffers_->sizes.pixels), wanted.tiles = std::max(wanted.tiles, buffers_->sizes.tiles);
        wanted.entries = std::max(wanted.entries, buffers_->sizes.entries);
    }
    buffers_.reset();  // first, so that the device never holds both
    auto made = std::make_unique<GpuBuffers>(*backend_);
    DPL_RETURN_IF_ERROR(made->make(wanted));
    buffers_ = std::move(made);
    return {};
}

void GpuPass::upload(const GpuPassInput& in) const {
    Backend& b = *backend_;
    const TrainableSplats& s = in.splats;
    const gpu::TrainFrame frame = frameOf(in, buffers_->sizes);
    std::memcpy(b.mapped(buffers_->frame).data(), &frame, sizeof frame);
    gpu::FrameCounts counts{};
    counts.visible = s.count(), counts.runs = (s.count() + gpu::kRun - 1) / gpu::kRun;
    std::memcpy(b.mapped(buffers_->depthCounts).data(), &counts, sizeof counts);

    auto* splat = mappedAs<gpu::TrainSplat>(b, buffers_->splats.host);
    for (uint32_t i = 0; i < s.count(); ++i)
        splat[i] = {s.uv[i].x, s.uv[i].y, s.phi[i], s.opacity[i], s.scaleM[i].x, s.scaleM[i].y,
                    (s.flags[i] & kSplatSingleFace ? gpu::kTrainSingleFace : 0) | (s.flags[i] & kSplatCloth ? gpu::kTrainCloth : 0),
                    s.triangle[i]};
    fill<float>(b, buffers_->sh.host, s.sh);
    auto* triangle = mappedAs<gpu::TrainTriangle>(b, buffers_->triangles.host);
    auto* rest = mappedAs<gpu::TrainRest>(b, buffers_->rests.host);
    for (size_t t = 0; t < in.frames.size(); ++t) {
        triangle[t] = triangleOf(in.frames[t]);
        const RestTriangle<float>& bind = in.rest.bind[t];
        const RestTriangle<float>& now = in.rest.now.empty() || !in.rest.now[t].valid ? bind : in.rest.now[t];
        rest[t] = {bind.inverse.i00, bind.inverse.i01, bind.inverse.i11, now.inverse.i00, now.inverse.i01, now.inverse.i11};
    }
    fill<uint32_t>(b, buffers_->starts.host, s.triangleStart);
    fill<float>(b, buffers_->floors.host, s.sizeFloorM);
    fill<uint32_t>(b, buffers_->incidence.host, in.incidence.offset);
    fill<uint32_t>(b, buffers_->cornersOf.host, in.incidence.corners);
    packTarget(in.target, mappedAs<uint32_t>(b, buffers_->target.host));
}

GpuPassResult GpuPass::read(const GpuPassInput& in, uint32_t entries) {
    const size_t pixels = size_t(in.target.widthPx) * in.target.heightPx, groups = (pixels + 255) / 256;
    const float* sums = mappedAs<const float>(*backend_, buffers_->sums.host);
    double total[gpu::kTrainSums] = {};
    for (size_t g = 0; g < groups; ++g)
        for (size_t k = 0; k < gpu::kTrainSums; ++k) total[k] += double(sums[g * gpu::kTrainSums + k]);
    GpuPassResult r;
    LossValues& v = r.loss;
    v.l1 = total[0] / double(pixels * 3), v.mask = total[1] / double(pixels), v.cloth = total[2] / double(pixels);
    v.squaredError = total[3], v.squaredCount = total[4];
    v.ssim = in.weights.ssim > 0 ? total[5] / double(pixels * 3) : 0;
    v.total = in.weights.l1 * v.l1 + in.weights.ssim * v.ssim + in.weights.mask * v.mask;
    if (!in.target.cloth.empty()) v.total += in.weights.cloth * v.cloth;
    const size_t n = in.splats.count();
    r.rowGradients = {mappedAs<const float>(*backend_, buffers_->rows.host), n * in.splats.stride};
    r.screenLength = {mappedAs<const float>(*backend_, buffers_->shown.host), n};
    r.vertices = {mappedAs<const Vec4f>(*backend_, buffers_->vertices.host), in.incidence.offset.size() - 1};
    r.entries = entries;
    return r;
}

Result<GpuPassResult> GpuPass::run(const GpuPassInput& in) {
    DPL_RETURN_IF_ERROR(checkInput(in));
    GpuSizes needed = sizesOf(in);
    needed.entries = buffers_ ? 0 : kFirstEntriesPerSplat * needed.splats;
    for (;;) {
        DPL_RETURN_IF_ERROR(prepare(needed));
        upload(in);
        DPL_RETURN_IF_ERROR(backend_->run(buffers_->recorded));
        const uint32_t entries = mappedAs<const gpu::FrameCounts>(*backend_, buffers_->counts.host)->tileEntries;
        if (entries <= buffers_->sizes.entries) return read(in, entries);
        needed.entries = uint64_t(entries) + entries / 4;  // once more, with lists that are long enough
    }
}

}  // namespace dpl
