// SPDX-License-Identifier: Apache-2.0
// The only place that knows how a draw reaches several views. Mono is stereo with one view.
//   DPL_VIEW_MULTIVIEW  one draw reaches all of them, target layer = view (VK_KHR_multiview, core in 1.1)
//   otherwise           a draw a view, into its layer
#ifdef DPL_VIEW_MULTIVIEW
#extension GL_EXT_multiview : require
uint dplViewIndex(uint view) { return uint(gl_ViewIndex); }
#else
uint dplViewIndex(uint view) { return view; }
#endif
// All in one instance: one of a few vertices leaves lanes of the vertex shader idle, and costs lavapipe a draw.
uint dplSplat() { return uint(gl_VertexIndex) / 3u; }
uint dplCorner() { return uint(gl_VertexIndex) % 3u; }
