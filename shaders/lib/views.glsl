// SPDX-License-Identifier: Apache-2.0
// Views of the frame. kViews: their number, a constant of each built kernel. DPL_STEREO: two.
#ifdef DPL_STEREO
const uint kViews = 2u;
#else
const uint kViews = 1u;
#endif
vec3 dplEyeWorld(ViewData view) { return vec3(view.eyeX, view.eyeY, view.eyeZ); }
