// SPDX-License-Identifier: Apache-2.0
// Tells what a dropped file is for.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace dpl {

enum class FileKind : uint8_t {
    Subject,  // an avatar or general splats, for dplLoadAvatar
    Motion,   // for dplLoadClip
    Unknown,
};

/** Judges by the content; for text that begins like nothing known, by the ending .bvh or .gltf of the name. The bytes may be damaged: the
 *  loader that the kind names says so. Reads at most the first 64 MiB. */
FileKind fileKindOf(std::span<const uint8_t> bytes, std::string_view name);

}  // namespace dpl
