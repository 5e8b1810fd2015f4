// SPDX-License-Identifier: Apache-2.0
// A model, not a measurement, of a frame's time. It computes the bytes that each pass moves and the operations that it does from the
// counted survivors, and divides them by the machine's bandwidth and arithmetic rate. docs/model.md says what is counted and what is not.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

namespace dpl {

/** One frame of an avatar: its sizes, and the counts of the renderer (DplFrameStats). */
struct FrameWork {
    uint32_t vertices = 0, triangles = 0, splats = 0, shDegree = 0;
    bool corrected = false;  // has pose correctives
    bool lit = false;        // has light of the scene
    uint32_t views = 1;
    uint64_t pixels = 0;                                                         // sum over all views
    uint32_t trianglesFacing = 0, groups = 0, liveGroups = 0, splatsFacing = 0;  // survivors of the current frame's culling
    uint32_t splatsDrawn = 0;
    uint64_t bytesDecided = 0, bytesDecoded = 0;  // bytes of splat codes
    uint32_t tileEntries = 0;                     // 0 if quads fill the pixels
};

/** A phone's data sheet (docs/model.md): 64 bits of LPDDR5 at 6,400 MT/s; six GPU cores of 128 lanes that multiply and add at 1.4 GHz. */
struct ModelMachine {
    double gbps = 51.2, gflops = 2150;  // 10⁹ bytes per second, 10⁹ operations per second
};

struct ModelledPass {
    std::string label;  // as in the table of GPU times; passes of one kind are summed
    uint64_t readBytes = 0, writtenBytes = 0;
    uint64_t operations = 0;

    uint64_t bytes() const { return readBytes + writtenBytes; }
    /** The longer of memory time and arithmetic time, because the two overlap. */
    double milliseconds(const ModelMachine& m) const { return std::max(double(bytes()) / m.gbps, double(operations) / m.gflops) / 1e6; }
};

/** The frozen plain frame (tools/bench/baseline), one frame per view. Uses sizes, views, pixels and splatsDrawn of `work`. */
std::vector<ModelledPass> modelPlainFloat(const FrameWork& work);
/** The current frame: filled by quads, or by tiles if tileEntries is not 0. */
std::vector<ModelledPass> modelToday(const FrameWork& work);

/** Table rows for one case: one row per pass of either frame, then the sums. */
std::string modelRows(const std::string& name, const std::vector<ModelledPass>& plain, const std::vector<ModelledPass>& today,
                      const ModelMachine& machine);

}  // namespace dpl
