// SPDX-License-Identifier: Apache-2.0
// Tells by the first bytes whether a file can hold an avatar or general splats, before the rest is read.
#pragma once

#include <cstdint>
#include <span>

#include "sdk/core/result.h"

namespace dpl {

/** A CheckFileHead (sdk/core/files.h). Unsupported: neither an avatar nor general splats. CorruptData: empty, or a .glb whose header states
 *  another size. */
Status checkAvatarHead(std::span<const uint8_t> head, uint64_t fileBytes);

}  // namespace dpl
