// SPDX-License-Identifier: Apache-2.0
// The MSL kernels, compiled as C++ (cpu/msl_cpu.h). A kernel returns false when lanes of a threadgroup wait at different barriers.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#define DPL_MSL(name) bool name(void* const* buffers, unsigned groups, int order)
DPL_MSL(msl_skin);
DPL_MSL(msl_skin_corrected);
DPL_MSL(msl_triangles_stereo);
DPL_MSL(msl_mesh_depth);
DPL_MSL(msl_chunks_mark);
DPL_MSL(msl_chunks_list);
DPL_MSL(msl_project_sh3_stereo);
DPL_MSL(msl_project_general_stereo);
DPL_MSL(msl_colour_general_sh3_stereo);
DPL_MSL(msl_scan_totals);
DPL_MSL(msl_scan_places);
DPL_MSL(msl_scan_sums);
DPL_MSL(msl_compact_masks);
DPL_MSL(msl_compact_args);
DPL_MSL(msl_compact_scatter);
DPL_MSL(msl_sort_count);
DPL_MSL(msl_sort_count_packed);
DPL_MSL(msl_sort_scatter_pack);
DPL_MSL(msl_sort_scatter_packed);
DPL_MSL(msl_sort_scatter);
DPL_MSL(msl_tiles_runs_stereo);
DPL_MSL(msl_tiles_args_spans);
DPL_MSL(msl_tiles_spans_stereo);
DPL_MSL(msl_tiles_count);
DPL_MSL(msl_tiles_args_entries);
DPL_MSL(msl_tiles_entries);
DPL_MSL(msl_tiles_fill_depth);
DPL_MSL(msl_tiles_fill_depth_scene);
DPL_MSL(msl_tiles_fill_depth_four);
DPL_MSL(msl_tiles_fill_depth_scene_four);
DPL_MSL(msl_tiles_search_depth);
DPL_MSL(msl_tiles_search_depth_scene);
DPL_MSL(msl_tiles_search_depth_four);
DPL_MSL(msl_tiles_search_depth_scene_four);
#undef DPL_MSL

namespace dpl {

inline uint32_t groupsFor(size_t count, uint32_t size) {
    return uint32_t((count + size - 1) / size);
}

/** Dispatches a kernel. Buffers are in binding order; push constants come last. */
template <class Push>
void run(bool (*kernel)(void* const*, unsigned, int), uint32_t groups, int order, std::vector<void*> buffers, Push push) {
    buffers.push_back(&push);
    ASSERT_TRUE(kernel(buffers.data(), groups, order)) << "lanes left a barrier alone";
}

}  // namespace dpl
