// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/passthrough.h"

namespace dpl::xr {

Passthrough::~Passthrough() {
    const auto destroyLayer = runtime_.function<PFN_xrDestroyPassthroughLayerFB>("xrDestroyPassthroughLayerFB");
    const auto destroy = runtime_.function<PFN_xrDestroyPassthroughFB>("xrDestroyPassthroughFB");
    if (layer_.layerHandle && destroyLayer) destroyLayer(layer_.layerHandle);
    if (passthrough_ && destroy) destroy(passthrough_);
}

Status Passthrough::start(Calls& calls_, XrSession session) {
    const auto create = runtime_.function<PFN_xrCreatePassthroughFB>("xrCreatePassthroughFB");
    const auto createLayer = runtime_.function<PFN_xrCreatePassthroughLayerFB>("xrCreatePassthroughLayerFB");
    if (!create || !createLayer) return Error{DPL_ERROR_UNSUPPORTED, "the runtime offers XR_FB_passthrough but not its functions"};
    XrPassthroughCreateInfoFB info{XR_TYPE_PASSTHROUGH_CREATE_INFO_FB};
    info.flags = XR_PASSTHROUGH_IS_RUNNING_AT_CREATION_BIT_FB;
    DPL_XR_OK(calls_.check(create(session, &info, &passthrough_), "xrCreatePassthroughFB"));
    XrPassthroughLayerCreateInfoFB layer{XR_TYPE_PASSTHROUGH_LAYER_CREATE_INFO_FB};
    layer.passthrough = passthrough_;
    layer.flags = XR_PASSTHROUGH_IS_RUNNING_AT_CREATION_BIT_FB;
    layer.purpose = XR_PASSTHROUGH_LAYER_PURPOSE_RECONSTRUCTION_FB;
    DPL_XR_OK(calls_.check(createLayer(session, &layer, &layer_.layerHandle), "xrCreatePassthroughLayerFB"));
    layer_.flags = XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT;
    layer_.space = XR_NULL_HANDLE;
    return {};
}

}  // namespace dpl::xr
