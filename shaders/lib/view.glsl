// SPDX-License-Identifier: Apache-2.0
// How a draw reaches its views. No other file depends on multiview.
//   DPL_VIEW_MULTIVIEW  one draw reaches all of them, target layer = view (VK_KHR_multiview, core in 1.1)
//   otherwise           a draw a view, into its layer
#ifdef DPL_VIEW_MULTIVIEW
#extension GL_EXT_multiview : require
uint dplViewIndex(uint view) { return uint(gl_ViewIndex); }
#else
uint dplViewIndex(uint view) { return view; }
#endif
