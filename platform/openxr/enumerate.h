// SPDX-License-Identifier: Apache-2.0
// OpenXR's two-call enumeration. Internal to this room.
#pragma once

#include <utility>
#include <vector>

#include "platform/openxr/openxr.h"

namespace dpl::xr {

constexpr uint32_t kMaxListed = 4096;  // a longer list is a broken runtime's

/** All elements that `call(capacity, &count, elements)` lists. init: what each element is filled with before, for its structure type. */
template <class T, class Call>
XrResult enumerate(std::vector<T>& out, const T& init, Call&& call) {
    for (int attempt = 0; attempt < 3; ++attempt) {  // the list may grow between the calls
        uint32_t count = 0;
        XrResult result = call(0u, &count, static_cast<T*>(nullptr));
        if (XR_FAILED(result)) return result;
        if (count > kMaxListed) return XR_ERROR_RUNTIME_FAILURE;
        out.assign(count, init);
        if (count == 0) return XR_SUCCESS;
        result = call(count, &count, out.data());
        if (result == XR_ERROR_SIZE_INSUFFICIENT) continue;
        if (XR_FAILED(result)) return result;
        if (count < out.size()) out.resize(count);
        return XR_SUCCESS;
    }
    return XR_ERROR_SIZE_INSUFFICIENT;
}

}  // namespace dpl::xr
