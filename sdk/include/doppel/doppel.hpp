// SPDX-License-Identifier: Apache-2.0
// C++20 wrapper of doppel.h: owns handles, takes spans and forwards to the C functions. Header only. It throws nothing itself; its
// std::string and std::vector may throw std::bad_alloc.
//
//   auto context = doppel::Context::create();
//   if (!context) return report(context.error());
//   auto avatar = context->loadAvatarFile("avatar.glb");  // Result<Avatar>, move-only owner
//   avatar->setPoseFromClip(0, 1.25);
//   auto camera = doppel::Camera::lookAt({.eye = {0, 1, 3}, .target = {0, 1, 0}, .fovYRad = 0.8f, .widthPx = 512, .heightPx = 768});
//   avatar->render(*camera, {&image, 1});
//
// Threads, units and errors: as in doppel.h.
#pragma once

// Compilers whose C++20 is young give a number between those of C++17 and C++20. MSVC gives it in _MSVC_LANG.
#if defined(_MSVC_LANG) ? _MSVC_LANG <= 201703L : __cplusplus <= 201703L
#error "doppel.hpp needs C++20: compile with -std=c++20 (MSVC: /std:c++20), or include doppel.h, which needs C99"
#else  // without the rest of this header, whose errors would hide that one

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <doppel/doppel.h>
#include <doppel/doppel_convert.h>
#include <doppel/doppel_avatar.hpp>
#include <doppel/doppel_player.hpp>

namespace doppel {

/** Version of the loaded library; see dplGetVersion. */
inline uint32_t version() {
    return dplGetVersion();
}
/** Name of a result code; see dplGetResultName. */
inline const char* resultName(DplResult result) {
    return dplGetResultName(result);
}

/** Sends the log of the process to `callback`; see dplSetLogCallback. */
inline Status setLogCallback(DplLogCallback callback, void* user = nullptr) {
    return status(dplSetLogCallback(callback, user));
}

/** How Camera::lookAt aims; see dplCameraLookAt. Eye, target and size must be given. */
struct LookAt {
    std::array<float, 3> eye{}, target{};  // metres, in the world
    std::array<float, 3> up{0, 1, 0};      // of any length; not parallel to the view direction
    float fovYRad = 0.8f;                  // vertical field of view
    uint32_t widthPx = 0, heightPx = 0;
};

/** A DplCamera whose structSize is set. */
struct Camera : Sized<DplCamera> {
    /** A camera at `how.eye` that looks at `how.target`. */
    static Result<Camera> lookAt(const LookAt& how) {
        return filled<Camera>(dplCameraLookAt, how.eye.data(), how.target.data(), how.up.data(), how.fovYRad, how.widthPx, how.heightPx);
    }
};
static_assert(sizeof(Camera) == sizeof(DplCamera));

/** Owns one load in the background, which it cancels unless it is finished. Move-only, as Avatar. */
class Load {
public:
    /** Takes ownership of `handle`, which was started with `context`. */
    Load(DplContext context, DplLoad handle) : context_(context), handle_(handle) {}
    Load(Load&& other) noexcept : context_(other.context_), handle_(std::exchange(other.handle_, nullptr)) {}
    Load& operator=(Load&& other) noexcept {
        std::swap(context_, other.context_);
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Load() { dplCancelLoad(handle_); }

    DplLoad handle() const { return handle_; }
    Result<DplLoadStatus> status() const { return filled<DplLoadStatus>(dplGetLoadStatus, handle_); }
    /** Waits if the load is neither ready nor failed; see dplFinishLoad. Afterwards this owns nothing. */
    Result<Avatar> finish() {
        DplAvatar avatar = nullptr;
        if (const DplResult r = dplFinishLoad(std::exchange(handle_, nullptr), &avatar); r != DPL_OK) return lastError(r);
        return Avatar(context_, avatar);
    }

private:
    DplContext context_ = nullptr;
    DplLoad handle_ = nullptr;
};

/** Owns one context, which it destroys. Move-only, as Avatar. Its avatars may be destroyed before or after it. */
class Context {
public:
    /** Parameters: fields of DplContextInfo. */
    static Result<Context> create(const DplContextInfo& info) {
        DplContext handle = nullptr;
        if (const DplResult r = dplCreateContext(&info, &handle); r != DPL_OK) return lastError(r);
        return Context(handle);
    }
    /** The same, without cacheFolder. */
    static Result<Context> create(DplRenderer renderer = DPL_RENDERER_AUTO, uint32_t threadCount = 0, uint32_t flags = 0,
                                  DplFill fill = DPL_FILL_AUTO) {
        ContextInfo info;
        info.renderer = renderer;
        info.threadCount = threadCount;
        info.flags = flags;
        info.fill = fill;
        return create(info);
    }
    /** None: every call is DPL_ERROR_INVALID_ARGUMENT until a context is moved here. */
    Context() = default;
    /** Takes ownership of `handle`. */
    explicit Context(DplContext handle) : handle_(handle) {}
    Context(Context&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
    Context& operator=(Context&& other) noexcept {
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Context() { dplDestroyContext(handle_); }

    DplContext handle() const { return handle_; }
    /** Empty on failure. */
    std::string rendererName() const {
        const char* name = "";
        return dplGetRendererName(handle_, &name) == DPL_OK ? name : "";
    }
    /** Loads an avatar or general splats; see dplLoadAvatar. The bytes may be freed on return. */
    Result<Avatar> loadAvatar(std::span<const uint8_t> bytes) const {
        DplAvatar avatar = nullptr;
        if (const DplResult r = dplLoadAvatar(handle_, bytes.data(), bytes.size(), &avatar); r != DPL_OK) return lastError(r);
        return Avatar(handle_, avatar);
    }
    /** The same for a file. path: UTF-8. See dplLoadAvatarFile. */
    Result<Avatar> loadAvatarFile(const std::string& path) const {
        DplAvatar avatar = nullptr;
        if (const DplResult r = dplLoadAvatarFile(handle_, path.c_str(), &avatar); r != DPL_OK) return lastError(r);
        return Avatar(handle_, avatar);
    }

    /** Limits what the renderer holds; avatars that would exceed it are loaded with less. 0: no limit. See dplSetMemoryLimit. */
    Status setMemoryLimit(uint64_t bytes) const { return status(dplSetMemoryLimit(handle_, bytes)); }
    /** Starts to load an avatar or general splats in the background; see dplStartLoad. The bytes are kept until they are read. */
    Result<Load> startLoad(std::vector<uint8_t> bytes) const {
        auto kept = std::make_unique<std::vector<uint8_t>>(std::move(bytes));
        DplLoadInfo info{};
        info.structSize = sizeof info, info.data = kept->data(), info.size = kept->size();
        info.release = [](void* user) { delete static_cast<std::vector<uint8_t>*>(user); };
        info.user = kept.get();
        DplLoad load = nullptr;
        if (const DplResult r = dplStartLoad(handle_, &info, &load); r != DPL_OK) return lastError(r);
        kept.release();
        return Load(handle_, load);
    }

    /** Draws several avatars in one picture, which belongs to the first one. One image per view. */
    Status renderTogether(std::span<const DplAvatar> avatars, std::span<const DplCamera> views, std::span<const DplImage> images) const {
        if (views.size() != images.size()) return Error{DPL_ERROR_INVALID_ARGUMENT, "as many images as views are needed"};
        return status(
            dplRenderTogether(handle_, avatars.data(), uint32_t(avatars.size()), views.data(), uint32_t(views.size()), images.data()));
    }
    /** The same, `context.renderTogether({ada, bob}, camera, images)`. */
    Status renderTogether(Avatars avatars, std::span<const DplCamera> views, std::span<const DplImage> images) const {
        if (views.size() != images.size()) return Error{DPL_ERROR_INVALID_ARGUMENT, "as many images as views are needed"};
        const Handles handles(avatars);
        return status(dplRenderTogether(handle_, handles.data(), handles.count(), views.data(), uint32_t(views.size()), images.data()));
    }
    Status drawTogether(Avatars avatars, std::span<const DplCamera> views, uint32_t flags = 0) const {
        const Handles handles(avatars);
        return status(dplDrawTogether(handle_, handles.data(), handles.count(), views.data(), uint32_t(views.size()), flags));
    }
    Status drawTogether(std::span<const DplAvatar> avatars, std::span<const DplCamera> views, uint32_t flags = 0) const {
        return status(dplDrawTogether(handle_, avatars.data(), uint32_t(avatars.size()), views.data(), uint32_t(views.size()), flags));
    }
    /** Sets level of detail and splat budget from the next call on; zeros draw everything. See DplDetail. */
    Status setDetail(float splatsPerPixel, uint32_t splatBudget = 0) const {
        Detail detail;
        detail.splatsPerPixel = splatsPerPixel, detail.splatBudget = splatBudget;
        return status(dplSetDetail(handle_, &detail));
    }
    /** Sets how long a frame may take; 0: no budget. See dplSetFrameBudget. */
    Status setFrameBudget(double milliseconds) const { return status(dplSetFrameBudget(handle_, milliseconds)); }

private:
    DplContext handle_ = nullptr;
};

}  // namespace doppel
#endif
