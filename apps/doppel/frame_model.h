// A model, not a measurement: bytes that the passes of a frame read and write, from counted survivors and record sizes, over a memory bandwidth.
// What is counted and what is not: docs/model.md.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace dpl {

/** What one frame of an avatar works through: the avatar's sizes, and what the renderer counted (DplFrameStats). */
struct FrameWork {
    uint32_t vertices = 0, triangles = 0, splats = 0, shDegree = 0;
    bool corrected = false;                       // has pose correctives
    uint32_t views = 1;
    uint64_t pixels = 0;                          // of all views
    uint32_t trianglesFacing = 0, groups = 0, liveGroups = 0;  // today's tiers; groups: half-chunks
    uint32_t splatsDrawn = 0;
    uint64_t bytesDecided = 0, bytesDecoded = 0;  // of splat codes
    uint32_t tileEntries = 0;                     // 0: quads fill
};

struct ModelledPass {
    std::string label;    // as in the table of GPU times, passes of one kind together
    uint64_t readBytes = 0, writtenBytes = 0;

    uint64_t bytes() const { return readBytes + writtenBytes; }
    /** gbps: 10⁹ bytes a second. */
    double milliseconds(double gbps) const { return double(bytes()) / gbps / 1e6; }
};

/** The frozen plain frame (tests/baseline): every view is a frame of its own. Of `work` it knows sizes, views, pixels and splatsDrawn. */
std::vector<ModelledPass> modelPlainFloat(const FrameWork& work);
/** Today's frame, by quads or, with tileEntries, by tiles. */
std::vector<ModelledPass> modelToday(const FrameWork& work);

/** A table's rows for one case: a row a pass that either frame has, and the sums. */
std::string modelRows(const std::string& name, const std::vector<ModelledPass>& plain, const std::vector<ModelledPass>& today, double gbps);

}  // namespace dpl
