// SPDX-License-Identifier: Apache-2.0
// The avatar file: AvatarData <-> one glTF 2.0 binary (docs/formats/avatar.md). The first encoding loses precision, further ones do not:
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

constexpr uint32_t kAvatarFormatVersion = 3;    // newest version; the writer takes the lowest that holds the avatar
constexpr float kPositionStepM = 1.0f / 65536;  // vertices, joints and root translations are multiples of this: error ≤ 7.7 µm per axis
constexpr float kPositionLimitM = 32;           // larger coordinates are refused: Draco is exact up to 22 bits

struct WriteOptions {
    bool draco = true;       // false: plain accessors for viewers without Draco; decodes to the same AvatarData
    bool shPalette = false;  // stores equal SH rows once (splat encoding 2); InvalidArgument above 65,536 different rows
    /** Entropy-codes the splats (splat encoding 3) if that is smaller. Loads to the same words, about 0.1 µs per splat slower. */
    bool compact = false;
    SplatBits bits = {};  // splat codes are rounded to these numbers of bits first
};

/** Encodes an avatar. Requirements: layers tile the vertex and triangle arrays in order; joint 0 is the only root; parents come before
 *  children; weights sum to 255; all numbers are finite; splats are in the order of `triangleStart` (sortSplats). Deterministic: the same
 *  input gives the same bytes. InvalidArgument names the array and index. Peak memory about 3 × the avatar. Any thread. */
Result<std::vector<uint8_t>> writeAvatar(const AvatarData& avatar, const WriteOptions& options = {});

/** Decodes an avatar; the bytes may be freed on return. Checks sizes before it allocates: peak memory is at most 64 MiB + 64 × the file +
 *  1024 × its Draco bytes. Any thread; throws nothing.
 *  CorruptData: damaged or hostile bytes. Version: written by a newer Doppel. Unsupported: a glTF without the extension of avatars. */
Result<AvatarData> readAvatar(std::span<const uint8_t> bytes, const ReadLimits& limits = {});

/** An avatar with splats in coded form, as renderers keep them. avatar.splats is empty. */
struct CodedAvatar {
    AvatarData avatar;
    CodedSplats splats;
};

/** readAvatar without decoding the splats. Makes the same checks; peak memory is little more than the result. */
Result<CodedAvatar> readCodedAvatar(std::span<const uint8_t> bytes, const ReadLimits& limits = {});

/** A layer as inspectAvatar() reports it. */
struct LayerInfo {
    std::string name, role;
    uint32_t triangles = 0, splats = 0;
};

struct ClipInfo {
    std::string name;
    double durationS = 0;
};

/** Content of a file and the bytes of its parts, which add up to fileBytes. */
struct AvatarInfo {
    std::string name, generator;
    uint32_t version = 0;
    std::string contentHash;  // "xxh3:" and 16 hex digits
    bool hashMatches = false;
    uint32_t vertices = 0, triangles = 0, joints = 0, layers = 0, splats = 0, chunks = 0, clips = 0, shDegree = 0;
    uint32_t correctiveModes = 0, motionModes = 0, correctiveNodes = 0, expressions = 0;
    bool light = false;          // of the scene
    float trainedPixelM = 0;     // as in AvatarData
    uint32_t shPaletteSize = 0;  // 0: every splat has its own SH
    uint32_t splatEncoding = 0;
    SplatBits bits;  // of the fields of splats; fewer than the maximum only in encoding 3
    uint64_t fileBytes = 0;
    uint64_t meshBytes = 0;        // Draco views, or plain vertex and index views
    uint64_t splatBytes = 0;       // triangle counts, chunk table, three words per splat; in encoding 3 also palette indices
    uint64_t shBytes = 0;          // SH beyond coefficient 0: of every splat, or palette and indices
    uint64_t correctiveBytes = 0;  // pose correctives
    uint64_t expressionBytes = 0;
    uint64_t captureMapBytes = 0;
    uint64_t clipBytes = 0;   // animation samplers
    uint64_t skinBytes = 0;   // inverse bind matrices
    uint64_t jsonBytes = 0;   // the JSON chunk
    uint64_t otherBytes = 0;  // GLB headers, padding
    std::vector<LayerInfo> layerList;
    std::vector<ClipInfo> clipList;
    std::vector<std::string> jointNames;
    std::vector<EvidenceData> evidence;
};

/** Reads and checks the whole file like readAvatar, but reports a wrong content hash in hashMatches instead of failing. */
Result<AvatarInfo> inspectAvatar(std::span<const uint8_t> bytes, const ReadLimits& limits = {});

/** readAvatar(writeAvatar(avatar)): the avatar with the precision of the file. */
Result<AvatarData> decodedAvatar(const AvatarData& avatar);

/** Puts splats into file order: by triangle, then by Morton code of their packed (u, v), then in input order. Returns order[new] = old,
 *  with which callers reorder their own arrays. triangleStart must be valid. */
std::vector<uint32_t> sortSplats(AvatarData& avatar);
/** The same for splats in any order. triangleOfSplat: one triangle per splat. Rebuilds triangleStart.
 *  InvalidArgument: a triangle out of range or arrays of different length. */
Result<std::vector<uint32_t>> sortSplats(AvatarData& avatar, std::span<const uint32_t> triangleOfSplat);

/** Changes φ, s1, s2 of every splat so that its posed covariance stays the same on the rest mesh of `avatar` (docs/reference/binding.md).
 *  oldRestPositions: V vertices of the mesh that the splats were bound to, with the same triangles; u and v do not change. Splats of a
 *  triangle that is degenerate in either mesh keep their values; returns their number. All others then have s1 ≥ s2 and φ ∈ [0, π). */
Result<uint32_t> rebaseSplats(std::span<const Vec3f> oldRestPositions, AvatarData& avatar);

}  // namespace dpl
