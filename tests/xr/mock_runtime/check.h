// SPDX-License-Identifier: Apache-2.0
// Checks of what the caller passes. Each failed check keeps a sentence (Runtime::violations) and returns the specification's error.
#pragma once

#include <initializer_list>
#include <string>

#include "tests/xr/mock_runtime/runtime.h"

#define DPL_MOCKXR_TRY(call) \
    if (const XrResult tried = (call); XR_FAILED(tried)) return tried

namespace dpl::mockxr {

/** Keeps "FUNCTION: sentence" and returns `result`. */
XrResult violated(XrResult result, const std::string& sentence);

/** A structure of the caller: not null, its type, and only structures of the types `next` in its chain, each at most once. */
XrResult checkStructure(const void* structure, XrStructureType type, const char* name, std::initializer_list<XrStructureType> next = {});

/** The structure of that type in a chain that was checked, or null. */
template <class T>
const T* chained(const void* next, XrStructureType type) {
    for (auto* s = static_cast<const XrBaseInStructure*>(next); s; s = s->next)
        if (s->type == type) return reinterpret_cast<const T*>(s);
    return nullptr;
}
template <class T>
T* chained(void* next, XrStructureType type) {
    return const_cast<T*>(chained<T>(static_cast<const void*>(next), type));
}

XrResult checkPose(const XrPosef& pose, const char* name);
XrResult checkTime(XrTime time);
XrResult checkPath(XrPath path);
XrResult checkSystem(XrSystemId system);
XrResult checkConfiguration(XrViewConfigurationType type);
/** An extension that the caller enabled. */
XrResult checkEnabled(const char* extension);

/** The two-call idiom: the first call asks for the count, the second gives an array. put(i, element) fills an element. */
template <class T, class Put>
XrResult enumerate(uint32_t capacity, uint32_t* count, T* out, size_t size, Put put) {
    if (!count) return violated(XR_ERROR_VALIDATION_FAILURE, "the count is null");
    *count = uint32_t(size);
    if (capacity == 0) return XR_SUCCESS;
    if (!out) return violated(XR_ERROR_VALIDATION_FAILURE, "the array is null, but its capacity is not 0");
    if (capacity < size) return XR_ERROR_SIZE_INSUFFICIENT;
    for (size_t i = 0; i < size; ++i) DPL_MOCKXR_TRY(put(i, out[i]));
    return XR_SUCCESS;
}
template <class T>
XrResult enumerate(uint32_t capacity, uint32_t* count, T* out, const std::vector<T>& values) {
    return enumerate(capacity, count, out, values.size(), [&](size_t i, T& element) {
        element = values[i];
        return XR_SUCCESS;
    });
}
XrResult enumerateText(uint32_t capacity, uint32_t* count, char* out, const std::string& text);

/** Copies text into a fixed array of a structure. */
template <size_t n>
void setText(char (&to)[n], const std::string& text) {
    to[text.copy(to, n - 1)] = 0;
}
/** Whether a fixed array holds a text with an end and at least one character. */
template <size_t n>
bool hasText(const char (&text)[n]) {
    return text[0] != 0 && std::string(text, n).find('\0') != std::string::npos;
}

}  // namespace dpl::mockxr
