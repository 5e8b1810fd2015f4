// SPDX-License-Identifier: Apache-2.0
#include "sdk/api/load.h"

#include <algorithm>
#include <chrono>
#include <optional>

#include "sdk/api/decode_file.h"
#include "sdk/core/files.h"
#include "sdk/core/log.h"
#include "sdk/format/avatar_head.h"
#include "sdk/visibility/lean_splats.h"

namespace dpl::api {
namespace {

// Shares of the progress: reading the file, converting it for the renderer, uploading it.
constexpr double kDecoded = 0.5, kPrepared = 0.7;
constexpr auto kUploadPause = std::chrono::milliseconds(1);  // until a frame may have run the copies
constexpr auto kLostPause = std::chrono::milliseconds(10);   // until a program may have replaced its device

/** Converts the file for the renderer. keep: the splats may be needed again, leaner. */
Result<std::unique_ptr<PreparedSubject>> prepare(const Renderer& renderer, Decoded& decoded, const Leanness& lean, bool keep) {
    Avatar& avatar = *decoded.avatar;
    const bool whole = lean == Leanness{avatar.fileShDegree, 1};
    avatar.shDegree = lean.shDegree, avatar.splatCount = avatar.fileSplatCount;
    if (decoded.general) {
        if (whole) return renderer.prepareSplats(*decoded.general);
        const StaticSplatData leaner = leanSplats(*decoded.general, lean);
        avatar.splatCount = leaner.count();
        return renderer.prepareSplats(leaner);
    }
    if (whole && !keep) return renderer.prepareAvatar(avatar.data, std::move(decoded.splats));
    CodedSplats splats = leanSplats(*avatar.data, decoded.splats, lean);
    avatar.splatCount = splats.count();
    return renderer.prepareAvatar(avatar.data, std::move(splats));
}

bool callerWaits(Load& load) {
    const std::lock_guard lock(load.mutex);
    return load.finishing;
}

/** Returns early when somebody waits for the load, or cancels it. */
void pause(Load& load, std::chrono::milliseconds time) {
    std::unique_lock lock(load.mutex);
    load.changed.wait_for(lock, time, [&] { return load.finishing || load.task.cancelled(); });
}

/** The renderer of the context, which `keeps` keeps. A load for which the caller waits gets the error of a lost device; another one waits
 * for a new one. */
Result<std::shared_ptr<Renderer>> rendererFor(Load& load, std::shared_lock<std::shared_mutex>& keeps) {
    Context& context = *load.context;
    while (true) {
        DPL_RETURN_IF_ERROR(taskAt(0));
        {
            const std::lock_guard lock(context.mutex);
            const Status usable = checkUsable(context);
            if (usable) return context.renderer;
            if (usable.error().code != Code::Device || callerWaits(load)) return usable.error();
        }
        keeps.unlock();
        pause(load, kLostPause);
        keeps.lock();
    }
}

/** Uploads the subject, or sees its upload through that another device began. */
Status upload(Load& load, RenderAvatarId id, std::shared_lock<std::shared_mutex>& keeps) {
    Context& context = *load.context;
    const TaskPart part(kPrepared, 1);
    while (true) {
        DPL_TRY(const std::shared_ptr<Renderer> renderer, rendererFor(load, keeps));
        UploadSlice slice;
        double share = 0;
        {
            const std::lock_guard lock(context.mutex);
            if (callerWaits(load)) return renderer->finishUpload(id);
            const auto continued = renderer->continueUpload(id, slice);
            if (!continued && continued.error().code != Code::Device) return continued.error();
            if (continued) share = *continued;
        }
        if (share == 1) return {};
        DPL_RETURN_IF_ERROR(taskAt(share));
        if (!slice.from.empty()) {
            std::memcpy(slice.to.data(), slice.from.data(), slice.from.size());
            continue;
        }
        keeps.unlock();
        pause(load, kUploadPause);
        keeps.lock();
    }
}

void setState(Load& load, LoadState state) {
    const std::lock_guard lock(load.mutex);
    load.state = state;
    load.changed.notify_all();
}

/** What an attempt took, and what there was. */
struct Memory {
    uint64_t needs = 0;
    std::optional<uint64_t> room;  // none: unknown
};

/** Gives the subject to the renderer and uploads it. OutOfMemory: it does not fit; then nothing of it is left in the renderer. */
Status place(Load& load, Decoded& decoded, const Leanness& lean, Memory& memory, std::shared_lock<std::shared_mutex>& keeps) {
    Context& context = *load.context;
    Avatar& avatar = *decoded.avatar;
    memory = {};
    std::unique_ptr<PreparedSubject> subject;
    {
        const TaskPart part(kDecoded, kPrepared);
        DPL_TRY(const std::shared_ptr<const Renderer> renderer, rendererFor(load, keeps));
        uint64_t limit = 0;
        {
            const std::lock_guard lock(context.mutex);
            limit = context.memoryLimit;
        }
        DPL_TRY(subject, prepare(*renderer, decoded, lean, limit > 0 || !renderer->identity().empty()));
        memory.needs = subject->bytes();
        log(LogLevel::Debug, "prepared '{}': {} splats", avatar.data->name, avatar.splatCount);
        const std::lock_guard lock(context.mutex);
        if (!context.renderer) return fail(Code::InvalidArgument, "the context was destroyed while the avatar was read");
        if (const uint64_t held = context.renderer->residentBytes(); limit > 0 && held + memory.needs > limit) {
            memory.room = limit - std::min(limit, held);
            return fail(Code::OutOfMemory, "'{}' takes {} bytes of memory, and the limit of {} (dplSetMemoryLimit) leaves {}",
                        avatar.data->name, memory.needs, limit, *memory.room);
        }
        DPL_TRY(avatar.renderId, context.renderer->begin(std::move(subject)));
    }
    setState(load, LoadState::Uploading);
    const Status uploaded = upload(load, avatar.renderId, keeps);
    if (uploaded || uploaded.error().code != Code::OutOfMemory) return uploaded;
    const std::lock_guard lock(context.mutex);
    if (context.renderer) context.renderer->removeAvatar(avatar.renderId);
    avatar.renderId = 0;
    return uploaded;
}

Result<std::shared_ptr<Avatar>> loadFile(Load& load) {
    setState(load, LoadState::Decoding);
    DPL_RETURN_IF_ERROR(taskAt(0));
    Decoded decoded;
    {
        const TaskPart part(0, kDecoded);
        DPL_TRY(decoded, decodeFile(load.bytes, load.file));
    }
    load.releaseBytes();
    const std::shared_ptr<Avatar> avatar = decoded.avatar;
    avatar->context = load.context;
    std::shared_lock keeps(load.context->loads);
    LeanSearch search(avatar->fileShDegree);
    while (true) {
        Memory memory;
        const Status placed = place(load, decoded, search.lean(), memory, keeps);
        if (placed) break;
        const Error& error = placed.error();
        if (error.code == Code::Device && !callerWaits(load)) continue;  // it waits for another device
        if (error.code != Code::OutOfMemory || memory.needs == 0) return error;
        if (!search.lower(memory.needs, memory.room))
            return fail(
                Code::OutOfMemory,
                "{}; that is without SH bands and with 1/16 of its splats. Destroy other avatars, or raise the limit if there is one",
                error.message);
    }
    if (avatar->splatCount < avatar->fileSplatCount || avatar->shDegree < avatar->fileShDegree)
        log(LogLevel::Info, "'{}' is loaded with {} of {} splats and SH degree {} of {}, because memory is short", avatar->data->name,
            avatar->splatCount, avatar->fileSplatCount, avatar->shDegree, avatar->fileShDegree);
    return avatar;
}

Result<std::shared_ptr<Avatar>> loadFileCaught(Load& load) noexcept {
    try {
        return loadFile(load);
    } catch (const std::bad_alloc&) {
        return Error{Code::OutOfMemory, {}};
    } catch (const std::exception& e) {
        return Error{Code::Internal, e.what()};
    } catch (...) {
        return Error{Code::Internal, {}};
    }
}

/** The error for whoever asks for the result, who did not cancel it. Has no text if there is no memory for one. */
Error errorForCaller(const Error& error) noexcept {
    const bool cancelled = error.code == Code::Cancelled;
    try {
        return cancelled ? fail(Code::InvalidArgument, "the context was destroyed while the avatar was read") : error;
    } catch (...) {
        return {cancelled ? Code::InvalidArgument : error.code, {}};
    }
}

}  // namespace

void runLoad(Load& load) noexcept {
    const TaskScope scope(&load.task);
    auto loaded = loadFileCaught(load);
    load.releaseBytes();
    if (loaded) load.task.advance(1);
    const std::lock_guard lock(load.mutex);
    if (loaded) {
        load.avatar = std::move(*loaded);
        load.state = LoadState::Ready;
    } else {
        load.error = errorForCaller(loaded.error());
        load.state = LoadState::Failed;
    }
    load.changed.notify_all();
}

bool takenBack(Load& load) {
    const std::lock_guard lock(load.context->mutex);
    return load.context->loader && load.context->loader->takeBack(load);
}

Result<std::shared_ptr<Avatar>> finishLoad(const std::shared_ptr<Load>& load) {
    {
        const std::lock_guard lock(load->mutex);
        load->finishing = true;
        load->changed.notify_all();
    }
    if (takenBack(*load)) runLoad(*load);
    std::unique_lock lock(load->mutex);
    load->changed.wait(lock, [&] { return load->state >= LoadState::Ready; });
    if (load->state == LoadState::Failed) return load->error;
    return std::move(load->avatar);
}

Loader::~Loader() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
        for (const auto& load : waiting_) load->task.cancel();
        if (atHand_) {
            atHand_->task.cancel();
            const std::lock_guard waiting(atHand_->mutex);
            atHand_->changed.notify_all();
        }
    }
    changed_.notify_all();
    thread_.join();
}

void Loader::add(std::shared_ptr<Load> load, void (*release)(void* user)) {
    {
        const std::lock_guard lock(mutex_);
        waiting_.push_back(std::move(load));
        waiting_.back()->release = release;  // only now: nothing can fail any more
    }
    changed_.notify_all();
}

bool Loader::takeBack(const Load& load) {
    const std::lock_guard lock(mutex_);
    return std::erase_if(waiting_, [&](const auto& waiting) { return waiting.get() == &load; }) > 0;
}

void Loader::run() {
    std::unique_lock lock(mutex_);
    while (true) {
        changed_.wait(lock, [&] { return stop_ || !waiting_.empty(); });
        if (waiting_.empty()) return;
        std::shared_ptr<Load> load = std::move(waiting_.front());
        waiting_.pop_front();
        atHand_ = load;
        lock.unlock();
        runLoad(*load);
        lock.lock();
        atHand_.reset();
        lock.unlock();
        load.reset();  // perhaps the last owner of an avatar, whose end locks the context
        lock.lock();
    }
}

HandleTable<Load>& loads() {
    static auto* table = new HandleTable<Load>(0x1003);  // never freed, as contexts()
    return *table;
}

namespace {

Result<std::shared_ptr<Load>> loadOf(DplLoad handle, bool take) {
    const auto number = reinterpret_cast<uintptr_t>(handle);
    auto load = take ? loads().take(number) : loads().find(number);
    if (!load)
        return fail(Code::InvalidArgument, "{} is not a live load; was it finished or cancelled before?", handle ? "the handle" : "0");
    return load;
}

static_assert(DPL_LOAD_WAITING == int(LoadState::Waiting) && DPL_LOAD_DECODING == int(LoadState::Decoding) &&
              DPL_LOAD_UPLOADING == int(LoadState::Uploading) && DPL_LOAD_READY == int(LoadState::Ready) &&
              DPL_LOAD_FAILED == int(LoadState::Failed));

Status checkBytes(const void* data, size_t size) {
    if (data == nullptr) return fail(Code::InvalidArgument, "data is NULL");
    if (size == 0) return fail(Code::InvalidArgument, "the avatar has 0 bytes");
    return {};
}

/** A load that the calling thread will run. */
std::shared_ptr<Load> loadAtOnce(std::shared_ptr<Context> context, std::span<const uint8_t> bytes) {
    const auto load = std::make_shared<Load>();
    load->context = std::move(context);
    load->bytes = bytes;
    load->finishing = true;
    return load;
}

Result<DplAvatar> loadNow(const std::shared_ptr<Load>& load) {
    runLoad(*load);
    DPL_TRY(auto loaded, finishLoad(load));
    return reinterpret_cast<DplAvatar>(avatars().add(std::move(loaded)));
}

/** path: UTF-8. */
Result<std::filesystem::path> pathOf(const char* path) {
    if (path == nullptr) return fail(Code::InvalidArgument, "path is NULL");
    if (*path == 0) return fail(Code::InvalidArgument, "path is empty");
    try {
        return std::filesystem::path(reinterpret_cast<const char8_t*>(path));
    } catch (const std::system_error&) {  // on Windows, where paths are UTF-16
        return fail(Code::InvalidArgument, "path is not UTF-8");
    }
}

/** The bytes of the file of an avatar. What is wrong with the file is never the program's mistake. */
Result<std::vector<uint8_t>> bytesOfFile(const std::filesystem::path& path) {
    auto bytes = readFile(path, kMaxFileBytes, checkAvatarHead);
    if (!bytes && bytes.error().code == Code::InvalidArgument) return Error{Code::Io, bytes.error().message};
    return bytes;
}

}  // namespace
}  // namespace dpl::api

using namespace dpl;
using namespace dpl::api;

extern "C" DplResult dplLoadAvatar(DplContext context, const uint8_t* data, size_t size, DplAvatar* avatar) {
    return guarded("dplLoadAvatar", [&]() -> Status {
        DPL_RETURN_IF_ERROR(checkBytes(data, size));
        if (avatar == nullptr) return fail(Code::InvalidArgument, "avatar is NULL");
        DPL_TRY(auto found, contextOf(context));
        DPL_TRY(*avatar, loadNow(loadAtOnce(std::move(found), {data, size})));
        return {};
    });
}

extern "C" DplResult dplLoadAvatarFile(DplContext context, const char* path, DplAvatar* avatar) {
    return guarded("dplLoadAvatarFile", [&]() -> Status {
        DPL_TRY(const std::filesystem::path file, pathOf(path));
        if (avatar == nullptr) return fail(Code::InvalidArgument, "avatar is NULL");
        DPL_TRY(auto found, contextOf(context));
        DPL_TRY(std::vector<uint8_t> bytes, bytesOfFile(file));
        const auto load = loadAtOnce(std::move(found), bytes);
        load->file = path;
        load->release = [](void* user) { std::vector<uint8_t>().swap(*static_cast<std::vector<uint8_t>*>(user)); };
        load->user = &bytes;
        const auto loaded = loadNow(load);
        if (!loaded && loaded.error().message.empty()) return loaded.error();  // out of memory, perhaps for a text too
        if (!loaded) return fail(loaded.error().code, "{}: {}", path, loaded.error().message);
        *avatar = *loaded;
        return {};
    });
}

extern "C" DplResult dplStartLoad(DplContext context, const DplLoadInfo* info, DplLoad* load) {
    return guarded("dplStartLoad", [&]() -> Status {
        if (load == nullptr) return fail(Code::InvalidArgument, "load is NULL");
        DPL_TRY(const DplLoadInfo given, readStruct<DplLoadInfo>(info, "info"));
        DPL_RETURN_IF_ERROR(checkBytes(given.data, given.size));
        const auto made = std::make_shared<Load>();
        DPL_TRY(made->context, contextOf(context));
        made->bytes = {given.data, given.size};
        made->user = given.user;
        const std::lock_guard lock(made->context->mutex);
        if (made->context->closing) return fail(Code::InvalidArgument, "the context was destroyed");
        if (!made->context->loader) made->context->loader = std::make_unique<Loader>();
        const uintptr_t handle = loads().add(made);
        try {
            made->context->loader->add(made, given.release);
        } catch (...) {
            loads().take(handle);
            throw;
        }
        *load = reinterpret_cast<DplLoad>(handle);
        return {};
    });
}

extern "C" DplResult dplGetLoadStatus(DplLoad load, DplLoadStatus* status) {
    return guarded("dplGetLoadStatus", [&]() -> Status {
        DPL_TRY(const auto found, loadOf(load, false));
        DplLoadStatus out{};
        {
            const std::lock_guard lock(found->mutex);
            out.state = DplLoadState(int(found->state));
        }
        out.progress = float(found->task.progress());
        return writeStruct(status, out, "status");
    });
}

extern "C" DplResult dplFinishLoad(DplLoad load, DplAvatar* avatar) {
    return guarded("dplFinishLoad", [&]() -> Status {
        if (avatar == nullptr) return fail(Code::InvalidArgument, "avatar is NULL");
        DPL_TRY(const auto found, loadOf(load, true));
        DPL_TRY(auto loaded, finishLoad(found));
        *avatar = reinterpret_cast<DplAvatar>(avatars().add(std::move(loaded)));
        return {};
    });
}

extern "C" DplResult dplCancelLoad(DplLoad load) {
    return guarded("dplCancelLoad", [&]() -> Status {
        if (load == nullptr) return {};
        DPL_TRY(const auto found, loadOf(load, true));
        found->task.cancel();
        (void)takenBack(*found);
        const std::lock_guard lock(found->mutex);
        found->changed.notify_all();
        return {};
    });
}

extern "C" DplResult dplSetMemoryLimit(DplContext context, uint64_t bytes) {
    return guarded("dplSetMemoryLimit", [&]() -> Status {
        DPL_TRY(const auto found, contextOf(context));
        const std::lock_guard lock(found->mutex);
        if (!found->renderer) return fail(Code::InvalidArgument, "the context was destroyed");
        found->memoryLimit = bytes;
        return {};
    });
}
