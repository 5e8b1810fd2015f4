// SPDX-License-Identifier: Apache-2.0
// Work-arounds for single drivers, with reasons. Every work-around is a row of vk_quirks.cpp and nowhere else.
#pragma once

#include <span>

#include "sdk/backend/backend.h"

namespace dpl::vk {

struct Quirk {
    const char* device;  // part of the name that the driver gives its device
    void (*apply)(DeviceInfo& info);
    const char* what;    // is done instead
    const char* reason;  // and in which version of the driver it was seen
    const char* date;    // when it was seen
};

std::span<const Quirk> quirks();

/** Applies the rows that match info.name, and logs each one the first time that it does. */
void applyQuirks(DeviceInfo& info);

}  // namespace dpl::vk
