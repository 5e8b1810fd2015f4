// SPDX-License-Identifier: Apache-2.0
// The buffers of a training step on a GPU, and the recorded step. Sizes are known before anything is made, so a device with too little
// memory is refused before a run begins.
#pragma once

#include "sdk/render/device_buffers.h"
#include "sdk/render/frame_ids.h"
#include "shaders/training/shared/train.h"

namespace dpl {

/** What buffers must hold. Splats, triangles, vertices and floats are exact, because dispatches depend on them; the others may be larger
 *  than a picture needs. */
struct GpuSizes {
    uint32_t splats = 0, triangles = 0, vertices = 0;
    uint32_t shFloats = 0, rowFloats = 0;  // of a splat
    uint64_t pixels = 0, tiles = 0, entries = 0;

    bool holds(const GpuSizes& other) const;
};

/** A Device buffer that the host fills anew for each picture. */
struct UploadedBuffer {
    BufferId host, device;
};
/** A Device buffer that the host reads after each picture. */
struct ReadBuffer {
    BufferId device, host;
};

struct GpuBuffers {
    explicit GpuBuffers(Backend& backend) : backend_(backend), owned_(backend) {}
    ~GpuBuffers();
    GpuBuffers(const GpuBuffers&) = delete;
    GpuBuffers& operator=(const GpuBuffers&) = delete;

    /** Makes the buffers and records the step. */
    Status make(const GpuSizes& wanted);

    GpuSizes sizes;
    BufferId frame, depthCounts;  // mapped
    UploadedBuffer splats, sh, triangles, rests, starts, floors, incidence, cornersOf, target;
    BufferId screen, records, firsts, owners, entrySums, parts, corners;
    BufferId image, cloths, stops, planes, blurred, maps, gradients;
    BufferId depthPairs, depthSwap, entryPairs, entrySwap, offsets, entries;
    TableIds digits, cells;
    ReadBuffer counts, sums, rows, shown, vertices;
    FrameId recorded;

private:
    Status makeBuffers();
    Status record();  // gpu_steps.cpp
    Status upload(UploadedBuffer& buffer, const char* label, uint64_t bytes);
    Status read(ReadBuffer& buffer, const char* label, uint64_t bytes);

    Backend& backend_;
    DeviceBuffers owned_;
};

}  // namespace dpl
