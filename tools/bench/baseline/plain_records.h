// SPDX-License-Identifier: Apache-2.0
// Packs an avatar or general splats into the static float records that the plain frame reads, and checks them against the device before any
// upload. Frozen.
#pragma once

#include <span>
#include <vector>

#include "sdk/backend/backend.h"
#include "sdk/format/avatar_data.h"
#include "tools/bench/baseline/shaders/shared/frame.h"

namespace dpl::plain {

struct Records {
    std::vector<VertexRecord> vertices;
    std::vector<CorrectedVertexRecord> correctedVertices;  // instead of `vertices` when the avatar has pose correctives
    std::vector<TriangleRecord> triangles;
    std::vector<SplatRecord> splats;
};

/** Returns Unsupported if the records do not fit a binding of the device. The avatar must be valid, as readAvatar returns it. */
Status checkFits(const AvatarData& avatar, const DeviceInfo& device);
Status checkFits(const StaticSplatData& splats, const DeviceInfo& device);

Records pack(const AvatarData& avatar);
std::vector<GeneralSplatRecord> pack(const StaticSplatData& splats);

/** The palette of a pose: three rows per joint, then the control nodes. `out` has paletteRows entries and may be mapped memory. */
size_t paletteRows(const AvatarData& avatar);
void packPalette(std::span<const Mat3x4f> worldFromRest, std::span<const Vec4f> nodes, std::span<vec4> out);

/** Properties of the splats that a frame draws. */
struct SplatSet {
    uint32_t count = 0, shDegree = 0;
    float kappaPx2 = 0;
    bool compensated = false;
};

/** The data that a frame of one view uploads. */
FrameData packFrame(const SplatSet& splats, const Cameraf& view);

}  // namespace dpl::plain
