// SPDX-License-Identifier: Apache-2.0
// Work-arounds for single drivers, with reasons. Each one is a row of the table in vk_quirks.cpp.
#pragma once

#include <span>

#include "sdk/backend/backend.h"

namespace dpl::vk {

struct Quirk {
    const char* device;  // part of the name that the driver gives its device
    void (*apply)(DeviceInfo& info);
    const char* what;    // what Doppel does instead
    const char* reason;  // the fault, with the driver's version
    const char* date;    // when the fault was seen
};

std::span<const Quirk> quirks();

/** Applies the rows that match info.name. Logs each row once in a process. Any thread. */
void applyQuirks(DeviceInfo& info);

}  // namespace dpl::vk
