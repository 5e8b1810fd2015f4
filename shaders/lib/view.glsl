// The only place that knows how a draw reaches several views. Mono is stereo with one view.
//   DPL_VIEW_MULTIVIEW  one draw reaches all of them, target layer = view (VK_KHR_multiview, core in 1.1)
//   otherwise           a draw a view, into its layer
#ifdef DPL_VIEW_MULTIVIEW
#extension GL_EXT_multiview : require
uint dplViewIndex(uint view) { return uint(gl_ViewIndex); }
#else
uint dplViewIndex(uint view) { return view; }
#endif
// Two triangles a quad: an instance of four vertices would leave half of an eight-lane vertex shader idle, and cost lavapipe a draw each.
uint dplQuad() { return uint(gl_VertexIndex) / 6u; }
uint dplCorner() {
    uint vertex = uint(gl_VertexIndex) % 6u;
    return vertex < 3u ? vertex : vertex == 5u ? 3u : 5u - vertex;
}
