// SPDX-License-Identifier: Apache-2.0
#include "tests/xr/mock_runtime/check.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace dpl::mockxr {

XrResult violated(XrResult result, const std::string& sentence) {
    runtime().violations.push_back(std::string(runtime().function) + ": " + sentence);
    return result;
}

XrResult checkStructure(const void* structure, XrStructureType type, const char* name, std::initializer_list<XrStructureType> next) {
    const auto* head = static_cast<const XrBaseInStructure*>(structure);
    if (!head) return violated(XR_ERROR_VALIDATION_FAILURE, std::string(name) + " is null");
    if (head->type != type)
        return violated(XR_ERROR_VALIDATION_FAILURE,
                        std::string(name) + " has type " + std::to_string(head->type) + " instead of " + std::to_string(type));
    std::vector<XrStructureType> seen;
    for (const XrBaseInStructure* s = head->next; s; s = s->next) {
        if (std::find(next.begin(), next.end(), s->type) == next.end())
            return violated(XR_ERROR_VALIDATION_FAILURE, "the chain of " + std::string(name) + " has a structure of type " +
                                                             std::to_string(s->type) + ", which does not belong there");
        if (std::find(seen.begin(), seen.end(), s->type) != seen.end())
            return violated(XR_ERROR_VALIDATION_FAILURE,
                            "the chain of " + std::string(name) + " has a structure of type " + std::to_string(s->type) + " twice");
        seen.push_back(s->type);
    }
    return XR_SUCCESS;
}

XrResult checkPose(const XrPosef& pose, const char* name) {
    const XrQuaternionf& q = pose.orientation;
    const XrVector3f& p = pose.position;
    const float norm = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    if (!(std::abs(norm - 1) <= 0.01f))
        return violated(XR_ERROR_POSE_INVALID, "the orientation of " + std::string(name) + " is not of length 1");
    if (!std::isfinite(p.x + p.y + p.z)) return violated(XR_ERROR_POSE_INVALID, "the position of " + std::string(name) + " is not finite");
    return XR_SUCCESS;
}

XrResult checkTime(XrTime time) {
    if (time <= 0) return violated(XR_ERROR_TIME_INVALID, "the time is not positive");
    return XR_SUCCESS;
}

XrResult checkPath(XrPath path) {
    if (path == XR_NULL_PATH || path > runtime().instance->paths.size())
        return violated(XR_ERROR_PATH_INVALID, "path " + std::to_string(path) + " was not made by xrStringToPath");
    return XR_SUCCESS;
}

XrResult checkSystem(XrSystemId system) {
    return system == kSystem ? XR_SUCCESS : violated(XR_ERROR_SYSTEM_INVALID, "the system id is not the one that xrGetSystem gave");
}

XrResult checkConfiguration(XrViewConfigurationType type) {
    if (type == runtime().settings.viewConfiguration) return XR_SUCCESS;
    return violated(XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED, "the system does not have view configuration " + std::to_string(type));
}

XrResult checkEnabled(const char* extension) {
    if (runtime().enabled(extension)) return XR_SUCCESS;
    return violated(XR_ERROR_FUNCTION_UNSUPPORTED, "the caller did not enable " + std::string(extension));
}

XrResult enumerateText(uint32_t capacity, uint32_t* count, char* out, const std::string& text) {
    return enumerate(capacity, count, out, text.size() + 1, [&](size_t i, char& c) {
        c = i < text.size() ? text[i] : '\0';
        return XR_SUCCESS;
    });
}

}  // namespace dpl::mockxr
