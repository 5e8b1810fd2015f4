// SPDX-License-Identifier: Apache-2.0
// An avatar, or general splats, as the GPU reads them: static records, checked against the device before any upload.
#pragma once

#include <span>
#include <vector>

#include "sdk/backend/backend.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/coded_splats.h"
#include "sdk/format/splat_detail.h"
#include "sdk/math/detail.h"
#include "sdk/math/placement.h"
#include "sdk/visibility/components.h"
#include "shaders/shared/frame.h"

namespace dpl {

struct AvatarRecords {
    std::vector<gpu::VertexRecord> vertices;
    std::vector<gpu::CorrectedVertexRecord> correctedVertices;  // instead of `vertices` when the avatar has pose correctives
    std::vector<gpu::TriangleRecord> triangles;
    std::vector<uint32_t> codes;  // all streams of the splats, one after the other
    gpu::CodesPush where{};       // where each stream begins in `codes`
    Components components;        // with the numbers that the records use
};

/** Calls checkAvatarPosable and checks the limits of the device's bindings. Unsupported: above a limit; the text names the limit and a
 *  remedy. avatar.splats is not read. */
Status checkAvatar(const AvatarData& avatar, const CodedSplats& splats, const DeviceInfo& device);

/** Both must have passed checkAvatar. Level of detail needs splats with groups (measureGroups). */
AvatarRecords packAvatar(const AvatarData& avatar, const CodedSplats& splats);

/** Whether the splats reach beyond 8 m, where steps of a 16-bit depth key become coarser than the 0.12 mm of a person with both arms
 *  out. */
bool reachFar(const StaticSplatData& splats);

/** Calls checkGeneralSplats and checks the limits of the device's bindings. */
Status checkSplats(const StaticSplatData& splats, const DeviceInfo& device);
// If the task of the thread is cancelled (sdk/core/task.h), these two stop early.
/** A GeneralSplatRecord for each splat, then a GroupBox for each group (measureGroups). order[new] = old. */
std::vector<gpu::uvec4> packSplats(const StaticSplatData& splats, std::span<const uint32_t> order, std::span<const GeneralGroup> groups);
/** The SH coefficients as halves, padded to whole uvec4s for each splat. Values beyond the range of a half are clamped to it. */
std::vector<gpu::uvec4> packSh(const StaticSplatData& splats, std::span<const uint32_t> order);

/** The palette of a pose: three rows a joint, then the control nodes, then the coefficients of the light. `out` has paletteSize entries; it
 *  may be mapped memory. */
size_t paletteSize(const AvatarData& avatar);
/** Where the coefficients of the light stand in it; 0 without light. */
uint32_t firstLightRow(const AvatarData& avatar);
void packPalette(std::span<const Mat3x4f> worldFromRest, std::span<const Vec4f> nodes, const LightData& light, std::span<gpu::vec4> out);

/** Properties of a splat set that a frame needs. */
struct SplatSet {
    uint32_t count = 0, shDegree = 0;
    float kappaPx2 = 0;  // low-pass, px² of the target
    bool compensated = false;
};
SplatSet splatSetOf(const AvatarData& avatar, const CodedSplats& splats);
SplatSet splatSetOf(const StaticSplatData& splats);

/** The uniform block of one subject. views: of the world; placement: where the subject stands in it. samples: coverage samples of a pixel;
 * each gets its share of the low-pass. largestGrowth: upper bound of the factor by which level of detail enlarges splats. unseen: bits of
 * the components that are not posed. Switches culling on and sets splatCount to the subject's own count; a caller may overwrite both
 * fields. */
gpu::FrameData packFrame(const SplatSet& splats, std::span<const Cameraf> views, uint32_t samples = 1, const SplatDetail& detail = {},
                         float largestGrowth = 1, uint32_t unseen = 0, const Placement& placement = {});
/** Sets the fields that only general splats use. */
void packGeneralDetail(const GeneralDetail& detail, gpu::FrameData& frame);

}  // namespace dpl
