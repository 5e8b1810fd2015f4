// SPDX-License-Identifier: Apache-2.0
// Checks that a list of steps is a valid frame. Every backend calls this before it records.
#pragma once

#include <span>

#include "sdk/backend/backend.h"
#include "sdk/backend/shader_pack.h"

namespace dpl {

/** The resources of a backend. Functions return nullptr for handles that do not exist. */
class ResourceView {
public:
    virtual ~ResourceView() = default;
    virtual const BufferDesc* buffer(BufferId id) const = 0;
    virtual const TargetDesc* target(TargetId id) const = 0;
    /** Compute pipelines: the shader. Draw pipelines: the vertex shader. */
    virtual const Shader* shader(PipelineId id) const = 0;
    /** Draw pipelines: the fragment shader, else nullptr. */
    virtual const Shader* fragment(PipelineId id) const = 0;
    /** True when write() or a queued copy has filled the Device buffer, or a frame that was created earlier writes it. */
    virtual bool written(BufferId id) const = 0;
    /** True when a frame that was created earlier draws the target. */
    virtual bool drawn(TargetId id) const = 0;
};

/** Refuses unknown handles, bindings that differ from the shader's reflection (count, kind, access), a wrong push size, zero or too many
 *  workgroups, a binding above the device limit, one buffer bound twice in a step, read-back buffers that are too small, and reads of a
 *  Device buffer or target that nothing has written before. Errors name the step. */
Status checkFrame(std::span<const Step> steps, const ResourceView& resources, const DeviceInfo& device);

/** The Device buffers that the steps write. */
std::vector<BufferId> writtenBy(std::span<const Step> steps);

}  // namespace dpl
