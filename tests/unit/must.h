// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <utility>

#include "sdk/core/result.h"

namespace dpl {

/** The value of a result that a test needs. An error ends the test with its message. */
template <class T>
T must(Result<T> result) {
    if (!result) throw std::runtime_error(result.error().message);
    return std::move(*result);
}

}  // namespace dpl
