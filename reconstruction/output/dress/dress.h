// SPDX-License-Identifier: Apache-2.0
// Puts garments of other avatars on an avatar (docs/reference/dress.md).
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "sdk/core/jobs.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Names of layers that can change, from the innermost to the outermost: where two meet, the later one goes over the earlier one. They are
 *  the label names of docs/formats/scan.md. */
inline constexpr std::array<const char*, 4> kDressLayers{"shoes", "bottom", "top", "hair"};

struct NamedAvatar {
    std::string file;  // for messages
    AvatarData avatar;
};

struct Garment {
    std::string layer;                  // one of kDressLayers; not empty, no two garments with the same
    const NamedAvatar* from = nullptr;  // not null; outlives the call
};

struct DressedLayer {
    std::string layer;
    std::string file, avatar;  // where it comes from, and the name of that avatar
    bool replaced = false;     // false: the wearer had no such layer
    uint32_t triangles = 0;
    uint32_t splats = 0;
    float meanMoveM = 0;      // of a vertex, from the old to the new body
    uint32_t insideBody = 0;  // vertices inside the body that could not be pushed out
};

struct Dressed {
    AvatarData avatar;  // as a file's reader would decode it
    std::vector<DressedLayer> layers;
    uint32_t filledSkinTriangles = 0, clearedSkinTriangles = 0;
    bool noSkin = false;  // the wearer shows no skin from which uncovered skin could take its colour; it stays empty
};

/** Replaces layers of `wearer`. The wearer keeps rig, body, clips and pose correctives; the name says who wears whose
 * garments. Refuses avatars whose rig or body mesh
 * differs from the wearer's, and files without the layer (InvalidArgument, naming the file and what to do). Cancelled. The result does not
 * depend on the number of threads. */
Result<Dressed> dressAvatar(const NamedAvatar& wearer, std::span<const Garment> garments, Jobs& jobs);

/** A garment file on the command line: layer name and path. */
struct GarmentFile {
    std::string layer;
    std::filesystem::path path;
};

struct DressedFile {
    std::vector<uint8_t> bytes;
    Dressed dressed;
};

/** The same for files. A wearer that is entropy-coded (splat encoding 3) stays so. Errors name the file. */
Result<DressedFile> dressFiles(const std::filesystem::path& wearer, std::span<const GarmentFile> garments, Jobs& jobs);

}  // namespace dpl
