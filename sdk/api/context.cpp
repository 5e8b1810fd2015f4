// SPDX-License-Identifier: Apache-2.0
// Contexts, versions, errors and the log.
#include <algorithm>
#include <atomic>
#include <string>

#include "sdk/api/api_state.h"
#include "sdk/api/create_renderer.h"
#include "sdk/api/load.h"
#include "sdk/core/log.h"

namespace dpl::api {

HandleTable<Context>& contexts() {
    static auto* table = new HandleTable<Context>(0x1001);  // never freed: threads may still call the API at process exit
    return *table;
}

HandleTable<Avatar>& avatars() {
    static auto* table = new HandleTable<Avatar>(0x1002);
    return *table;
}

Context::Context() = default;
Context::~Context() = default;  // here, where a Loader is a complete type

Result<std::shared_ptr<Context>> contextOf(DplContext handle) {
    auto context = contexts().find(reinterpret_cast<uintptr_t>(handle));
    if (!context) return fail(Code::InvalidArgument, "{} is not a live context", handle ? "the handle" : "0");
    return context;
}

Status checkUsable(const Context& context) {
    if (!context.renderer) return fail(Code::InvalidArgument, "the context was destroyed");
    if (context.renderer->lost())
        return fail(Code::Device,
                    "the graphics device was lost; dplRebuildVulkan (or dplRebuildMetal) keeps the avatars and makes the rest anew");
    return {};
}

namespace {

thread_local std::string lastError;
std::atomic<bool> listened = false;  // a callback receives the log

DplResult publicCode(Code code) {
    switch (code) {
        case Code::InvalidArgument:
            return DPL_ERROR_INVALID_ARGUMENT;
        case Code::NotFound:
            return DPL_ERROR_NOT_FOUND;
        case Code::CorruptData:
            return DPL_ERROR_CORRUPT_DATA;
        case Code::Version:
            return DPL_ERROR_VERSION;
        case Code::Unsupported:
            return DPL_ERROR_UNSUPPORTED;
        case Code::OutOfMemory:
            return DPL_ERROR_OUT_OF_MEMORY;
        case Code::Io:
            return DPL_ERROR_IO;
        case Code::Device:
            return DPL_ERROR_DEVICE;
        case Code::Cancelled:
        case Code::Internal:
            break;
    }
    return DPL_ERROR_INTERNAL;
}

}  // namespace

DplResult report(const char* function, const Error& error) noexcept {
    try {
        std::string text = error.message;
        if (text.empty()) text = error.code == Code::OutOfMemory ? "out of memory" : "something went wrong inside the library";
        lastError = std::string(function) + ": " + text;
        // Only to a callback: the call returns it, and stderr belongs to the program.
        if (error.code == Code::InvalidArgument && listened) logText(LogLevel::Warning, lastError);
    } catch (...) {
        lastError.clear();  // out of memory
    }
    return publicCode(error.code);
}

}  // namespace dpl::api

using namespace dpl;
using namespace dpl::api;

extern "C" {

uint32_t dplGetVersion(void) {
    return DPL_VERSION_MAJOR << 16 | DPL_VERSION_MINOR << 8 | DPL_VERSION_PATCH;
}

const char* dplGetLastError(void) {
    return lastError.c_str();
}

const char* dplGetResultName(DplResult result) {
    switch (int(result)) {
        case DPL_OK:
            return "DPL_OK";
        case DPL_ERROR_INVALID_ARGUMENT:
            return "DPL_ERROR_INVALID_ARGUMENT";
        case DPL_ERROR_NOT_FOUND:
            return "DPL_ERROR_NOT_FOUND";
        case DPL_ERROR_CORRUPT_DATA:
            return "DPL_ERROR_CORRUPT_DATA";
        case DPL_ERROR_VERSION:
            return "DPL_ERROR_VERSION";
        case DPL_ERROR_UNSUPPORTED:
            return "DPL_ERROR_UNSUPPORTED";
        case DPL_ERROR_OUT_OF_MEMORY:
            return "DPL_ERROR_OUT_OF_MEMORY";
        case DPL_ERROR_IO:
            return "DPL_ERROR_IO";
        case DPL_ERROR_DEVICE:
            return "DPL_ERROR_DEVICE";
        case DPL_ERROR_INTERNAL:
            return "DPL_ERROR_INTERNAL";
        default:
            return "unknown result";
    }
}

DplResult dplSetLogCallback(DplLogCallback callback, void* user) {
    return guarded("dplSetLogCallback", [&]() -> Status {
        listened = callback != nullptr;
        if (callback == nullptr) {
            setLogSink({});
            return {};
        }
        setLogSink([callback, user](LogLevel level, std::string_view text) {
            callback(user, DplLogLevel(int(level)), std::string(text).c_str());
        });
        return {};
    });
}

DplResult dplCreateContext(const DplContextInfo* info, DplContext* context) {
    return guarded("dplCreateContext", [&]() -> Status {
        if (context == nullptr) return fail(Code::InvalidArgument, "context is NULL");
        auto made = std::make_shared<Context>();
        DPL_TRY(made->request, readContextInfo(info));
        DPL_TRY(made->renderer, createRenderer(made->request.kind, made->request.options));
        made->rendererName = made->renderer->name();
        *context = reinterpret_cast<DplContext>(contexts().add(std::move(made)));
        return {};
    });
}

DplResult dplDestroyContext(DplContext context) {
    return guarded("dplDestroyContext", [&]() -> Status {
        if (context == nullptr) return {};
        const auto taken = contexts().take(reinterpret_cast<uintptr_t>(context));
        if (!taken) return fail(Code::InvalidArgument, "the handle is not a live context; was it destroyed before?");
        std::unique_ptr<Loader> loader;
        {
            const std::lock_guard lock(taken->mutex);
            taken->closing = true;
            loader = std::move(taken->loader);
        }
        loader.reset();  // cancels its loads and waits for its thread
        std::unique_lock loads(taken->loads, std::defer_lock);
        if (taken->lent) loads.lock();       // a load must not be the last to hold the renderer: the program destroys the device next
        std::lock_guard lock(taken->mutex);  // waits for a draw on another thread
        taken->renderer.reset();
        return {};
    });
}

DplResult dplGetRendererName(DplContext context, const char** name) {
    return guarded("dplGetRendererName", [&]() -> Status {
        if (name == nullptr) return fail(Code::InvalidArgument, "name is NULL");
        DPL_TRY(const auto found, contextOf(context));
        *name = found->rendererName.c_str();
        return {};
    });
}

}  // extern "C"
