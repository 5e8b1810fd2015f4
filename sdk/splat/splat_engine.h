// The CPU splat engine: project, sort, bin, blend. Forward only; it is the software renderer and the trainer's forward pass.
// One engine serves one thread at a time and keeps its buffers between frames, so a warm frame allocates nothing.
//
//   splats + triangle frames ─► project (SIMD, blocks of splats) ─► stable sort by depth ─► bin into 16×16 tiles ─► blend front to back
//
// Results do not depend on the thread count: blocks have a fixed shape and each tile is blended by one worker in splat order.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"
#include "sdk/math/binding.h"
#include "sdk/math/camera.h"
#include "sdk/math/projection.h"

namespace dpl {

constexpr uint32_t kTileSizePx = 16;

/** Splats bound to triangles, structure of arrays, borrowed for the call. All spans have one entry a splat except sh. */
struct BoundSplatView {
    std::span<const uint32_t> triangle;
    std::span<const Vec2f> uv;
    std::span<const float> phi;
    std::span<const Vec2f> scaleM;
    std::span<const float> opacity;
    std::span<const uint8_t> flags;
    uint32_t shDegree = 0;
    std::span<const float> sh;             // coefficient-major, (degree+1)²·3 a splat
    uint32_t count() const { return uint32_t(triangle.size()); }
};

/** One projected splat as binning and blending read it; 64 bytes, one cache line. Invisible ones have opacity 0. */
struct alignas(64) ProjectedSplat {
    float x, y;                        // centre, target pixels, pixel centres at +0.5
    float conicA, conicB, conicC;      // σ = ½(A dx² + C dy²) + B dx dy
    float opacity;                     // after compensation, gate and near fade
    float red, green, blue;            // clamped to [0,1]
    float radiusX, radiusY;            // half extents of the box outside which α < 1/255
    float depthM;                      // view z
    float compensation;                // for the backward pass
    float fade;                        // gate · nearFade, for the backward pass
    uint32_t splat;                    // index in the input
    float cloth;                       // 1 when kSplatCloth is set, else 0
};
static_assert(sizeof(ProjectedSplat) == 64);

/** Output image; premultiplied, float, row-major, top row first. Buffers are resized by blend(). */
struct SplatImage {
    uint32_t widthPx = 0, heightPx = 0;
    std::vector<float> rgb;      // 3 a pixel, premultiplied by coverage, display-referred
    std::vector<float> alpha;    // 1 − T
    std::vector<float> cloth;    // Σ α T over cloth splats (only when asked for)
    std::vector<float> depthM;   // Σ α T z / Σ α T, 0 where alpha is 0 (only when asked for)
};

/** Depth-ordered tile lists: entries of tile k are [offset[k], offset[k+1]) in `entries`, indices into projected(). */
struct TileLists {
    uint32_t columns = 0, rows = 0;
    std::vector<uint32_t> offset;
    std::vector<uint32_t> entries;
};

struct BlendOptions {
    bool cloth = false;
    bool depth = false;
    bool recordStops = false;   // the trainer wants to know where each pixel stopped
};

class SplatEngine {
public:
    explicit SplatEngine(Jobs& jobs);
    ~SplatEngine();

    /** Projects every bound splat into `camera`. triangles: one frame a triangle of the avatar, world space. */
    void project(const BoundSplatView& splats, std::span<const TriangleFrame<float>> triangles, const Cameraf& camera, float kappaPx2);
    /** Projects general splats (full 3×3 covariance, no gate). */
    void project(const StaticSplatData& splats, const Cameraf& camera, float kappaPx2);

    /** Stable sort by view depth, then tile lists. After project(). */
    void bin();

    /** Blends all tiles into `image` over transparent black. After bin(). */
    void blend(SplatImage& image, const BlendOptions& options = {});

    std::span<const ProjectedSplat> projected() const;
    const TileLists& tiles() const;
    /** Per pixel: one past the last entry of its tile list that was blended. Only after blend with recordStops. */
    std::span<const uint32_t> stops() const;
    uint64_t bufferBytes() const;

private:
    struct Buffers;
    Jobs& jobs_;
    std::unique_ptr<Buffers> buffers_;
};

}  // namespace dpl
