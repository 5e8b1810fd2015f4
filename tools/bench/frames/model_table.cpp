// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/frames/model_table.h"

namespace dpl {

std::string modelOf(const BenchCase& test, const std::vector<Contestant>& list, const BenchSubject& subject, const ReferenceFile& referee,
                    const ModelMachine& machine) {
    std::string rows;
    if (subject.info.jointCount == 0) return rows;
    FrameWork sizes{.vertices = subject.info.vertexCount,
                    .triangles = subject.info.triangleCount,
                    .splats = subject.info.splatCount,
                    .shDegree = subject.info.shDegree,
                    .corrected = referee.hasPoseCorrectives(),
                    .lit = referee.hasLight(),
                    .views = test.viewCount,
                    .pixels = uint64_t(test.widthPx) * test.heightPx * test.viewCount};
    for (const char* option : {"vulkan-quads", "vulkan-tiles"})
        for (const Contestant& c : list) {
            if (c.option != option || c.stats.splatsDrawn == 0) continue;
            FrameWork work = sizes;
            work.trianglesFacing = c.stats.trianglesFacing, work.groups = c.stats.chunkCount, work.liveGroups = c.stats.chunksProjected,
            work.splatsFacing = c.stats.splatsFacing, work.splatsDrawn = c.stats.splatsDrawn;
            work.bytesDecided = c.stats.bytesDecided, work.bytesDecoded = c.stats.bytesDecoded;
            work.tileEntries = c.stats.tilesOverflowed ? 0 : c.stats.tileEntries;
            rows += modelRows(formatText("{}, {}", test.name, option), modelPlainFloat(work), modelToday(work), machine);
        }
    return rows;
}

}  // namespace dpl
