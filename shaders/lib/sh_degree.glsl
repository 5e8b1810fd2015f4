// SPDX-License-Identifier: Apache-2.0
// A kernel is built for one SH degree: DPL_SH1, DPL_SH2, DPL_SH3, or 0 without them.
#if defined(DPL_SH3)
const uint kShDegree = 3u;
#elif defined(DPL_SH2)
const uint kShDegree = 2u;
#elif defined(DPL_SH1)
const uint kShDegree = 1u;
#else
const uint kShDegree = 0u;
#endif
