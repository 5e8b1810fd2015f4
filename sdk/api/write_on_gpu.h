// SPDX-License-Identifier: Apache-2.0
// Splats in a buffer of a program that lends its device: what Vulkan and Metal have in common.
#pragma once

#include "sdk/api/app_frame.h"
#include "sdk/api/splat_request.h"

namespace dpl::api {

/** A buffer of the program's and its layout. */
struct GpuBuffer {
    const DplBufferElement* elements;
    uint32_t elementCount;
    uint64_t bytes;
};

/** Where it is recorded. lend: puts the program's buffer, from `offset` on, in place of `rows` in a frame; offset is a multiple of 256. */
struct WriteRecording {
    uint32_t slot;
    AppCommands commands;
    FunctionRef<Status(FrameId frame, BufferId rows, uint64_t offset, uint64_t bytes)> lend;
};

/** Tells how many splats a request writes. The context is locked. */
Status countSplats(const AppSide& side, const Avatar& avatar, const SplatRequest& request, DplWritten* written);

/** Records a write. The context is locked. */
Status writeSplatsOnGpu(const AppSide& side, Avatar& avatar, const SplatRequest& request, const GpuBuffer& buffer,
                        const WriteRecording& recording, DplWritten* written);

}  // namespace dpl::api
