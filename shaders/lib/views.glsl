// SPDX-License-Identifier: Apache-2.0
// Number of views, a constant of each built kernel. DPL_STEREO: two.
#ifdef DPL_STEREO
const uint kViews = 2u;
#else
const uint kViews = 1u;
#endif
