// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "sdk/core/task.h"

namespace dpl::test {

/** Keeps what its work says, and is cancelled when it has heard `cancelAt` things. */
class HeardTask : public Task {
public:
    explicit HeardTask(size_t cancelAt = ~size_t(0)) : cancelAt_(cancelAt) {
        if (cancelAt_ == 0) cancel();
    }
    void hear(double share, std::string_view doing) override {
        heard.emplace_back(share, doing);
        if (heard.size() >= cancelAt_) cancel();
    }
    std::vector<std::pair<double, std::string>> heard;

private:
    size_t cancelAt_;
};

}  // namespace dpl::test
