// SPDX-License-Identifier: Apache-2.0
// A value that is made when it is first needed: stages that are up to date need no pictures.
#pragma once

#include <functional>
#include <optional>

#include "sdk/core/result.h"

namespace dpl {

/** One thread. What `make` captures must outlive this object. A failure is not kept: the next get() tries again. */
template <class T>
class Lazy {
public:
    explicit Lazy(std::function<Result<T>()> make) : make_(std::move(make)) {}

    /** Valid as long as this object. */
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
