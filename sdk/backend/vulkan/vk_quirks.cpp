// SPDX-License-Identifier: Apache-2.0
#include "sdk/backend/vulkan/vk_quirks.h"

#include <atomic>
#include <iterator>

#include "sdk/core/log.h"

namespace dpl::vk {
namespace {

constexpr Quirk kQuirks[] = {
    {"llvmpipe", [](DeviceInfo& info) { info.multiview = false; }, "each view is a draw of its own",
     "Mesa 22.3.6 puts the first 16 instances of an indirect multiview draw into layer 0 for both views", "2026-11-21"},
    {"llvmpipe", [](DeviceInfo& info) { info.texels = info.typedFormats; }, "kernels read typed buffers",
     "Mesa 22.3.6 overruns a heap block when a vertex shader reads plain buffers: malloc aborts after a draw of 113,400 vertices; typed "
     "buffers also take 0.5 of the CPU time of a tile frame there, and 0.9 on Mesa 25.0.7",
     "2026-11-23"},
};

}  // namespace

std::span<const Quirk> quirks() {
    return kQuirks;
}

void applyQuirks(DeviceInfo& info) {
    static std::atomic<bool> logged[std::size(kQuirks)];
    for (size_t i = 0; i < std::size(kQuirks); ++i) {
        const Quirk& quirk = kQuirks[i];
        if (info.name.find(quirk.device) == std::string::npos) continue;
        quirk.apply(info);
        if (!logged[i].exchange(true)) log(LogLevel::Info, "{}: {} ({}, {})", info.name, quirk.what, quirk.reason, quirk.date);
    }
}

}  // namespace dpl::vk
