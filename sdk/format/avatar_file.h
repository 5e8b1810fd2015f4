// SPDX-License-Identifier: Apache-2.0
// The avatar file: AvatarData <-> one glTF 2.0 binary (docs/formats/avatar.md). Encoding is lossy once and then idempotent:
// writeAvatar(readAvatar(writeAvatar(x))) gives the same bytes as writeAvatar(x).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/coded_splats.h"
#include "sdk/format/read_limits.h"

namespace dpl {

constexpr uint32_t kAvatarFormatVersion = 2;    // newest; files without pose correctives are written as version 1
constexpr float kPositionStepM = 1.0f / 65536;  // lattice of vertices, joints and root translations: error ≤ 7.7 µm an axis
constexpr float kPositionLimitM = 32;           // coordinates beyond this are refused: Draco rounds exactly up to 22 bits

struct WriteOptions {
    bool draco = true;       // false: plain accessors, for validators and viewers without Draco; decodes to the same AvatarData
    bool shPalette = false;  // rows of SH that repeat are written once (splat encoding 2); InvalidArgument above 65,536 different ones
    bool compact =
        false;  // splats entropy-coded (splat encoding 3) where that is smaller; loads to the same words, some 0.1 µs a splat slower
    SplatBits bits = {};  // codes are rounded to so many first
};

/** Encodes an avatar. Layers must tile the vertex and triangle arrays in order, joint 0 must be the only root, parents first,
 *  weights must sum to 255, all numbers finite; splats must follow `triangleStart` (sortSplats). Deterministic: same input, same bytes.
 *  InvalidArgument: the sentence names the array and index. Peak memory about 3 × the avatar. Any thread. */
Result<std::vector<uint8_t>> writeAvatar(const AvatarData& avatar, const WriteOptions& options = {});

/** Decodes an avatar; the bytes may be freed on return. Sizes are checked before anything is allocated: peak memory is at most
 *  64 MiB + 64 × the file + 1024 × its Draco bytes. Any thread, no exception escapes.
 *  CorruptData: damaged or hostile bytes. Version: written by a newer Doppel. Unsupported: a glTF without our extension. */
Result<AvatarData> readAvatar(std::span<const uint8_t> bytes, const ReadLimits& limits = {});

/** An avatar whose splats stay as they lie in the file: what a renderer keeps. avatar.splats is empty. */
struct CodedAvatar {
    AvatarData avatar;
    CodedSplats splats;
};

/** readAvatar without decoding the splats: as strict, and peak memory is little more than what it returns. */
Result<CodedAvatar> readCodedAvatar(std::span<const uint8_t> bytes, const ReadLimits& limits = {});

/** What is in a file, bytes by part. The parts add up to fileBytes. */
struct AvatarInfo {
    std::string name, generator;
    uint32_t version = 0;
    std::string contentHash;  // "xxh3:" and 16 hex digits
    bool hashMatches = false;
    uint32_t vertices = 0, triangles = 0, joints = 0, layers = 0, splats = 0, chunks = 0, clips = 0, shDegree = 0;
    uint32_t correctiveModes = 0, correctiveNodes = 0;
    float trainedPixelM = 0;     // AvatarData's
    uint32_t shPaletteSize = 0;  // 0: every splat has its own SH
    uint32_t splatEncoding = 0;
    SplatBits bits;  // of the splats' fields; less than all only in encoding 3
    uint64_t fileBytes = 0;
    uint64_t meshBytes = 0;        // Draco views, or plain vertex and index views
    uint64_t splatBytes = 0;       // triangle counts, chunk table, three words a splat; encoding 3: palette indices too
    uint64_t shBytes = 0;          // beyond coefficient 0: of every splat, or palette and indices
    uint64_t correctiveBytes = 0;  // pose correctives
    uint64_t clipBytes = 0;        // animation samplers
    uint64_t skinBytes = 0;        // inverse bind matrices
    uint64_t jsonBytes = 0;        // the JSON chunk
    uint64_t otherBytes = 0;       // GLB headers, padding
    std::vector<EvidenceData> evidence;
};

/** Reads and checks the whole file like readAvatar, but a wrong content hash is reported, not an error. */
Result<AvatarInfo> inspectAvatar(std::span<const uint8_t> bytes, const ReadLimits& limits = {});

/** readAvatar(writeAvatar(avatar)): the avatar as every reader will see it. */
Result<AvatarData> decodedAvatar(const AvatarData& avatar);

/** Puts splats into file order: by triangle, then by Morton code of their packed (u, v), ties in input order. Returns order[new] = old,
 *  so that a caller can carry its own per-splat arrays along. triangleStart must be valid. */
std::vector<uint32_t> sortSplats(AvatarData& avatar);
/** The same for splats in any order: triangleOfSplat has one entry a splat; triangleStart is rebuilt.
 *  InvalidArgument: a triangle out of range or arrays of different length. */
Result<std::vector<uint32_t>> sortSplats(AvatarData& avatar, std::span<const uint32_t> triangleOfSplat);

/** Re-expresses φ, s1, s2 of every splat on the rest mesh of `avatar` so that its posed covariance is unchanged
 * (docs/reference/binding.md). oldRestPositions: V positions of the mesh that the splats were bound to; same triangles, same u, v. Splats
 * of a triangle that is degenerate in either mesh keep their values. Afterwards s1 ≥ s2 and φ ∈ [0, π). Returns the number of splats left
 * as they were.
 */
Result<uint32_t> rebaseSplats(std::span<const Vec3f> oldRestPositions, AvatarData& avatar);

}  // namespace dpl
