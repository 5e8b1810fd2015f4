// SPDX-License-Identifier: Apache-2.0
// Peak of live heap bytes since the watch began, counted in operator new. Always 0 under a sanitizer or libFuzzer, which replace the heap.
#pragma once

#include <cstdint>

namespace dpl::test {

void startMemoryWatch();
uint64_t peakMemoryBytes();

}  // namespace dpl::test
