// Which Highway targets we build. Private to sdk/splat; include before any Highway header.
#pragma once

// Scalable vectors have no operators and no constant size in Highway 1.0; NEON covers those machines.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
