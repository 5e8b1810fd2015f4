// SPDX-License-Identifier: Apache-2.0
// How a backend begins and ends.
#include "sdk/backend/metal/mtl_backend.h"

#include "sdk/backend/metal/metal_backend.h"

namespace dpl::mtl {
namespace {

constexpr uint32_t kMaxTargetPx = 16384;      // of a 2D texture on MTLGPUFamilyApple3 and MTLGPUFamilyMac2
constexpr uint32_t kMaxGroups = 65535;        // Metal has no limit; this one is Vulkan's least, for which plans are made
constexpr uint64_t kMaxBinding = 1ull << 31;  // offsets in shaders have 32 bits
constexpr uint32_t kMaxSharedBytes = 32768;   // of a threadgroup, on the same families

DeviceInfo infoOf(const Seam& seam) {
    DeviceInfo info;
    info.name = seam.name();
    info.identity = info.name + "-" + seam.systemVersion();
    info.kind = seam.isSoftware() ? DeviceKind::Software : seam.hasUnifiedMemory() ? DeviceKind::Integrated : DeviceKind::Discrete;
    info.maxBindingBytes = std::min(seam.maxBufferBytes(), kMaxBinding);
    info.memoryBytes = seam.workingSetBytes();
    info.maxTargetPx = kMaxTargetPx;
    info.maxGroups = kMaxGroups;
    info.maxStorageBuffers = kViewMaskIndex - 1;  // below the indices that are taken, beside a uniform buffer
    info.maxSharedBytes = kMaxSharedBytes;
    // Layered rendering, and shuffles within a simdgroup, by Apple's table of feature sets.
    info.multiview = seam.supportsFamily(GpuFamily::Apple5) || seam.supportsFamily(GpuFamily::Mac2);
    info.viewsAreInstances = true;
    info.shuffle = seam.supportsFamily(GpuFamily::Apple6) || seam.supportsFamily(GpuFamily::Mac2);
    info.halfDepth = !seam.supports32BitMsaa();  // such a GPU cannot average RG32Float
    info.timestamps = true;
    info.fourSamples = seam.supportsSampleCount(4);  // at the standard sample locations, which are Metal's default
    return info;
}

}  // namespace

MetalBackend::MetalBackend(std::unique_ptr<Seam> seam, ShaderPack pack, bool lent)
    : SlottedBackend({"wait for the completion handler of that command buffer before, or call dplMetalDropSlot if it will never run",
                      "call dplMetalPrepare, or dplMetalUpload in a frame without pictures,", "DplMetalPass"}),
      seam_(std::move(seam)),
      pack_(std::move(pack)),
      info_(infoOf(*seam_)),
      lent_(lent) {
    info_.identity += formatText("-{}", pack_.contentHash);
    memoryless_ = seam_->supportsFamily(GpuFamily::Apple4);
}

Status MetalBackend::start() {
    if (!seam_->supportsFamily(GpuFamily::Apple4) && !seam_->supportsFamily(GpuFamily::Mac2))
        return fail(Code::Unsupported, "{} is too old: MTLGPUFamilyApple4 (A11) or MTLGPUFamilyMac2 is needed", info_.name);
    written_ = seam_->newFence();
    if (!written_) return fail(Code::Device, "{} makes no fence", info_.name);
    DPL_TRY(fill_, computePipeline("fill"));
    DPL_TRY(round_, computePipeline("round"));
    return lent_ ? makeComposing() : Status();
}

MetalBackend::~MetalBackend() {
    for (auto& [id, frame] : frames_) freeFrame(frame);  // waits; an app that lends its device waits for its own commands
    if (copyCommands_) seam_->wait(copyCommands_);
    seam_->release(copyCommands_);
    retired_.forEach([&](void* object) { seam_->release(object); });
    for (CommandsRef& commands : slotCommands_) seam_->release(commands);
    for (CommandsRef& commands : submissions_) seam_->release(commands);
    for (auto& [id, composer] : composers_) seam_->release(composer.pipeline), seam_->release(composer.depthPipeline);
    for (DepthStencilRef* state : {&keepDepth_, &nearer_[0], &nearer_[1]}) seam_->release(*state);
    for (auto& [id, target] : targets_) freeTarget(target);
    for (auto& [id, buffer] : buffers_) seam_->release(buffer.buffer);
    for (Pipeline& pipeline : pipelines_) seam_->release(pipeline.compute), seam_->release(pipeline.render);
    seam_->release(marks_);
    seam_->release(written_);
    for (FenceRef& fence : composed_) seam_->release(fence);
}

Result<std::unique_ptr<MetalBackend>> createBackendOn(std::unique_ptr<Seam> seam, bool lent) {
    DPL_TRY(ShaderPack pack, readShaderPack(embeddedMetalPack(), "the embedded shader pack for Metal", embeddedMetalInterface()));
    return createBackendOn(std::move(seam), lent, std::move(pack));
}

Result<std::unique_ptr<MetalBackend>> createBackendOn(std::unique_ptr<Seam> seam, bool lent, ShaderPack pack) {
    auto backend = std::make_unique<MetalBackend>(std::move(seam), std::move(pack), lent);
    DPL_RETURN_IF_ERROR(backend->start());
    return backend;
}

Result<std::unique_ptr<MetalBackend>> createBackendOn(void* device, void* queue) {
    DPL_TRY(auto seam, lendSeam(device, queue));
    return createBackendOn(std::move(seam), /*lent=*/true);
}

}  // namespace dpl::mtl

namespace dpl {

Result<std::unique_ptr<Backend>> createMetalBackend() {
    DPL_TRY(auto seam, mtl::openSeam());
    DPL_TRY(auto backend, mtl::createBackendOn(std::move(seam), /*lent=*/false));
    return std::unique_ptr<Backend>(std::move(backend));
}

}  // namespace dpl
