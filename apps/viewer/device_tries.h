// SPDX-License-Identifier: Apache-2.0
// How often a lost graphics device is opened again before the viewer gives up.
#pragma once

#include <vector>

namespace dpl {

class DeviceTries {
public:
    static constexpr size_t kMost = 3;
    static constexpr double kWithinS = 60;

    /** Counts another try. False: there were kMost within the last kWithinS already. nowS: of any clock that never goes back. */
    bool take(double nowS) {
        std::erase_if(triesS_, [&](double at) { return nowS - at >= kWithinS; });
        if (triesS_.size() == kMost) return false;
        triesS_.push_back(nowS);
        return true;
    }

private:
    std::vector<double> triesS_;
};

}  // namespace dpl
