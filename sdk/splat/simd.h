// SPDX-License-Identifier: Apache-2.0
// The Highway targets that we build. Private to sdk/splat; include it before any Highway header.
#pragma once

// Scalable vectors have no operators and no constant size in Highway 1.0; NEON covers Arm machines. SSSE3 and AVX3_DL would only cost
// compile time. SSE4, AVX2, AVX-512 and plain C++ remain on x86.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV | HWY_SSSE3 | HWY_AVX3_DL)
