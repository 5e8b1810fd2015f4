// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/display.h"

#include <algorithm>
#include <cmath>

#include "platform/openxr/enumerate.h"

namespace dpl::xr {
namespace {

bool has(const auto& list, auto wanted) {
    return std::find(list.begin(), list.end(), wanted) != list.end();
}

/** The views of a type, or an error: not offered, wrong count, empty images. */
Status takeViews(const Runtime& runtime, Calls& calls_, XrViewConfigurationType type, uint32_t expected, const XrSystemProperties& limits,
                 Display& display) {
    std::vector<XrViewConfigurationView> views;
    DPL_XR_OK(calls_.check(enumerate(views, XrViewConfigurationView{XR_TYPE_VIEW_CONFIGURATION_VIEW},
                                     [&](auto capacity, auto count, auto out) {
                                         return xrEnumerateViewConfigurationViews(runtime.instance(), display.system, type, capacity, count,
                                                                                  out);
                                     }),
                           "xrEnumerateViewConfigurationViews"));
    if (views.size() != expected)
        return Error{DPL_ERROR_DEVICE, "the runtime lists " + std::to_string(views.size()) + " views where " + std::to_string(expected) +
                                           " are defined; update it"};
    display.views = type;
    display.viewCount = expected;
    display.groupCount = (expected + kMaxViewsOfGroup - 1) / kMaxViewsOfGroup;
    for (uint32_t group = 0; group < display.groupCount; ++group) {
        // Views of a group are drawn at once, so they have one size: the larger wish within the smaller limit.
        uint32_t width = 0, height = 0, maxWidth = DPL_MAX_IMAGE_SIDE_PX, maxHeight = DPL_MAX_IMAGE_SIDE_PX;
        const auto limit = [](uint32_t& most, uint32_t given) { most = given ? std::min(most, given) : most; };  // 0: not told
        limit(maxWidth, limits.graphicsProperties.maxSwapchainImageWidth);
        limit(maxHeight, limits.graphicsProperties.maxSwapchainImageHeight);
        for (uint32_t v = 0; v < display.viewsOf(group); ++v) {
            const XrViewConfigurationView& view = views[group * kMaxViewsOfGroup + v];
            width = std::max(width, view.recommendedImageRectWidth), height = std::max(height, view.recommendedImageRectHeight);
            limit(maxWidth, view.maxImageRectWidth), limit(maxHeight, view.maxImageRectHeight);
        }
        display.sizes[group] = {int32_t(std::min(width, maxWidth)), int32_t(std::min(height, maxHeight))};
        if (width == 0 || height == 0) return Error{DPL_ERROR_DEVICE, "the runtime recommends images without pixels; update it"};
    }
    return {};
}

}  // namespace

Result<Display> chooseDisplay(const Runtime& runtime, Calls& calls_, XrSystemId system, const SessionOptions& options) {
    Display display;
    display.system = system;
    XrSystemPassthroughPropertiesFB passthrough{XR_TYPE_SYSTEM_PASSTHROUGH_PROPERTIES_FB};
    XrSystemHandTrackingPropertiesEXT hands{XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT};
    XrSystemBodyTrackingPropertiesFB bodies{XR_TYPE_SYSTEM_BODY_TRACKING_PROPERTIES_FB};
    XrSystemProperties properties{XR_TYPE_SYSTEM_PROPERTIES};
    if (runtime.extensions().passthrough) properties.next = &passthrough;
    if (runtime.extensions().handTracking) hands.next = std::exchange(properties.next, &hands);
    if (runtime.extensions().bodyTracking) bodies.next = std::exchange(properties.next, &bodies);
    DPL_XR(xrGetSystemProperties, runtime.instance(), system, &properties);
    display.canPassThrough = runtime.extensions().passthrough && passthrough.supportsPassthrough;
    display.tracksHands = runtime.extensions().handTracking && hands.supportsHandTracking;
    display.tracksBodies = runtime.extensions().bodyTracking && bodies.supportsBodyTracking;

    std::vector<XrViewConfigurationType> types;
    DPL_XR_OK(calls_.check(enumerate(types, XrViewConfigurationType{},
                                     [&](auto capacity, auto count, auto out) {
                                         return xrEnumerateViewConfigurations(runtime.instance(), system, capacity, count, out);
                                     }),
                           "xrEnumerateViewConfigurations"));
    struct Kind {
        XrViewConfigurationType type;
        uint32_t views;
        bool wanted;
    };
    const Kind kinds[] = {
        {XR_VIEW_CONFIGURATION_TYPE_PRIMARY_QUAD_VARJO, 4, options.quadViews && runtime.extensions().quadViews},
        {XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, 2, true},
        {XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO, 1, true},
    };
    const auto kind = std::find_if(std::begin(kinds), std::end(kinds), [&](const Kind& k) { return k.wanted && has(types, k.type); });
    if (kind == std::end(kinds)) return Error{DPL_ERROR_UNSUPPORTED, "the headset has neither one, two nor four views that can be drawn"};
    DPL_XR_OK(takeViews(runtime, calls_, kind->type, kind->views, properties, display));

    std::vector<XrEnvironmentBlendMode> modes;
    DPL_XR_OK(calls_.check(enumerate(modes, XrEnvironmentBlendMode{},
                                     [&](auto capacity, auto count, auto out) {
                                         return xrEnumerateEnvironmentBlendModes(runtime.instance(), system, kind->type, capacity, count,
                                                                                 out);
                                     }),
                           "xrEnumerateEnvironmentBlendModes"));
    if (modes.empty()) return Error{DPL_ERROR_DEVICE, "the runtime lists no blend mode; update it"};
    const XrEnvironmentBlendMode wished = options.blend == Blend::Alpha      ? XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND
                                          : options.blend == Blend::Additive ? XR_ENVIRONMENT_BLEND_MODE_ADDITIVE
                                                                             : XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
    // See-through glasses have no opaque mode: their own first mode is the best there is.
    display.blendMode = has(modes, wished)                             ? wished
                        : has(modes, XR_ENVIRONMENT_BLEND_MODE_OPAQUE) ? XR_ENVIRONMENT_BLEND_MODE_OPAQUE
                                                                       : modes[0];
    return display;
}

float chooseRefreshRate(const Runtime& runtime, Calls& calls, XrSession session, float wishedHz) {
    if (!runtime.extensions().refreshRate) return 0;
    const auto list = runtime.function<PFN_xrEnumerateDisplayRefreshRatesFB>("xrEnumerateDisplayRefreshRatesFB");
    const auto get = runtime.function<PFN_xrGetDisplayRefreshRateFB>("xrGetDisplayRefreshRateFB");
    const auto request = runtime.function<PFN_xrRequestDisplayRefreshRateFB>("xrRequestDisplayRefreshRateFB");
    if (!list || !get || !request) return 0;
    std::vector<float> rates;
    const XrResult listed =
        enumerate(rates, 0.0f, [&](auto capacity, auto count, auto out) { return list(session, capacity, count, out); });
    if (wishedHz > 0 && calls.check(listed, "xrEnumerateDisplayRefreshRatesFB") && !rates.empty()) {
        const auto nearest =
            std::min_element(rates.begin(), rates.end(), [&](float a, float b) { return std::abs(a - wishedHz) < std::abs(b - wishedHz); });
        static_cast<void>(calls.check(request(session, *nearest), "xrRequestDisplayRefreshRateFB"));  // refused: the rate stays
    }
    float rate = 0;
    const bool told = bool(calls.check(get(session, &rate), "xrGetDisplayRefreshRateFB"));
    return told && std::isfinite(rate) ? rate : 0;
}

}  // namespace dpl::xr
