// SPDX-License-Identifier: Apache-2.0
// The subject's movement in a scan as a clip.
#pragma once

#include <span>
#include <vector>

#include "reconstruction/input/capture/scan.h"
#include "sdk/avatar/rig.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** The moving frames among `frames` (indices into Scan::frames) in the order of their times, so that an avatar can be played without
 * another file. poses: of `frames`. Joints that stay at rest have no channel. At most one clip; none with fewer than two moments. */
std::vector<ClipData> scanMotion(const Scan& scan, std::span<const size_t> frames, std::span<const Pose> poses);

}  // namespace dpl
