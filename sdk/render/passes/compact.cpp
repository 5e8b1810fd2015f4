// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/passes/compact.h"

#include <algorithm>

namespace dpl {

void addCompact(FramePlan& plan, const FrameIds& ids) {
    const uint32_t drawn = uint32_t(ids.endGroups.size());
    gpu::CompactPush push{ids.allGroups, ids.maxDepthKey(), drawn, {}};
    std::copy(ids.endGroups.begin(), ids.endGroups.end(), push.endGroup);
    plan.compute("compact.masks", "compact.masks")
        .reads(ids.visibility)
        .writes(ids.survivors)
        .push(gpu::MaskPush{ids.allGroups})
        .threads(ids.allGroups);
    plan.compute("compact.scan", "scan.sums").updates(ids.survivors).push(gpu::ScanPush{ids.firstSum(), ids.allGroups}).groups(1);
    plan.compute("compact.args", "compact.args")
        .reads(ids.survivors)
        .updates(ids.counts)
        .push(gpu::ArgsPush{ids.allGroups, ids.maxDepthKey(), drawn, ids.drawInstances})
        .groups(1);
    plan.compute("compact.scatter", "compact.scatter")
        .reads(ids.visibility, ids.survivors, ids.counts)
        .writes(ids.unsorted())
        .push(push)
        .threads(ids.allGroups * gpu::kMaskWords);
}

}  // namespace dpl
