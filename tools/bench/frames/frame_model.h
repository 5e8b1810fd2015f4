// SPDX-License-Identifier: Apache-2.0
// A model, not a measurement: the bytes that each pass of a frame moves and the operations that it does, from counted survivors, divided by
// what a machine moves and does in a second. docs/model.md says what is counted and what is not.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

namespace dpl {

/** One frame of an avatar: its sizes, and what the renderer counted (DplFrameStats). */
struct FrameWork {
    uint32_t vertices = 0, triangles = 0, splats = 0, shDegree = 0;
    bool corrected = false;  // has pose correctives
    uint32_t views = 1;
    uint64_t pixels = 0;                                                         // of all views
    uint32_t trianglesFacing = 0, groups = 0, liveGroups = 0, splatsFacing = 0;  // survivors of today's culling
    uint32_t splatsDrawn = 0;
    uint64_t bytesDecided = 0, bytesDecoded = 0;  // of splat codes
    uint32_t tileEntries = 0;                     // 0: quads fill
};

/** A phone's data sheet (docs/model.md): 64 bits of LPDDR5 at 6,400 MT/s; six GPU cores of 128 lanes that multiply and add at 1.4 GHz. */
struct ModelMachine {
    double gbps = 51.2, gflops = 2150;  // 10⁹ bytes, and operations on numbers, a second
};

struct ModelledPass {
    std::string label;  // as in the table of GPU times; passes of one kind are added up
    uint64_t readBytes = 0, writtenBytes = 0;
    uint64_t operations = 0;

    uint64_t bytes() const { return readBytes + writtenBytes; }
    /** The longer of moving and working, which overlap. */
    double milliseconds(const ModelMachine& m) const { return std::max(double(bytes()) / m.gbps, double(operations) / m.gflops) / 1e6; }
};

/** The frozen plain frame (tools/bench/baseline): every view is a frame of its own. Uses sizes, views, pixels and splatsDrawn of `work`. */
std::vector<ModelledPass> modelPlainFloat(const FrameWork& work);
/** Today's frame, by quads or, with tileEntries, by tiles. */
std::vector<ModelledPass> modelToday(const FrameWork& work);

/** A table's rows for one case: a row a pass that either frame has, and the sums. */
std::string modelRows(const std::string& name, const std::vector<ModelledPass>& plain, const std::vector<ModelledPass>& today,
                      const ModelMachine& machine);

}  // namespace dpl
