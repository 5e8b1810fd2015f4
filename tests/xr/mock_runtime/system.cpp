// SPDX-License-Identifier: Apache-2.0
// The headset: what it is, its views and blend modes.
#include "tests/xr/mock_runtime/check.h"
#include "tests/xr/mock_runtime/entry_points.h"

namespace dpl::mockxr::entry {

DPL_MOCKXR_ENTRY(xrGetSystem)(XrInstance, const XrSystemGetInfo* info, XrSystemId* system) {
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_SYSTEM_GET_INFO, "getInfo"));
    if (info->formFactor != XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY) return XR_ERROR_FORM_FACTOR_UNSUPPORTED;
    if (!runtime().settings.hasSystem) return XR_ERROR_FORM_FACTOR_UNAVAILABLE;
    *system = kSystem;
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrGetSystemProperties)(XrInstance, XrSystemId system, XrSystemProperties* properties) {
    DPL_MOCKXR_TRY(checkSystem(system));
    DPL_MOCKXR_TRY(checkStructure(properties, XR_TYPE_SYSTEM_PROPERTIES, "properties",
                                  {XR_TYPE_SYSTEM_PASSTHROUGH_PROPERTIES_FB, XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT,
                                   XR_TYPE_SYSTEM_BODY_TRACKING_PROPERTIES_FB}));
    if (auto* passthrough = chained<XrSystemPassthroughPropertiesFB>(properties->next, XR_TYPE_SYSTEM_PASSTHROUGH_PROPERTIES_FB))
        passthrough->supportsPassthrough = runtime().enabled(XR_FB_PASSTHROUGH_EXTENSION_NAME);
    if (auto* hands = chained<XrSystemHandTrackingPropertiesEXT>(properties->next, XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT))
        hands->supportsHandTracking = runtime().enabled(XR_EXT_HAND_TRACKING_EXTENSION_NAME) && runtime().settings.tracksHands;
    if (auto* bodies = chained<XrSystemBodyTrackingPropertiesFB>(properties->next, XR_TYPE_SYSTEM_BODY_TRACKING_PROPERTIES_FB))
        bodies->supportsBodyTracking = runtime().enabled(XR_FB_BODY_TRACKING_EXTENSION_NAME) && runtime().settings.tracksBodies;
    properties->systemId = kSystem;
    properties->vendorId = 0;
    setText(properties->systemName, "Doppel's mock headset");
    const uint32_t side = runtime().settings.maxSidePx;
    properties->graphicsProperties = {side, side, XR_MIN_COMPOSITION_LAYERS_SUPPORTED};
    properties->trackingProperties = {XR_TRUE, XR_TRUE};
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrEnumerateEnvironmentBlendModes)
(XrInstance, XrSystemId system, XrViewConfigurationType type, uint32_t capacity, uint32_t* count, XrEnvironmentBlendMode* out) {
    DPL_MOCKXR_TRY(checkSystem(system));
    DPL_MOCKXR_TRY(checkConfiguration(type));
    return enumerate(capacity, count, out, runtime().settings.blendModes);
}

DPL_MOCKXR_ENTRY(xrEnumerateViewConfigurations)
(XrInstance, XrSystemId system, uint32_t capacity, uint32_t* count, XrViewConfigurationType* out) {
    DPL_MOCKXR_TRY(checkSystem(system));
    return enumerate(capacity, count, out, std::vector{runtime().settings.viewConfiguration});
}

DPL_MOCKXR_ENTRY(xrGetViewConfigurationProperties)
(XrInstance, XrSystemId system, XrViewConfigurationType type, XrViewConfigurationProperties* properties) {
    DPL_MOCKXR_TRY(checkSystem(system));
    DPL_MOCKXR_TRY(checkConfiguration(type));
    DPL_MOCKXR_TRY(checkStructure(properties, XR_TYPE_VIEW_CONFIGURATION_PROPERTIES, "configurationProperties"));
    properties->viewConfigurationType = type;
    properties->fovMutable = XR_FALSE;
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrEnumerateViewConfigurationViews)
(XrInstance, XrSystemId system, XrViewConfigurationType type, uint32_t capacity, uint32_t* count, XrViewConfigurationView* out) {
    DPL_MOCKXR_TRY(checkSystem(system));
    DPL_MOCKXR_TRY(checkConfiguration(type));
    const Settings& settings = runtime().settings;
    return enumerate(capacity, count, out, settings.views.size(), [&](size_t, XrViewConfigurationView& view) {
        DPL_MOCKXR_TRY(checkStructure(&view, XR_TYPE_VIEW_CONFIGURATION_VIEW, "an element of views"));
        view.recommendedImageRectWidth = settings.widthPx, view.recommendedImageRectHeight = settings.heightPx;
        view.maxImageRectWidth = view.maxImageRectHeight = settings.maxSidePx;
        view.recommendedSwapchainSampleCount = view.maxSwapchainSampleCount = 1;
        return XR_SUCCESS;
    });
}

}  // namespace dpl::mockxr::entry
