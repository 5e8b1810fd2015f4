// SPDX-License-Identifier: Apache-2.0
// Making an avatar smaller along its measured rate-distortion curve: which of its parts to thin next is decided by pictures.
//
//   splats (the least visible go first) ─┐
//   SH (own rows → palettes → a lower degree → none) ─┤
//   correctives (the weakest modes go first) ─────────┼─► the move that saves most bytes for its error ─► again, until the limits are met
//   bits (of places, angles, sizes, opacity, colour) ─┘
//
// Words are entropy-coded first (splat encoding 3): that costs no error.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sdk/core/jobs.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/coded_splats.h"

namespace dpl {

struct PackLimits {
    std::optional<uint64_t> maxBytes;  // of the file
    std::optional<double> minPsnrDb;   // of the pictures against the unpacked avatar's, covered pixels
};

/** A point of the curve. */
struct PackPoint {
    std::string move;                                             // what changed since the point before
    uint64_t bytes = 0;                                           // of the whole file
    double psnrDb = 0, wholePsnrDb = 0;                           // infinite at the start
    uint32_t splats = 0, shDegree = 0, shEntries = 0, modes = 0;  // shEntries 0: every splat has its own SH
    SplatBits bits;                                               // of the splats' fields
    bool compact = false;                                         // splat encoding 3
};

struct PackResult {
    std::vector<PackPoint> curve;  // as it was walked; the last point is what `file` holds
    std::vector<uint8_t> file;
};

struct PackSettings {
    uint64_t seed = 1;  // of views and poses
    uint32_t pictures = 16;
    bool compact = false;  // the avatar came in splat encoding 3: packFile looks
};

/** Walks until the file is as small as maxBytes allows, or, without it, until nothing more fits minPsnrDb. At least one limit must be set.
 *  InvalidArgument: the limits cannot be met; the sentence says what is the nearest. Cancelled: progress said so.
 *  progress(share, line) is called before each candidate and ends the walk by returning an error. */
Result<PackResult> packToLimits(const AvatarData& avatar, const PackLimits& limits, const PackSettings& settings, Jobs& jobs,
                                const std::function<Status(double, const std::string&)>& progress);

/** The same for a file; errors name it. */
Result<PackResult> packFile(const std::filesystem::path& avatar, const PackLimits& limits, const PackSettings& settings, Jobs& jobs,
                            const std::function<Status(double, const std::string&)>& progress);

/** The curve as a table for people. */
std::string curveAsText(const std::vector<PackPoint>& curve);

}  // namespace dpl
