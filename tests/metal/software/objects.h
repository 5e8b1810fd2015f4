// SPDX-License-Identifier: Apache-2.0
// The objects of the software device, and the device's state.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <unordered_map>

#include "tests/metal/software/hazards.h"
#include "tests/metal/software/software_device.h"
#include "tests/metal/software/texture.h"

namespace dpl::mtl {

struct Object {
    explicit Object(const char* kind, std::string_view label = {}) : kind(kind), label(label) {}
    virtual ~Object() = default;
    std::string name() const { return label.empty() ? std::string(kind) : std::string(kind) + " '" + label + "'"; }

    const char* kind;
    std::string label;
    uint32_t references = 1;
    uint32_t pending = 0;  // command buffers that use it and have not run
};
struct SoftBuffer : Object {
    SoftBuffer(uint64_t bytes, StorageMode storage, std::string_view label);
    uint64_t bytes;
    StorageMode storage;
    std::unique_ptr<std::byte[]> memory;
};
struct SoftTexture : Object {
    SoftTexture(const TextureDesc& desc, std::string_view label) : Object("texture", label), desc(desc), pixels(desc) {}
    TextureDesc desc;
    Pixels pixels;
};
struct SoftFunction : Object {  // a library and its only function
    SoftFunction(const char* kind, const msl::Entry* entry) : Object(kind, entry->name), entry(entry) {}
    const msl::Entry* entry;
};
struct SoftComputePipeline : Object {
    explicit SoftComputePipeline(const msl::Entry* entry) : Object("compute pipeline", entry->name), entry(entry) {}
    const msl::Entry* entry;
};
struct SoftRenderPipeline : Object {
    SoftRenderPipeline(const RenderPipelineDesc& desc, const msl::Entry* vertex, const msl::Entry* fragment)
        : Object("render pipeline", desc.label), desc(desc), vertex(vertex), fragment(fragment) {}
    RenderPipelineDesc desc;
    const msl::Entry *vertex, *fragment;
};
struct SoftDepthStencil : Object {
    SoftDepthStencil(CompareFunction nearer, bool writes) : Object("depth stencil state"), nearer(nearer), writes(writes) {}
    CompareFunction nearer;
    bool writes;
};
struct SoftFence : Object {
    SoftFence() : Object("fence") {}
    Ended ended;  // before its last update
};
struct SoftEvent : Object {
    SoftEvent() : Object("event") {}
    uint64_t value = 0;
    std::map<uint64_t, Ended> ended;  // before each value was signalled
};
struct SoftLabel : Object {
    explicit SoftLabel(std::string_view text) : Object("label", text) {}
};

/** An encoder while its commands run. */
struct RunningEncoder {
    Scope scope = 0;  // of the vertex stage; + 1: of the fragment stage
    uint32_t interval = 0;
    Ended ended[2];  // before the vertex stage, or all of it; before the fragment stage
};
struct SoftEncoder;
struct SoftCommands : Object {
    SoftCommands() : Object("command buffer") {}
    std::vector<std::function<bool()>> work;  // false: cannot go on yet
    size_t done = 0;
    std::set<Object*> used;
    SoftEncoder* open = nullptr;
    CommandStatus status = CommandStatus::NotEnqueued;
    CommandError error = CommandError::None;
    std::string errorText;
    uint64_t number = 0, seenCommands = 0;
    Ended ended;  // before its next encoder
    Ended ran;    // its encoders so far and what ended before them
    uint32_t encoders = 0;
    double startS = 0, endS = 0;
};

struct BoundBuffer {
    SoftBuffer* buffer = nullptr;                   // or bytes
    std::shared_ptr<std::vector<std::byte>> bytes;  // of setBytes
    uint64_t offset = 0;
    bool fresh = false;  // set since the last use
};
struct StageBindings {
    std::array<BoundBuffer, msl::kSlots> buffers;
    std::array<SoftTexture*, msl::kSlots> textures{};
};
enum class EncoderKind { Compute, Blit, Render };
struct SoftEncoder : Object {
    SoftEncoder(EncoderKind kind, SoftCommands* commands)
        : Object(kind == EncoderKind::Compute ? "compute encoder"
                 : kind == EncoderKind::Blit  ? "blit encoder"
                                              : "render encoder"),
          encoderKind(kind),
          commands(commands),
          running(std::make_shared<RunningEncoder>()) {}
    std::string place() const { return labels.empty() ? "an unnamed command" : "'" + labels.back() + "'"; }

    EncoderKind encoderKind;
    SoftCommands* commands;  // none: it has ended
    std::shared_ptr<RunningEncoder> running;
    std::vector<std::pair<SoftFence*, uint32_t>> updates;  // and the stages
    std::vector<std::string> labels;
    SoftComputePipeline* compute = nullptr;
    SoftRenderPipeline* render = nullptr;
    SoftDepthStencil* depthState = nullptr;
    StageBindings bindings[2];  // of compute or vertex; of fragment
    RenderPassDesc pass;
    double view[4] = {0, 0, 0, 0};
};

struct DeviceState {
    explicit DeviceState(const SoftwareOptions& options) : options(options) {}
    ~DeviceState();

    /** Metal's devices and queues may be used from any thread: loads make buffers while a program draws. Hold this while using what more
     * than one thread can reach: everything but the encoding into a command buffer. */
    [[nodiscard]] std::unique_lock<std::recursive_mutex> lock() { return std::unique_lock(mutex); }

    void fault(const std::string& text);
    /** Forgets an object that nothing needs. */
    void drop(Object* object);
    void unpin(SoftCommands& commands);
    void release(void* object);
    /** Keeps an object until the commands have run. */
    void pin(SoftCommands& commands, Object* object);
    /** A use of a resource (bytes of a buffer, slices of a texture), by the stage (0 or 1) of an encoder that runs now. */
    void use(const Object* resource, uint64_t begin, uint64_t end, bool writes, const SoftCommands& commands, const RunningEncoder& encoder,
             int stage, const std::string& what);
    void commit(SoftCommands& commands);
    /** Runs the oldest command buffer. false: there is none, or it waits for an event. */
    bool runOne();
    /** The CPU looked whether something has ended. */
    void look();
    void saw(const SoftCommands& commands);

    template <class T>
    T* add(std::unique_ptr<T> made) {
        const auto locked = lock();
        T* object = made.get();
        objects.emplace(object, std::move(made));
        return object;
    }
    /** The object behind a handle; nullptr, and a fault that names the call, when it is none. */
    template <class T>
    T* get(void* handle, const char* call) {
        const auto locked = lock();
        const auto it = objects.find(handle);
        T* object = it == objects.end() ? nullptr : dynamic_cast<T*>(it->second.get());
        if (!object) fault(std::string(call) + (handle ? ": the handle is no such object, or was released" : ": the handle is null"));
        return object;
    }

    std::recursive_mutex mutex;
    SoftwareOptions options;
    std::unordered_map<void*, std::unique_ptr<Object>> objects;
    std::deque<SoftCommands*> committed;
    std::vector<std::string> faults;
    Hazards hazards;
    Ended seen;  // by the CPU, through events
    uint64_t commits = 0, seenCommands = 0;
    uint32_t looks = 0;
    CommandError nextError = CommandError::None;
    std::string nextErrorText;
};

std::unique_ptr<Seam> seamOn(std::shared_ptr<DeviceState> state);

}  // namespace dpl::mtl
