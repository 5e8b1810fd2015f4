// SPDX-License-Identifier: Apache-2.0
// A value that is made on first use. Stages that are up to date need no pictures, so these are not decoded.
#pragma once

#include <functional>
#include <optional>

#include "sdk/core/result.h"

namespace dpl {

/** For use by one thread. What `make` captures must outlive this object. After an error the next get() calls `make` again. */
template <class T>
class Lazy {
public:
    explicit Lazy(std::function<Result<T>()> make) : make_(std::move(make)) {}

    /** The value, made on the first call. The pointer is valid as long as this object. */
    Result<const T*> get() {
        if (!value_) {
            DPL_TRY(value_, make_());
        }
        return &*value_;
    }

private:
    std::function<Result<T>()> make_;
    std::optional<T> value_;
};

}  // namespace dpl
