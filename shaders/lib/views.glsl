// SPDX-License-Identifier: Apache-2.0
// How many views a kernel works for: known when it is built. DPL_STEREO: two.
#ifdef DPL_STEREO
const uint kViews = 2u;
#else
const uint kViews = 1u;
#endif
