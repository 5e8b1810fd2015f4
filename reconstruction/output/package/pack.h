// SPDX-License-Identifier: Apache-2.0
// Makes an avatar smaller along its measured rate-distortion curve. Each step tries the next move on every ladder, measures bytes and
// picture error of each, and takes the one that saves most bytes for its error, until the limits are met. The ladders:
//
//   splats        drop the least visible
//   SH            rows per splat → palettes → a lower degree → none
//   correctives   drop the weakest modes
//   bits          fewer for positions, angles, sizes, opacity or colour
//
// The very first step entropy-codes the splats (splat encoding 3), which adds no error.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sdk/core/jobs.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/coded_splats.h"

namespace dpl {

struct PackLimits {
    std::optional<uint64_t> maxBytes;  // file size
    std::optional<double> minPsnrDb;   // covered pixels, against pictures of the unpacked avatar
};

/** A point of the curve. */
struct PackPoint {
    std::string move;                                             // change since the previous point
    uint64_t bytes = 0;                                           // file size
    double psnrDb = 0, wholePsnrDb = 0;                           // over covered and all pixels; infinite for equal pictures
    uint32_t splats = 0, shDegree = 0, shEntries = 0, modes = 0;  // shEntries 0: no palette, every splat has its own SH
    SplatBits bits;                                               // per field of a splat
    bool compact = false;                                         // uses splat encoding 3
};

struct PackResult {
    std::vector<PackPoint> curve;  // in the order of the steps; the last point describes `file`
    std::vector<uint8_t> file;
};

struct PackSettings {
    uint64_t seed = 1;  // of views and poses
    uint32_t pictures = 16;
    bool compact = false;  // the avatar was read from splat encoding 3; packFile sets this
};

/** Steps until the file has at most maxBytes or, without maxBytes, until every further step would fall below minPsnrDb. Set at least one
 *  limit. Same input and seed, same bytes. InvalidArgument: the limits cannot be met; the message states the nearest result.
 *  Tells the task of this thread what it tries before each candidate. Cancelled. */
Result<PackResult> packToLimits(const AvatarData& avatar, const PackLimits& limits, const PackSettings& settings, Jobs& jobs);

/** The same for a file. Errors from reading name it. */
Result<PackResult> packFile(const std::filesystem::path& avatar, const PackLimits& limits, const PackSettings& settings, Jobs& jobs);

/** The curve as a Markdown table. */
std::string curveAsText(const std::vector<PackPoint>& curve);

}  // namespace dpl
