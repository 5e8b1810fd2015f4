// SPDX-License-Identifier: Apache-2.0
// What handles stand for, and what every entry point does: it finds the object and keeps errors inside. Internal to sdk/api.
#pragma once

#include <cstring>
#include <memory>
#include <mutex>
#include <new>
#include <string>
#include <unordered_map>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/core/result.h"
#include "sdk/draw/renderer.h"
#include "sdk/format/avatar_data.h"
#include "sdk/include/doppel/doppel.h"

namespace dpl::api {

/** Behind a DplContext. Avatars share it, so that either may be destroyed first. */
struct Context {
    std::mutex mutex;  // held by every call on the context or one of its avatars; a load holds it only to add what it has prepared
    std::shared_ptr<Renderer> renderer;  // null once the context is destroyed; a load that still prepares keeps it alive
    std::string rendererName;
    std::vector<Cameraf> cameras;  // of the frame; kept to save allocations
};

/** Behind a DplAvatar. Guarded by context->mutex, except what never changes after loading. */
struct Avatar {
    std::shared_ptr<Context> context;
    std::shared_ptr<const AvatarData> data;  // of general splats: their name, no joints
    uint32_t splatCount = 0, shDegree = 0;
    RenderAvatarId renderId = 0;
    Vec3f restMin{0}, restMax{0};
    Pose pose, givenPose;                                          // givenPose: scratch of dplSetPose
    uint32_t drawnViews = 0, drawnWidthPx = 0, drawnHeightPx = 0;  // of the last frame
    bool drawnDepth = false, drawnMeshDepth = false;
    std::vector<std::unique_ptr<ClipData>> added;  // by dplLoadClip
    std::vector<const ClipData*> clips;            // the file's own, then the added
    std::vector<Mat3x4f> transforms;               // scratch
    FrameStats stats;                              // of the last dplGetFrameStats
    ~Avatar();
};

/** Handles are numbers that are never used twice, so a stale one is not found. */
template <class T>
class HandleTable {
public:
    explicit HandleTable(uintptr_t first) : next_(first) {}
    uintptr_t add(std::shared_ptr<T> object) {
        std::lock_guard lock(mutex_);
        const uintptr_t handle = next_;
        next_ += 2;
        objects_.emplace(handle, std::move(object));
        return handle;
    }
    std::shared_ptr<T> find(uintptr_t handle) const {
        std::lock_guard lock(mutex_);
        const auto at = objects_.find(handle);
        return at == objects_.end() ? nullptr : at->second;
    }
    std::shared_ptr<T> take(uintptr_t handle) {
        std::lock_guard lock(mutex_);
        const auto at = objects_.find(handle);
        if (at == objects_.end()) return nullptr;
        auto object = std::move(at->second);
        objects_.erase(at);
        return object;
    }

private:
    mutable std::mutex mutex_;
    std::unordered_map<uintptr_t, std::shared_ptr<T>> objects_;
    uintptr_t next_;
};

HandleTable<Context>& contexts();  // odd numbers
HandleTable<Avatar>& avatars();    // even numbers: one kind is never taken for the other

Result<std::shared_ptr<Context>> contextOf(DplContext handle);
Result<std::shared_ptr<Avatar>> avatarOf(DplAvatar handle);

/** InvalidArgument for general splats: they have no joints. */
Status checkPosable(const Avatar& avatar);

/** Remembers the error for dplGetLastError, logs a caller's mistake, and gives the public code. */
DplResult report(const char* function, const Error& error) noexcept;

/** Runs `body`, which returns Status. Exceptions become errors. */
template <class Body>
DplResult guarded(const char* function, Body&& body) noexcept {
    try {
        const Status status = body();
        return status ? DPL_OK : report(function, status.error());
    } catch (const std::bad_alloc&) {
        return report(function, Error{Code::OutOfMemory, {}});
    } catch (const std::exception& e) {
        return report(function, Error{Code::Internal, e.what()});
    } catch (...) {
        return report(function, Error{Code::Internal, {}});
    }
}

constexpr uint32_t kMaxStructSize = 4096;  // above every struct of ours: a larger structSize is an uninitialised one

/** Reads a caller's struct of a possibly newer or older version; fields that are not there stay zero. `smallest`: size in version 0.1. */
template <class T>
Result<T> readStruct(const void* from, const char* what, size_t smallest = sizeof(T)) {
    if (from == nullptr) return fail(Code::InvalidArgument, "{} is NULL", what);
    uint32_t size;
    std::memcpy(&size, from, sizeof size);
    if (size < smallest || size > kMaxStructSize)
        return fail(Code::InvalidArgument, "structSize of {} is {}; set it to sizeof the struct ({})", what, size, sizeof(T));
    T value{};
    std::memcpy(&value, from, std::min<size_t>(size, sizeof(T)));
    return value;
}

/** Copies `value` into the caller's struct without touching its structSize or anything beyond it. */
template <class T>
Status writeStruct(T* to, T value, const char* what, size_t smallest = sizeof(T)) {
    DPL_TRY(const T given, readStruct<T>(to, what, smallest));
    value.structSize = given.structSize;
    std::memcpy(static_cast<void*>(to), &value, std::min<size_t>(given.structSize, sizeof(T)));
    return {};
}

}  // namespace dpl::api
