// SPDX-License-Identifier: Apache-2.0
// How tests wait for what other threads and programs do. A busy machine may take long over it, so nothing here is a statement about speed.
#pragma once

#include <chrono>
#include <thread>

namespace dpl::test {

/** For events that must come. Only what hangs takes so long. */
constexpr std::chrono::minutes kPatience{10};

/** Looks again and again until the condition holds; for states that no event tells of. False: it did not come to hold within kPatience. */
template <class Condition>
bool waitUntil(Condition condition) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!condition()) {
        if (std::chrono::steady_clock::now() > end) return false;
        std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    return true;
}

}  // namespace dpl::test
