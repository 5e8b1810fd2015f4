// SPDX-License-Identifier: Apache-2.0
// The only place that knows how a draw reaches several views. Two build-time bodies:
//   DPL_VIEW_MULTIVIEW  the pass runs once per view, target layer = view (VK_KHR_multiview, core in 1.1)
//   DPL_VIEW_INSTANCES  instances are splats × views; views lie side by side in one wide image
// Mono is stereo with one view.
#if defined(DPL_VIEW_MULTIVIEW)
#extension GL_EXT_multiview : require
uint dplViewIndex(uint viewCount) { return uint(gl_ViewIndex); }
uint dplSplatInstance(uint viewCount) { return uint(gl_InstanceIndex); }
#elif defined(DPL_VIEW_INSTANCES)
uint dplViewIndex(uint viewCount) { return uint(gl_InstanceIndex) % viewCount; }
uint dplSplatInstance(uint viewCount) { return uint(gl_InstanceIndex) / viewCount; }
#else
#error "build this shader with DPL_VIEW_MULTIVIEW or DPL_VIEW_INSTANCES"
#endif
