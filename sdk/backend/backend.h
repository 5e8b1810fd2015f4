// SPDX-License-Identifier: Apache-2.0
// The interface between sdk/render, which plans frames, and a graphics API, which runs them. No Vulkan or Metal type appears here.
//
//   at load:      createBuffer, write, computePipeline, drawPipeline, createTarget, createFrame (checks and records the steps once)
//   each frame:   fill the mapped upload buffers, submit(frame); once finished(frame), read the mapped read-back buffers
//   or:           fill the mapped upload buffers, encode(frame) into the app's commands, which the app submits
//
// Frames run in the order in which they are submitted. Each frame in flight needs its own upload and read-back buffers. Frames may share
// all other buffers.
//
// One thread at a time. Handles are small numbers that are never used again: createFrame refuses those of destroyed objects.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sdk/core/pass_time.h"
#include "sdk/core/result.h"

namespace dpl {

template <class Tag>
struct GpuId {
    uint32_t value = 0;  // 0 = none
    explicit operator bool() const { return value != 0; }
    bool operator==(const GpuId&) const = default;
};
using BufferId = GpuId<struct BufferTag>;
using PipelineId = GpuId<struct PipelineTag>;
using TargetId = GpuId<struct TargetTag>;
using FrameId = GpuId<struct FrameTag>;

enum class DeviceKind : uint8_t { Discrete, Integrated, Virtual, Software, Other };

struct DeviceInfo {
    std::string name;
    std::string identity;  // equal only when device, driver version and shader pack are equal
    DeviceKind kind = DeviceKind::Other;
    uint64_t maxBindingBytes = 0;    // of one storage buffer binding
    uint64_t memoryBytes = 0;        // of its own, or of what it shares with the CPU. 0: not known
    uint32_t maxTargetPx = 0;        // width or height of a target
    uint32_t maxGroups = 0;          // workgroups of one dispatch
    uint32_t maxStorageBuffers = 0;  // that a compute kernel binds; at least 4. 0: not asked for
    uint32_t maxSharedBytes = 0;     // of a workgroup; at least 16 KiB. 0: not asked for
    bool multiview = false;          // one draw fills all layers of a target; otherwise each layer needs its own draw
    bool viewsAreInstances = false;  // with multiview, the arguments of a draw count instances × views (Metal)
    bool halfDepth = false;          // depth sums are read back as 2 x f16 instead of 2 x f32
    bool timestamps = false;
    bool shuffle = false;       // compute subgroups have 8 to 64 lanes in the order of the workgroup, and can shuffle
    bool typedFormats = false;  // typed buffers of 1, 2 and 4 words may be as large as storage buffers
    bool texels = false;        // kernels read typed buffers (shaders/lib/reads.glsl); only where a driver needs it (vulkan/vk_quirks.cpp)
    bool fourSamples = false;   // targets may have 4 samples a pixel at the standard sample locations, each shaded by itself
    bool isSoftware() const { return kind == DeviceKind::Software; }
};

enum class BufferMemory : uint8_t {
    Device,    // filled by write() or queueCopy() at load, then by the GPU
    Upload,    // mapped; the CPU writes it before submit()
    Readback,  // mapped; the CPU reads it once the frame has finished
    Lent,      // none: stands for a buffer of an app, which it lends before each encode() (vulkan/vk_backend.h, metal/mtl_backend.h)
};
struct BufferDesc {
    std::string label;
    uint64_t bytes = 0;
    BufferMemory memory = BufferMemory::Device;
};

/** Premultiplied colour in 16-bit floats, rounded to 8 bits at the read-back; in alpha the transmittance (1 where nothing is drawn) and,
 * with `depth`, two floats for each pixel (Σ α T z and Σ α T; α opacity, T transmittance before the splat, z view depth in metres), for one
 * or two views of the same size. Alpha does not hold the opacity, because 16-bit floats near 1 are 1/2048 apart: the opacity of a pixel
 * under many faint layers would stop growing. */
struct TargetDesc {
    uint32_t widthPx = 0, heightPx = 0;  // of one view
    uint32_t views = 1;
    bool depth = false;
    bool multiview = true;  // one draw fills the layers of all views; false: each view has its own draw
    uint32_t samples = 1;   // of a pixel: 1, or 4 if DeviceInfo::fourSamples; averaged when a draw ends
    bool sampled = false;   // an app's pass reads colour and depth; otherwise only read-backs copy them
};

enum class Topology : uint8_t { Strip, List };  // of triangles

/** A pipeline for targets with the same views, multiview, depth and samples. It blends premultiplied "over", multiplies the
 *  transmittance by 1 - α, and has no vertex buffers. A draw binds the buffers of its vertex shader, then those of its fragment shader,
 * which only reads. */
struct DrawPipelineDesc {
    std::string vertex, fragment;  // names in the shader pack
    uint32_t views = 1;
    bool multiview = true;
    bool depth = false;
    uint32_t samples = 1;
    Topology topology = Topology::Strip;
};

enum class Access : uint8_t { Uniform, Read, Write, Update };
struct Binding {  // its index in the list is the binding number in the shader
    BufferId buffer;
    Access access = Access::Read;
};
struct IndirectArgs {
    BufferId buffer;
    uint64_t offset = 0;  // bytes
};
struct PushBytes {
    std::array<std::byte, 128> bytes{};
    uint32_t size = 0;
};

struct ComputeStep {
    std::string label;
    PipelineId pipeline;
    std::vector<Binding> bindings;
    PushBytes push;
    uint32_t groups = 0;    // along x; ignored when indirect is set
    IndirectArgs indirect;  // three u32
};
struct DrawStep {  // clears the target (without multiview: the layer of `view`), then makes one indirect draw
    std::string label;
    PipelineId pipeline;
    TargetId target;
    uint32_t view = 0;  // 0 with multiview; otherwise the view to draw, in rising order
    std::vector<Binding> bindings;
    PushBytes push;
    IndirectArgs args;  // four u32
};
struct FillStep {
    std::string label;
    BufferId buffer;
    uint32_t value = 0;
};
struct ReadbackStep {  // copies a target: rows without padding, top row first, view after view
    std::string label;
    TargetId target;
    BufferId colour;  // 4 bytes a pixel, the last one the transmittance: see opacityFromTransmittance()
    BufferId depth;   // 8 bytes a pixel, 4 when DeviceInfo::halfDepth; no id: depth is not read
};
/** Fills a Readback buffer from a part of a Device buffer, or copies a whole Upload or Device buffer into a part of another Device buffer.
 */
struct CopyStep {
    std::string label;
    BufferId from, to;
    uint64_t offset = 0;  // bytes, in the Device buffer
};
using Step = std::variant<FillStep, ComputeStep, DrawStep, ReadbackStep, CopyStep>;

const std::string& stepLabel(const Step& step);

/** Turns the transmittance in the fourth byte of each pixel, as a ReadbackStep leaves it, into opacity. */
inline void opacityFromTransmittance(std::span<std::byte> pixels) {
    for (size_t i = 3; i < pixels.size(); i += 4) pixels[i] = ~pixels[i];
}

/** How a frame runs: the backend submits it, or the app does, with commands of its own around it. */
enum class FrameRun : uint8_t { Submitted, Encoded };

/** A command buffer of the app in its graphics API, recording and outside any pass: VkCommandBuffer or MTLCommandBuffer. */
struct AppCommands {
    void* handle = nullptr;
};

/** Encoded frames that the app may have in flight. It numbers them by slots, 0 to kAppSlots - 1. */
constexpr uint32_t kAppSlots = 3;

/** Most bytes of queued copies that one frame of an app carries. */
constexpr uint64_t kCopiedBytesAFrame = 1u << 20;

class Backend {
public:
    virtual ~Backend() = default;
    virtual const DeviceInfo& info() const = 0;
    /** Whether a call has found that the device was lost. Then nothing runs on it any more, and most calls fail with Code::Device. */
    virtual bool lost() const { return false; }

    virtual Result<BufferId> createBuffer(const BufferDesc& desc) = 0;
    virtual void destroyBuffer(BufferId buffer) = 0;
    /** Copies into a Device buffer at load time. Blocks until the copy is done. offset: bytes. */
    virtual Status write(BufferId buffer, uint64_t offset, std::span<const std::byte> bytes) = 0;
    /** Copies from an Upload buffer into a Device buffer in the background of frames, without waiting. The bytes of `from` stay as they are
     *  until the copy has run, and `to` is used by no frame before. On a device of an app, the copy becomes part of the app's commands
     *  (Vulkan: encodeCopies); otherwise the backend submits it, one at a time. Destroying either buffer drops the copy.
     *  Returns a number for hasRun(). */
    virtual Result<uint64_t> queueCopy(BufferId from, uint64_t fromOffset, BufferId to, uint64_t toOffset, uint64_t bytes) = 0;
    /** Whether a queued copy has run. Never waits. Code::Device: the device was lost. */
    virtual Result<bool> hasRun(uint64_t copy) = 0;
    /** The memory of an Upload or Readback buffer; empty for others. Valid until the buffer is destroyed. */
    virtual std::span<std::byte> mapped(BufferId buffer) = 0;

    /** Pipelines are made once for each name or description and live as long as the backend. */
    virtual Result<PipelineId> computePipeline(std::string_view shader) = 0;
    virtual Result<PipelineId> drawPipeline(const DrawPipelineDesc& desc) = 0;
    /** Invocations along x of one workgroup of a compute pipeline, from the shader's reflection. */
    virtual uint32_t workgroupSize(PipelineId pipeline) const = 0;

    virtual Result<TargetId> createTarget(const TargetDesc& desc) = 0;
    virtual void destroyTarget(TargetId target) = 0;

    /** Checks the steps against the shaders' reflection and records them, with the barriers that the access of their bindings needs. */
    virtual Result<FrameId> createFrame(std::vector<Step> steps, FrameRun run = FrameRun::Submitted) = 0;
    /** Waits for a submitted frame if it is running. */
    virtual void destroyFrame(FrameId frame) = 0;

    /** Graphics memory of all buffers and targets. */
    virtual uint64_t residentBytes() const = 0;

    /** Starts a recorded frame and returns. If the same frame is still running, waits for it first. Allocates nothing.
     *  Code::Device when the device is lost. */
    virtual Status submit(FrameId frame) = 0;
    /** Whether the frame is not running. Never waits. */
    virtual bool finished(FrameId frame) = 0;
    /** Waits until the frame is not running. */
    virtual Status wait(FrameId frame) = 0;
    /** Writes an Encoded frame into the app's commands. The frame ends with a barrier before fragment shaders that read its results.
     *  slot: the caller promises that all commands with the slot's earlier frames have run. Objects that are destroyed while encoded
     *  frames may still need them are kept until their slots come round again. Allocates and waits for nothing. */
    virtual Status encode(FrameId frame, uint32_t slot, AppCommands commands) = 0;
    Status run(FrameId frame) {
        DPL_RETURN_IF_ERROR(submit(frame));
        return wait(frame);
    }
    /** Times of each step in the last finished run of the frame. Empty before the first run, and on a device without timestamps. */
    virtual std::vector<PassTime> passTimes(FrameId frame) = 0;
    /** Their sum. 0 where there are none. Allocates nothing. */
    virtual double frameMs(FrameId frame) = 0;
};

}  // namespace dpl
