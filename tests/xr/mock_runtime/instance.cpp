// SPDX-License-Identifier: Apache-2.0
// Instances, events, names and paths.
#include <algorithm>
#include <cstring>

#include "tests/xr/mock_runtime/check.h"
#include "tests/xr/mock_runtime/entry_points.h"

namespace dpl::mockxr::entry {
namespace {

/** XrInstanceCreateInfoAndroidKHR, which openxr_platform.h declares on Android alone. */
struct AndroidApp {
    XrStructureType type;
    const void* next;
    void *vm, *activity;
};

}  // namespace

DPL_MOCKXR_ENTRY(xrEnumerateApiLayerProperties)(uint32_t, uint32_t* count, XrApiLayerProperties*) {
    *count = 0;
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrEnumerateInstanceExtensionProperties)(const char*, uint32_t capacity, uint32_t* count, XrExtensionProperties* out) {
    const std::vector<std::string>& names = runtime().settings.extensions;
    return enumerate(capacity, count, out, names.size(), [&](size_t i, XrExtensionProperties& element) {
        DPL_MOCKXR_TRY(checkStructure(&element, XR_TYPE_EXTENSION_PROPERTIES, "an element of properties"));
        setText(element.extensionName, names[i]);
        element.extensionVersion = 1;
        return XR_SUCCESS;
    });
}

DPL_MOCKXR_ENTRY(xrCreateInstance)(const XrInstanceCreateInfo* info, XrInstance* instance) {
    Runtime& r = runtime();
    if (r.instance) return violated(XR_ERROR_LIMIT_REACHED, "there is an instance already");
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_INSTANCE_CREATE_INFO, "createInfo",
                                  {XR_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT, XR_TYPE_INSTANCE_CREATE_INFO_ANDROID_KHR}));
    if (!hasText(info->applicationInfo.applicationName)) return violated(XR_ERROR_NAME_INVALID, "the application has no name");
    if (XR_VERSION_MAJOR(info->applicationInfo.apiVersion) != 1)
        return violated(XR_ERROR_API_VERSION_UNSUPPORTED, "the version of the API is not 1");
    Instance made;
    for (uint32_t i = 0; i < info->enabledExtensionCount; ++i) {
        const std::string name = info->enabledExtensionNames[i];
        const auto& offered = r.settings.extensions;
        const bool byLoader = name == XR_EXT_DEBUG_UTILS_EXTENSION_NAME;  // the loader adds it by itself
        if (!byLoader && std::find(offered.begin(), offered.end(), name) == offered.end())
            return violated(XR_ERROR_EXTENSION_NOT_PRESENT, "the runtime does not offer " + name);
        made.extensions.insert(name);
    }
    if (made.extensions.count("XR_KHR_android_create_instance") > 0) {
        const auto* app = chained<AndroidApp>(info->next, XR_TYPE_INSTANCE_CREATE_INFO_ANDROID_KHR);
        if (!app || !app->vm || !app->activity) return violated(XR_ERROR_VALIDATION_FAILURE, "the Android app is not told");
    }
    r.instance = std::move(made);
    *instance = r.instanceHandle = r.newHandle<XrInstance>();
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrDestroyInstance)(XrInstance) {
    destroyInstance();
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrGetInstanceProperties)(XrInstance, XrInstanceProperties* properties) {
    DPL_MOCKXR_TRY(checkStructure(properties, XR_TYPE_INSTANCE_PROPERTIES, "instanceProperties"));
    properties->runtimeVersion = XR_MAKE_VERSION(1, 0, 0);
    setText(properties->runtimeName, "Doppel's mock runtime");
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrPollEvent)(XrInstance, XrEventDataBuffer* event) {
    Runtime& r = runtime();
    DPL_MOCKXR_TRY(checkStructure(event, XR_TYPE_EVENT_DATA_BUFFER, "eventData"));
    if (r.events.empty()) return XR_EVENT_UNAVAILABLE;
    *event = r.events.front();
    r.events.pop_front();
    if (event->type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
        const auto& change = *reinterpret_cast<const XrEventDataSessionStateChanged*>(event);
        r.told = change.state;
        if (const auto session = r.sessions.find(change.session); session != r.sessions.end()) session->second.told = change.state;
    }
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrResultToString)(XrInstance, XrResult value, char* buffer) {
    std::snprintf(buffer, XR_MAX_RESULT_STRING_SIZE, "XrResult %d", int(value));
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrStructureTypeToString)(XrInstance, XrStructureType value, char* buffer) {
    std::snprintf(buffer, XR_MAX_STRUCTURE_NAME_SIZE, "XrStructureType %d", int(value));
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrStringToPath)(XrInstance, const char* text, XrPath* path) {
    if (!text || text[0] != '/' || std::strlen(text) >= XR_MAX_PATH_LENGTH)
        return violated(XR_ERROR_PATH_FORMAT_INVALID, std::string("not a path: ") + (text ? text : "null"));
    for (const char* c = text; *c; ++c)
        if (!std::strchr("abcdefghijklmnopqrstuvwxyz0123456789-_./", *c))
            return violated(XR_ERROR_PATH_FORMAT_INVALID, std::string("not a path: ") + text);
    std::vector<std::string>& paths = runtime().instance->paths;
    auto found = std::find(paths.begin(), paths.end(), text);
    if (found == paths.end()) found = paths.insert(paths.end(), text);
    *path = XrPath(found - paths.begin()) + 1;
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrPathToString)(XrInstance, XrPath path, uint32_t capacity, uint32_t* count, char* out) {
    DPL_MOCKXR_TRY(checkPath(path));
    return enumerateText(capacity, count, out, runtime().instance->paths[path - 1]);
}

}  // namespace dpl::mockxr::entry
