// SPDX-License-Identifier: Apache-2.0
// The real surroundings as a layer below the picture, by XR_FB_passthrough. Internal to this room.
#pragma once

#include "platform/openxr/calls.h"

namespace dpl::xr {

class Passthrough {
public:
    explicit Passthrough(const Runtime& runtime) : runtime_(runtime) {}
    ~Passthrough();
    Passthrough(const Passthrough&) = delete;
    Passthrough& operator=(const Passthrough&) = delete;

    Status start(Calls& calls, XrSession session);
    const XrCompositionLayerPassthroughFB& layer() const { return layer_; }

private:
    const Runtime& runtime_;
    XrPassthroughFB passthrough_ = XR_NULL_HANDLE;
    XrCompositionLayerPassthroughFB layer_{XR_TYPE_COMPOSITION_LAYER_PASSTHROUGH_FB};
};

}  // namespace dpl::xr
