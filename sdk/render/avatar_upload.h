// An avatar as the GPU reads it: static records packed from AvatarData, checked against the device before any upload.
#pragma once

#include <vector>

#include "sdk/backend/backend.h"
#include "sdk/format/avatar_data.h"
#include "shaders/shared/frame.h"

namespace dpl {

struct AvatarRecords {
    std::vector<gpu::VertexRecord> vertices;
    std::vector<gpu::TriangleRecord> triangles;
    std::vector<gpu::SplatRecord> splats;
};

/** Refuses arrays of different lengths, indices out of range, and avatars above a limit of the device (binding size,
 *  2²⁴ triangles); the text says which limit and what would help. */
Status checkAvatar(const AvatarData& avatar, const DeviceInfo& device);

/** The avatar must have passed checkAvatar. */
AvatarRecords packAvatar(const AvatarData& avatar);

/** What one frame takes from the CPU: the block itself, and the sort axis inside it (mean forward axis of the views). */
gpu::FrameData packFrame(const AvatarData& avatar, std::span<const Cameraf> views);

}  // namespace dpl
