// SPDX-License-Identifier: Apache-2.0
// Whether a list of steps is a valid frame: every backend asks here before it records.
#pragma once

#include <span>

#include "sdk/backend/backend.h"
#include "sdk/backend/shader_pack.h"

namespace dpl {

/** What a backend knows of its resources. Return nullptr for handles that do not exist. */
class ResourceView {
public:
    virtual ~ResourceView() = default;
    virtual const BufferDesc* buffer(BufferId id) const = 0;
    virtual const TargetDesc* target(TargetId id) const = 0;
    /** Compute pipelines: the shader. Draw pipelines: the vertex shader. */
    virtual const Shader* shader(PipelineId id) const = 0;
    /** Draw pipelines: the fragment shader, else nullptr. */
    virtual const Shader* fragment(PipelineId id) const = 0;
    /** True when the CPU has filled a Device buffer by write(). */
    virtual bool written(BufferId id) const = 0;
    /** True when a frame that was made before draws the target. */
    virtual bool drawn(TargetId id) const = 0;
};

/** Refuses: unknown handles, a binding list that differs from the shader's reflection (count, kind, access), wrong push size,
 *  zero or too many groups, a binding above the device limit, bindings of one buffer twice, read-back buffers that are too
 *  small, and reads of a Device buffer or target that nothing has written before. Errors name the step. */
Status checkFrame(std::span<const Step> steps, const ResourceView& resources, const DeviceInfo& device);

}  // namespace dpl
