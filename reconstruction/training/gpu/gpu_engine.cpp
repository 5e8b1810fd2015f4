// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/gpu/gpu_engine.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "sdk/math/projection.h"

namespace dpl {
namespace {

static_assert(gpu::kTrainMinLogScale == kMinLogScale && gpu::kTrainMaxLogScale == kMaxLogScale && gpu::kTrainMaxLogit == kMaxOpacityLogit);
static_assert(gpu::kTrainMaxSizeRatio == kMaxSizeRatio && gpu::kTrainLogAnisotropy == kLogAnisotropy);
static_assert(gpu::kTrainBeta1 == kAdamBeta1 && gpu::kTrainBeta2 == kAdamBeta2 && gpu::kTrainLastCorrection == kLastCorrection);

constexpr uint64_t kMostTiles = 65536;         // two digits of the sort
constexpr uint64_t kFirstEntriesPerSplat = 4;  // of the lists before a picture has shown how many are needed
constexpr double kMostOfMemory = 0.9;          // of the device's, that a training takes

template <class T>
T* mappedAs(Backend& backend, BufferId buffer) {
    return reinterpret_cast<T*>(backend.mapped(buffer).data());
}

uint32_t tilesAlong(uint32_t px) {
    return (px + gpu::kTrainTilePx - 1) / gpu::kTrainTilePx;
}

gpu::vec4 rowOf(const Cameraf& camera, int row) {
    const Mat3f& r = camera.viewFromWorldRotation;
    return {r[0][row], r[1][row], r[2][row], camera.viewFromWorldTranslation[row]};
}

/** The parts of a frame that the state does not decide. */
gpu::TrainFrame frameOf(const EngineStep& in, uint32_t splats) {
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
    f.l1Step = float(in.weights.l1 / (pixels * 3)), f.maskStep = float(in.weights.mask / pixels);
    f.clothStep = in.target.cloth.empty() ? 0.0f : float(in.weights.cloth / pixels);
    f.ssimStep = float(-double(in.weights.ssim) / (pixels * 3));
    f.edgeMaskWeight = in.target.edgeMaskWeight;
    f.hasShown = !in.target.shown.empty(), f.hasUnsure = !in.target.unsure.empty();
    if (in.update) {
        f.updates = 1, f.countsDensity = in.update->counts, f.halfHeight = in.update->halfHeight;
        f.sizeTerm = in.update->regularise.scaleHinge / float(splats), f.anisotropyTerm = in.update->regularise.anisotropy / float(splats);
    }
    return f;
}

gpu::TrainRestTriangle restOf(const RestTriangle<float>& r, const Triangle& corner) {
    gpu::TrainRestTriangle out{};
    out.i00 = r.inverse.i00, out.i01 = r.inverse.i01, out.i11 = r.inverse.i11, out.valid = r.valid;
    out.t1X = r.frame[0].x, out.t1Y = r.frame[0].y, out.t1Z = r.frame[0].z, out.corner0 = corner.x;
    out.t2X = r.frame[1].x, out.t2Y = r.frame[1].y, out.t2Z = r.frame[1].z, out.corner1 = corner.y;
    out.normalX = r.frame[2].x, out.normalY = r.frame[2].y, out.normalZ = r.frame[2].z, out.corner2 = corner.z;
    return out;
}

/** By the number of steps: what undoes the bias of both moments. */
std::vector<gpu::vec2> corrections() {
    std::vector<gpu::vec2> table(kLastCorrection + 1, {1, 1});
    for (uint32_t n = 1; n < kLastCorrection; ++n)
        table[n] = {float(1 / (1 - std::pow(double(kAdamBeta1), double(n)))), float(1 / (1 - std::pow(double(kAdamBeta2), double(n))))};
    return table;
}

template <class T>
Status writeAll(Backend& backend, BufferId buffer, const std::vector<T>& values) {
    return values.empty() ? Status() : backend.write(buffer, 0, std::as_bytes(std::span(values)));
}

template <class T>
void readAll(Backend& backend, const ReadBuffer& buffer, std::vector<T>& values) {
    if (!values.empty()) std::memcpy(values.data(), backend.mapped(buffer.host).data(), values.size() * sizeof(T));
}

}  // namespace

GpuEngine::~GpuEngine() = default;

Status GpuEngine::settle() {
    return picture_ ? backend_->wait(picture_->update) : Status();
}

KernelNeeds needsOf(const ShaderPack& kernels) {
    KernelNeeds needs;
    for (const Shader& shader : kernels.shaders) {
        const auto storage =
            std::count_if(shader.bindings.begin(), shader.bindings.end(), [](const ShaderBinding& b) { return !b.uniform; });
        needs.storageBuffers = std::max(needs.storageBuffers, uint32_t(storage));
        needs.sharedBytes = std::max(needs.sharedBytes, shader.sharedBytes);
    }
    return needs;
}

Result<std::unique_ptr<GpuEngine>> GpuEngine::create(std::unique_ptr<Backend> backend, const KernelNeeds& needs) {
    const DeviceInfo& device = backend->info();
    if (device.maxStorageBuffers < needs.storageBuffers || device.maxSharedBytes < needs.sharedBytes)
        return fail(Code::Unsupported, "{} gives a kernel {} buffers and {} bytes of shared memory; training needs {} and {}", device.name,
                    device.maxStorageBuffers, device.maxSharedBytes, needs.storageBuffers, needs.sharedBytes);
    return std::unique_ptr<GpuEngine>(new GpuEngine(std::move(backend)));
}

std::string GpuEngine::name() const {
    return backend_->info().name;
}

Status GpuEngine::upload(const EngineState& in) {
    const TrainableSplats& s = in.splats;
    const size_t n = s.count(), triangles = in.learns.size();
    const auto vertices = uint32_t(in.incidence.offset.size() - 1);
    const auto within = [vertices](const Triangle& t) { return t.x < vertices && t.y < vertices && t.z < vertices; };
    if (n == 0 || triangles == 0 || in.triangles.size() != triangles || in.bind.size() != triangles ||
        !std::all_of(in.triangles.begin(), in.triangles.end(), within) || s.triangleStart.size() != triangles + 1 ||
        s.sizeFloorM.size() != triangles || in.referenceSizeM.size() != triangles || in.incidence.corners.size() != triangles * 3 ||
        in.adam.first.size() != s.rows.size() || in.adam.steps.size() != n || in.statistics.seen.size() != n)
        return fail(Code::InvalidArgument, "the state of {} splats and {} triangles does not fit together", n, triangles);
    GpuStateSizes sizes;
    sizes.splats = uint32_t(n), sizes.triangles = uint32_t(triangles), sizes.vertices = vertices;
    sizes.shFloats = shCoefficientCount(s.shDegree) * 3, sizes.rowFloats = s.stride;
    dropPicture(), state_.reset();  // first, so that the device never holds two
    auto made = std::make_unique<GpuState>(*backend_);
    DPL_RETURN_IF_ERROR(made->make(sizes));

    std::vector<gpu::TrainSplat> splats(n, gpu::TrainSplat{});  // the rest follows from the rows
    for (size_t i = 0; i < n; ++i) {
        if (s.flags[i] & kSplatSingleFace) splats[i].flags |= gpu::kTrainSingleFace;
        if (s.flags[i] & kSplatCloth) splats[i].flags |= gpu::kTrainCloth;
        splats[i].triangle = s.triangle[i];
    }
    std::vector<gpu::TrainTriangleConstants> constants(triangles);
    for (size_t t = 0; t < triangles; ++t) constants[t] = {s.sizeFloorM[t], in.referenceSizeM[t], uint32_t(in.learns[t] != 0), 0};
    DPL_RETURN_IF_ERROR(writeAll(*backend_, made->splats, splats));
    std::vector<gpu::TrainRestTriangle> rests(triangles);
    for (size_t t = 0; t < triangles; ++t) rests[t] = restOf(in.bind[t], in.triangles[t]);
    DPL_RETURN_IF_ERROR(writeAll(*backend_, made->constants, constants));
    DPL_RETURN_IF_ERROR(writeAll(*backend_, made->rests, rests));
    DPL_RETURN_IF_ERROR(writeAll(*backend_, made->starts, s.triangleStart));
    DPL_RETURN_IF_ERROR(writeAll(*backend_, made->incidence, in.incidence.offset));
    DPL_RETURN_IF_ERROR(writeAll(*backend_, made->cornersOf, in.incidence.corners));
    DPL_RETURN_IF_ERROR(writeAll(*backend_, made->corrections, corrections()));
    DPL_RETURN_IF_ERROR(writeAll(*backend_, made->rows.device, s.rows));
    DPL_RETURN_IF_ERROR(writeAll(*backend_, made->firstMoments.device, in.adam.first));
    DPL_RETURN_IF_ERROR(writeAll(*backend_, made->secondMoments.device, in.adam.second));
    DPL_RETURN_IF_ERROR(writeAll(*backend_, made->steps.device, in.adam.steps));
    DPL_RETURN_IF_ERROR(writeAll(*backend_, made->densitySums.device, in.statistics.gradientSum));
    DPL_RETURN_IF_ERROR(writeAll(*backend_, made->seen.device, in.statistics.seen));
    DPL_RETURN_IF_ERROR(made->record(sizes));
    gpu::TrainFrame frame{};
    frame.splatCount = sizes.splats, frame.shFloats = sizes.shFloats, frame.rowFloats = sizes.rowFloats;
    std::memcpy(backend_->mapped(made->frame).data(), &frame, sizeof frame);
    DPL_RETURN_IF_ERROR(backend_->run(made->activate));
    sizes_ = sizes, shDegree_ = s.shDegree, state_ = std::move(made);
    bind_.assign(in.bind.begin(), in.bind.end());
    return setRest(bind_);
}

Status GpuEngine::setRest(std::span<const RestTriangle<float>> now) {
    if (!state_ || now.size() != sizes_.triangles)
        return fail(Code::InvalidArgument, "{} triangles at rest for an engine that holds {}", now.size(), sizes_.triangles);
    std::vector<gpu::TrainRestInverse> inverses(now.size());
    for (size_t t = 0; t < now.size(); ++t) {
        const RestInverse<float>& r = now[t].valid ? now[t].inverse : bind_[t].inverse;
        inverses[t] = {r.i00, r.i01, r.i11};
    }
    crossedBytes_ += inverses.size() * sizeof inverses[0];
    return writeAll(*backend_, state_->nows, inverses);
}

Status GpuEngine::begin(const EngineRoom& most) {
    targets_.clear();
    GpuStateSizes sizes;
    sizes.splats = most.splats, sizes.triangles = most.triangles, sizes.vertices = most.vertices;
    sizes.shFloats = shCoefficientCount(most.shDegree) * 3, sizes.rowFloats = TrainableSplats::strideFor(most.shDegree);
    GpuPictureSizes picture;
    picture.pixels = most.picturePx, picture.tiles = most.picturePx / gpu::kTrainTilePixels + 1;
    picture.entries = kFirstEntriesPerSplat * most.splats;
    BufferMaker counted(nullptr);
    DPL_RETURN_IF_ERROR(GpuState(*backend_).makeBuffers(sizes, counted));
    DPL_RETURN_IF_ERROR(GpuPicture(*backend_).makeBuffers(sizes, picture, counted));
    const DeviceInfo& device = backend_->info();
    constexpr uint64_t kMegabyte = 1000000;
    const char* remedy = "fewer splats, a preset with smaller pictures or --engine cpu need less";
    const auto available = uint64_t(kMostOfMemory * double(device.memoryBytes));
    if (available > 0 && counted.deviceBytes() > available)
        return fail(Code::OutOfMemory, "{} splats and pictures of {} pixels take {} MB of graphics memory, and {} has {} MB for them; {}",
                    most.splats, most.picturePx, counted.deviceBytes() / kMegabyte, device.name, available / kMegabyte, remedy);
    if (counted.largestBytes() > device.maxBindingBytes)
        return fail(Code::OutOfMemory, "{} splats and pictures of {} pixels need a buffer of {} MB, and {} binds {} MB at most; {}",
                    most.splats, most.picturePx, counted.largestBytes() / kMegabyte, device.name, device.maxBindingBytes / kMegabyte,
                    remedy);
    return {};
}

Status GpuEngine::checkStep(const EngineStep& in) const {
    if (!state_) return fail(Code::InvalidArgument, "the engine holds no splats yet");
    const size_t vertices = sizes_.vertices, pixels = size_t(in.target.widthPx) * in.target.heightPx;
    if (in.positions.size() != vertices || !(in.light.empty() || in.light.size() == vertices))
        return fail(Code::InvalidArgument, "a picture of {} vertices for an engine that holds {}", in.positions.size(), vertices);
    if (pixels == 0 || in.target.rgb.size() != 3 * pixels || in.target.mask.size() != pixels || in.camera.widthPx != in.target.widthPx ||
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
    if (in.update && in.update->rate.size() != sizes_.rowFloats)
        return fail(Code::InvalidArgument, "{} learning rates for rows of {}", in.update->rate.size(), sizes_.rowFloats);
    return {};
}

Status GpuEngine::holdPicture(const GpuPictureSizes& needed) {
    if (picture_ && picture_->sizes.holds(needed)) return {};
    GpuPictureSizes wanted = needed;
    if (picture_) {
        wanted.pixels = std::max(wanted.pixels, picture_->sizes.pixels), wanted.tiles = std::max(wanted.tiles, picture_->sizes.tiles);
        wanted.entries = std::max(wanted.entries, picture_->sizes.entries);
    }
    dropPicture();
    auto made = std::make_unique<GpuPicture>(*backend_);
    DPL_RETURN_IF_ERROR(made->make(sizes_, *state_, wanted));
    picture_ = std::move(made);
    return {};
}

void GpuEngine::dropPicture() {
    targets_.forgetPlace();
    picture_.reset();
}

void GpuEngine::fill(const EngineStep& in) {
    Backend& b = *backend_;
    gpu::TrainFrame frame = frameOf(in, sizes_.splats);
    frame.splatCount = sizes_.splats, frame.triangleCount = sizes_.triangles, frame.vertexCount = sizes_.vertices;
    frame.shDegree = shDegree_, frame.shFloats = sizes_.shFloats, frame.rowFloats = sizes_.rowFloats;
    frame.entryCapacity = uint32_t(picture_->sizes.entries);
    std::memcpy(b.mapped(picture_->frame).data(), &frame, sizeof frame);
    gpu::FrameCounts counts{};
    counts.visible = sizes_.splats, counts.runs = (sizes_.splats + gpu::kRun - 1) / gpu::kRun;
    std::memcpy(b.mapped(picture_->depthCounts).data(), &counts, sizeof counts);
    if (in.update) std::memcpy(b.mapped(picture_->rates).data(), in.update->rate.data(), in.update->rate.size() * sizeof(float));
    auto* posed = mappedAs<gpu::vec4>(b, picture_->posed.host);
    for (size_t v = 0; v < in.positions.size(); ++v) {
        const Vec3f& at = in.positions[v];
        posed[v] = {at.x, at.y, at.z, in.light.empty() ? 1.0f : in.light[v]};
    }
    crossedBytes_ += in.positions.size() * sizeof(gpu::vec4) + sizeof frame;
}

LossValues GpuEngine::lossOf(const EngineStep& in) const {
    const size_t pixels = size_t(in.target.widthPx) * in.target.heightPx, groups = (pixels + 255) / 256;
    const float* sums = mappedAs<const float>(*backend_, picture_->sums.host);
    double total[gpu::kTrainSums] = {};
    for (size_t g = 0; g < groups; ++g)
        for (size_t k = 0; k < gpu::kTrainSums; ++k) total[k] += double(sums[g * gpu::kTrainSums + k]);
    LossValues v;
    v.l1 = total[0] / double(pixels * 3), v.mask = total[1] / double(pixels), v.cloth = total[2] / double(pixels);
    v.squaredError = total[3], v.squaredCount = total[4];
    v.ssim = in.weights.ssim > 0 ? total[5] / double(pixels * 3) : 0;
    v.total = in.weights.l1 * v.l1 + in.weights.ssim * v.ssim + in.weights.mask * v.mask;
    if (!in.target.cloth.empty()) v.total += in.weights.cloth * v.cloth;
    return v;
}

Result<LossValues> GpuEngine::step(const EngineStep& in) {
    DPL_RETURN_IF_ERROR(checkStep(in));
    DPL_RETURN_IF_ERROR(settle());
    GpuPictureSizes needed;
    needed.pixels = uint64_t(in.target.widthPx) * in.target.heightPx;
    needed.tiles = uint64_t(tilesAlong(in.target.widthPx)) * tilesAlong(in.target.heightPx);
    needed.entries = picture_ ? 0 : kFirstEntriesPerSplat * sizes_.splats;
    for (;;) {
        DPL_RETURN_IF_ERROR(holdPicture(needed));
        fill(in);
        DPL_RETURN_IF_ERROR(targets_.show(in.target, in.name, picture_->target));
        DPL_RETURN_IF_ERROR(backend_->run(picture_->step));
        crossedBytes_ +=
            targets_.takeBytes() + sizes_.vertices * sizeof(gpu::vec4) + (needed.pixels + 255) / 256 * gpu::kTrainSums * sizeof(float);
        entries_ = mappedAs<const gpu::FrameCounts>(*backend_, picture_->counts.host)->tileEntries;
        if (entries_ <= picture_->sizes.entries) break;
        needed.entries = uint64_t(entries_) + entries_ / 4;  // once more, with lists that are long enough; nothing was updated
    }
    if (in.update) DPL_RETURN_IF_ERROR(backend_->submit(picture_->update));
    return lossOf(in);
}

std::span<const Vec4f> GpuEngine::vertexGradients() const {
    if (!picture_) return {};
    return {mappedAs<const Vec4f>(*backend_, picture_->vertices.host), sizes_.vertices};
}

std::vector<PassTime> GpuEngine::passTimes() {
    if (!picture_ || !settle()) return {};
    std::vector<PassTime> times = backend_->passTimes(picture_->step), update = backend_->passTimes(picture_->update);
    times.insert(times.end(), update.begin(), update.end());
    return times;
}

Result<GpuGradients> GpuEngine::gradients() {
    if (!picture_) return fail(Code::InvalidArgument, "no step yet");
    DPL_RETURN_IF_ERROR(settle());
    DPL_RETURN_IF_ERROR(backend_->run(picture_->readGradients));
    return GpuGradients{{mappedAs<const float>(*backend_, picture_->rowGradients.host), size_t(sizes_.splats) * sizes_.rowFloats},
                        {mappedAs<const float>(*backend_, picture_->shown.host), sizes_.splats}};
}

Status GpuEngine::download(TrainableSplats& splats, AdamRows& adam, DensityStatistics& statistics) {
    if (!state_ || splats.count() != sizes_.splats || splats.stride != sizes_.rowFloats || adam.first.size() != splats.rows.size() ||
        adam.steps.size() != splats.count() || statistics.seen.size() != splats.count())
        return fail(Code::InvalidArgument, "the engine holds {} splats of another training", sizes_.splats);
    DPL_RETURN_IF_ERROR(settle());
    DPL_RETURN_IF_ERROR(backend_->run(state_->readBack));
    readAll(*backend_, state_->rows, splats.rows);
    readAll(*backend_, state_->firstMoments, adam.first);
    readAll(*backend_, state_->secondMoments, adam.second);
    readAll(*backend_, state_->steps, adam.steps);
    readAll(*backend_, state_->densitySums, statistics.gradientSum);
    readAll(*backend_, state_->seen, statistics.seen);
    splats.activate(0, splats.count());
    return {};
}

}  // namespace dpl
