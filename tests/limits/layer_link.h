// SPDX-License-Identifier: Apache-2.0
// What every Vulkan layer of the tests needs: its place in the loader's chain.
#pragma once

#include <cstring>
#include <initializer_list>

#include <vulkan/vk_layer.h>

namespace dpl::limits {

/** The loader puts the same pointer at the start of an instance, its physical devices, a device, its queues and command buffers. */
template <class Handle>
void* keyOf(Handle handle) {
    return *reinterpret_cast<void**>(handle);
}

/** The loader's link to the next layer or driver, in the list of a create info. */
template <class Link, class Info>
Link* linkIn(const Info& info, VkStructureType type) {
    for (auto* at = static_cast<const VkBaseInStructure*>(info.pNext); at; at = at->pNext)
        if (auto* link = reinterpret_cast<const Link*>(at); at->sType == type && link->function == VK_LAYER_LINK_INFO)
            return const_cast<Link*>(link);
    return nullptr;
}

/** A function of the layer, and what it stands for. */
struct Entry {
    const char* name;
    PFN_vkVoidFunction function;
};

template <class Function>
PFN_vkVoidFunction untyped(Function* function) {
    return reinterpret_cast<PFN_vkVoidFunction>(function);
}

inline PFN_vkVoidFunction find(std::initializer_list<Entry> entries, const char* name) {
    for (const Entry& entry : entries)
        if (std::strcmp(entry.name, name) == 0) return entry.function;
    return nullptr;
}

}  // namespace dpl::limits
