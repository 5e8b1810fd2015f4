// SPDX-License-Identifier: Apache-2.0
// The buffers of a training on a GPU: those that hold the state between steps, and those of a picture, with the recorded step. Their sizes
// follow from the numbers below alone.
#pragma once

#include "sdk/render/device_buffers.h"
#include "sdk/render/frame_ids.h"
#include "shaders/training/shared/train.h"

namespace dpl {

struct GpuStateSizes {
    uint32_t splats = 0, triangles = 0, vertices = 0;
    uint32_t shFloats = 0, rowFloats = 0;  // of a splat
};

/** What the buffers of a picture hold at most. */
struct GpuPictureSizes {
    uint64_t pixels = 0, tiles = 0, entries = 0;
    bool holds(const GpuPictureSizes& o) const { return pixels >= o.pixels && tiles >= o.tiles && entries >= o.entries; }
};

/** A Device buffer that the host fills anew for each picture. */
struct UploadedBuffer {
    BufferId host, device;
};

/** Makes the buffers of one owner; or, without one, only adds up their bytes. */
class BufferMaker {
public:
    explicit BufferMaker(DeviceBuffers* owner) : owner_(owner) {}
    Status make(BufferId& buffer, const char* label, uint64_t bytes, BufferMemory memory = BufferMemory::Device);

    uint64_t deviceBytes() const { return deviceBytes_; }  // of Device buffers
    uint64_t largestBytes() const { return largestBytes_; }

private:
    DeviceBuffers* owner_;
    uint64_t deviceBytes_ = 0, largestBytes_ = 0;
};
/** A Device buffer that the host reads. */
struct ReadBuffer {
    BufferId device, host;
};

/** Between steps. Written by Backend::write(). */
struct GpuState {
    explicit GpuState(Backend& backend) : backend_(backend), owned_(backend) {}
    ~GpuState();
    Status make(const GpuStateSizes& sizes);
    Status makeBuffers(const GpuStateSizes& sizes, BufferMaker& maker);
    /** Records its frames (gpu_steps.cpp), once all that they read is written. */
    Status record(const GpuStateSizes& sizes);

    BufferId splats, sh, constants, rests, nows, starts, incidence, cornersOf, corrections;
    ReadBuffer rows, firstMoments, secondMoments, steps, densitySums, seen;
    BufferId frame;    // mapped
    FrameId activate;  // computes the linear values from the rows
    FrameId readBack;  // copies the ReadBuffers to the host

private:
    Backend& backend_;
    DeviceBuffers owned_;
};

/** Of a picture. */
struct GpuPicture {
    explicit GpuPicture(Backend& backend) : backend_(backend), owned_(backend) {}
    ~GpuPicture();
    /** Makes the buffers and records the step with those of `state`, which must live as long. */
    Status make(const GpuStateSizes& state, const GpuState& buffers, const GpuPictureSizes& sizes);

    Status makeBuffers(const GpuStateSizes& state, const GpuPictureSizes& sizes, BufferMaker& maker);

    GpuPictureSizes sizes;
    BufferId frame, depthCounts, rates;  // mapped
    UploadedBuffer posed;
    BufferId target, triangles;
    BufferId screen, records, firstEntries, owners, entrySums, parts, corners;
    BufferId image, cloths, stops, planes, blurred, maps, gradients;
    BufferId depthPairs, depthSwap, entryPairs, entrySwap, offsets, entries;
    TableIds digits, cells;
    ReadBuffer counts, sums, rowGradients, shown, vertices;
    FrameId step;    // up to the gradients of the vertices, which the host reads
    FrameId update;  // of the splats, after it
    FrameId readGradients;

private:
    Status record(const GpuStateSizes& state, const GpuState& buffers);  // gpu_steps.cpp
    Backend& backend_;
    DeviceBuffers owned_;
};

}  // namespace dpl
