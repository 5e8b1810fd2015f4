// SPDX-License-Identifier: Apache-2.0
#include "tests/metal/software/software_device.h"

#include <algorithm>
#include <chrono>

#include "tests/metal/software/objects.h"

namespace dpl::mtl {
namespace {

constexpr size_t kMaxFaults = 100;

double nowS() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::vector<std::weak_ptr<DeviceState>>& devices() {
    static std::vector<std::weak_ptr<DeviceState>> all;
    return all;
}

}  // namespace

SoftBuffer::SoftBuffer(uint64_t size, StorageMode storage, std::string_view label)
    : Object("buffer", label), bytes(size), storage(storage), memory(new std::byte[size]) {
    std::fill_n(memory.get(), size, std::byte(0xCD));  // what nobody wrote is garbage
}

DeviceState::~DeviceState() = default;

void DeviceState::fault(const std::string& text) {
    const auto locked = lock();
    if (faults.size() < kMaxFaults && std::find(faults.begin(), faults.end(), text) == faults.end()) faults.push_back(text);
}

void DeviceState::drop(Object* object) {
    const auto locked = lock();
    if (object->references > 0 || object->pending > 0) return;
    hazards.forget(object);
    objects.erase(object);
}

void DeviceState::release(void* handle) {
    const auto locked = lock();
    auto* object = get<Object>(handle, "release");
    if (!object) return;
    if (object->references == 0) return fault(object->name() + " is released once too often");
    if (--object->references > 0) return;
    if (object->pending > 0) fault(object->name() + " is released while commands that use it have not run");
    if (auto* encoder = dynamic_cast<SoftEncoder*>(object); encoder && encoder->commands) {
        fault(encoder->name() + " is released before endEncoding");
        encoder->commands->open = nullptr;
    }
    if (auto* commands = dynamic_cast<SoftCommands*>(object)) {  // never committed, or it has run
        if (commands->open) fault("a command buffer is released before endEncoding of its " + commands->open->name());
        unpin(*commands);
    }
    drop(object);
}

void DeviceState::unpin(SoftCommands& commands) {
    const auto locked = lock();
    for (Object* object : std::exchange(commands.used, {})) {
        --object->pending;
        drop(object);
    }
}

void DeviceState::pin(SoftCommands& commands, Object* object) {
    const auto locked = lock();
    if (object && commands.used.insert(object).second) ++object->pending;
}

void DeviceState::use(const Object* resource, uint64_t begin, uint64_t end, bool writes, const SoftCommands& commands,
                      const RunningEncoder& encoder, int stage, const std::string& what) {
    const auto locked = lock();
    if (const auto* texture = dynamic_cast<const SoftTexture*>(resource); texture && texture->desc.tracked) return;
    Place place{encoder.scope + uint64_t(stage), encoder.interval, commands.number, commands.seenCommands, &encoder.ended[stage], what};
    const std::string found = hazards.use(resource, begin, end, writes, place);
    if (!found.empty()) fault(found + ": " + resource->name());
}

void DeviceState::commit(SoftCommands& commands) {
    const auto locked = lock();
    if (commands.status != CommandStatus::NotEnqueued) return fault("a command buffer is committed twice");
    if (commands.open) fault("a command buffer is committed before endEncoding of its " + commands.open->name());
    commands.status = CommandStatus::Committed;
    commands.number = ++commits;
    commands.seenCommands = seenCommands;
    commands.ended = seen;
    commands.error = std::exchange(nextError, CommandError::None);
    commands.errorText = std::exchange(nextErrorText, {});
    ++commands.references;  // of the queue
    committed.push_back(&commands);
    if (options.looks == 0)
        while (runOne()) {
        }
}

bool DeviceState::runOne() {
    const auto locked = lock();
    if (committed.empty()) return false;
    SoftCommands& commands = *committed.front();
    if (commands.done == 0) commands.startS = nowS();
    if (commands.error == CommandError::None)
        for (; commands.done < commands.work.size(); ++commands.done)
            if (!commands.work[commands.done]()) return false;
    commands.endS = nowS();
    commands.status = commands.error == CommandError::None ? CommandStatus::Completed : CommandStatus::Error;
    commands.work.clear();
    committed.pop_front();
    unpin(commands);
    --commands.references;
    drop(&commands);
    return true;
}

void DeviceState::look() {
    const auto locked = lock();
    if (options.looks == 0 || ++looks < options.looks) return;
    looks = 0;
    runOne();
}

void DeviceState::saw(const SoftCommands& commands) {
    const auto locked = lock();
    seenCommands = std::max(seenCommands, commands.number);
}

SoftwareDevice::SoftwareDevice(const SoftwareOptions& options) : state_(std::make_shared<DeviceState>(options)) {
    devices().push_back(state_);
}

SoftwareDevice::~SoftwareDevice() {
    finish();
    std::erase_if(devices(), [&](const auto& device) { return device.lock() == state_; });
}

SoftwareDevice& SoftwareDevice::shared() {
    static SoftwareDevice device;
    return device;
}

std::unique_ptr<Seam> SoftwareDevice::seam() {
    return seamOn(state_);
}

void* SoftwareDevice::device() const {
    return state_.get();
}

void* SoftwareDevice::queue() const {
    return &state_->committed;
}

std::vector<std::string> SoftwareDevice::takeFaults() {
    const auto locked = state_->lock();
    return std::exchange(state_->faults, {});
}

std::vector<std::string> SoftwareDevice::alive() const {
    const auto locked = state_->lock();
    std::vector<std::string> names;
    for (const auto& [handle, object] : state_->objects)
        if (object->references > 0) names.push_back(object->name());
    std::sort(names.begin(), names.end());
    return names;
}

void SoftwareDevice::finish() {
    while (state_->runOne()) {
    }
}

void SoftwareDevice::failNext(CommandError error, std::string text) {
    const auto locked = state_->lock();
    state_->nextError = error;
    state_->nextErrorText = std::move(text);
}

void SoftwareDevice::signal(EventRef event, uint64_t value) {
    const auto locked = state_->lock();
    if (auto* e = state_->get<SoftEvent>(event.object, "signaledValue")) e->value = value, e->ended[value] = state_->seen;
}

Result<std::unique_ptr<Seam>> openSeam() {
    return SoftwareDevice::shared().seam();
}

Result<std::unique_ptr<Seam>> lendSeam(void* device, void* queue) {
    if (!device || !queue) return fail(Code::InvalidArgument, "the device or the queue is null");
    for (const auto& known : devices()) {
        const std::shared_ptr<DeviceState> state = known.lock();
        if (!state || state.get() != device) continue;
        if (queue != &state->committed) return fail(Code::InvalidArgument, "the queue belongs to another device");
        return seamOn(state);
    }
    return fail(Code::InvalidArgument, "this is no Metal device");
}

}  // namespace dpl::mtl
