#include "sdk/render/passes/compact.h"

namespace dpl {

void addCompact(FramePlan& plan, const FrameIds& ids) {
    const uint32_t blocks = ids.compactBlocks();
    const gpu::CompactPush push{ids.splatCount, blocks, ids.firstDepth(), ids.maxDepthKey()};
    plan.compute("compact.count", "compact.count").reads(ids.visibility).writes(ids.blockSums).push(push).groups(blocks);
    plan.compute("compact.scan", "compact.scan").reads(ids.counts).updates(ids.blockSums).push(gpu::ScanPush{0, blocks, 0}).groups(1);
    plan.compute("compact.args", "compact.args")
        .reads(ids.blockSums)
        .updates(ids.counts)
        .push(gpu::ArgsPush{blocks, ids.layered ? 1 : ids.viewCount})
        .groups(1);
    plan.compute("compact.scatter", "compact.scatter")
        .reads(ids.visibility, ids.blockSums, ids.counts)
        .writes(ids.pairs)
        .push(push)
        .groups(blocks);
}

}  // namespace dpl
