#include "sdk/render/passes/compact.h"

namespace dpl {

void addCompact(FramePlan& plan, const FrameIds& ids) {
    plan.compute("compact.scan", "scan.sums").updates(ids.visibility).push(gpu::ScanPush{ids.firstSum(), ids.groupCount}).groups(1);
    plan.compute("compact.args", "compact.args")
        .reads(ids.visibility)
        .updates(ids.counts)
        .push(gpu::ArgsPush{ids.groupCount, ids.layered ? 1 : ids.viewCount})
        .groups(1);
    plan.compute("compact.scatter", "compact.scatter")
        .reads(ids.visibility, ids.counts)
        .writes(ids.unsorted())
        .push(gpu::CompactPush{ids.groupCount, ids.maxDepthKey()})
        .threads(ids.groupCount * gpu::kMaskWords);
}

}  // namespace dpl
