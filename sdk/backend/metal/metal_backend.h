// SPDX-License-Identifier: Apache-2.0
// Metal behind backend.h. No Metal type leaves this folder.
#pragma once

#include <memory>

#include "sdk/backend/backend.h"

namespace dpl {

/** On the system's default device. Unsupported: there is none, or it is older than MTLGPUFamilyApple4 and MTLGPUFamilyMac2. */
Result<std::unique_ptr<Backend>> createMetalBackend();

}  // namespace dpl
