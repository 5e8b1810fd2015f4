// The only place that knows how a draw reaches several views. Two build-time bodies:
//   DPL_VIEW_MULTIVIEW  the pass runs once per view, target layer = view (VK_KHR_multiview, core in 1.1)
//   DPL_VIEW_INSTANCES  quads are splats × views; views lie side by side in one wide image
// Mono is stereo with one view.
#if defined(DPL_VIEW_MULTIVIEW)
#extension GL_EXT_multiview : require
uint dplViewIndex(uint viewCount) { return uint(gl_ViewIndex); }
uint dplQuadSplat(uint viewCount) { return uint(gl_VertexIndex) / 6u; }
#elif defined(DPL_VIEW_INSTANCES)
// One view or two: a CPU that plays a GPU divides by a variable lane by lane.
uint dplViewIndex(uint viewCount) { return uint(gl_VertexIndex) / 6u & (viewCount - 1u); }
uint dplQuadSplat(uint viewCount) { return uint(gl_VertexIndex) / 6u >> (viewCount - 1u); }
#else
#error "build this shader with DPL_VIEW_MULTIVIEW or DPL_VIEW_INSTANCES"
#endif
// Two triangles a quad: an instance of four vertices would leave half of an eight-lane vertex shader idle, and cost lavapipe a draw each.
uint dplCorner() {
    uint vertex = uint(gl_VertexIndex) % 6u;
    return vertex < 3u ? vertex : vertex == 5u ? 3u : 5u - vertex;
}
