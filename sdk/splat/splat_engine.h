// SPDX-License-Identifier: Apache-2.0
// The CPU splat engine: project, sort, bin, blend. Forward only; it is the software renderer and the trainer's forward pass.
// One engine serves one thread at a time and keeps its buffers between frames, so a warm frame allocates nothing.
//
//   splats + triangle frames ─► project (SIMD, blocks of splats) ─► stable sort by depth ─► bin into 16×16 tiles ─► blend front to back
//
// Stopping rule, the same in the referee, the trainer and every renderer: an entry is blended while the pixel's T is above 1e-4, and
// the entry that brings T to 1e-4 or below is still blended. All later entries together weigh less than 1e-4, so a renderer that stops
// later, or never, differs by less than 1e-4. Stopping before that entry would lose up to 1e-2.
//
// Results do not depend on the thread count: blocks have a fixed shape and each tile is blended by one worker in splat order.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/coded_splats.h"
#include "sdk/format/splat_detail.h"
#include "sdk/math/binding.h"
#include "sdk/math/camera.h"
#include "sdk/math/coverage.h"
#include "sdk/math/detail.h"
#include "sdk/math/projection.h"
#include "sdk/splat/forward_record.h"
#include "sdk/splat/packed_splats.h"

namespace dpl {

constexpr uint32_t kTileSizePx = 16;
constexpr uint32_t kMaxTargetPx = 32768;  // wider or higher targets give an empty image of size 0

/** One projected splat as binning and blending read it; 64 bytes, one cache line. Invisible ones have opacity 0; the rest of theirs may
 *  hold anything. */
struct alignas(64) ProjectedSplat {
    float x, y;                    // centre, target pixels, pixel centres at +0.5
    float conicA, conicB, conicC;  // σ = ½(A dx² + C dy²) + B dx dy
    float opacity;                 // after compensation, gate and near fade
    float red, green, blue;        // clamped to [0,1]
    float radiusX, radiusY;        // half extents of the box outside which α < 1/255
    float depthM;                  // view z
    float inverseVarianceY;        // 1/Σ'yy: σ = ½(A (dx + B/A dy)² + dy²/Σ'yy) does not cancel as A dx² + 2B dx dy + C dy² does
    uint32_t splat;                // index in the input
    float cloth;                   // 1 when kSplatCloth is set, else 0
    float pad0;
};
static_assert(sizeof(ProjectedSplat) == 64);

/** Output image; premultiplied, float, row-major, top row first. Buffers are resized by blend(). */
struct SplatImage {
    uint32_t widthPx = 0, heightPx = 0;
    std::vector<float> rgb;     // 3 a pixel, premultiplied by coverage, display-referred
    std::vector<float> alpha;   // 1 − T
    std::vector<float> cloth;   // Σ α T over cloth splats (only when asked for)
    std::vector<float> depthM;  // Σ α T z / Σ α T, 0 where alpha is 0 (only when asked for)
};

/** Depth-ordered tile lists: entries of tile k are [offset[k], offset[k+1]) in `entries`, indices into projected().
 *  `entries` keeps its size between frames: offset.back() is the count in use. */
struct TileLists {
    uint32_t columns = 0, rows = 0;
    std::vector<uint32_t> offset;
    std::vector<uint32_t> entries;
};

struct BlendOptions {
    bool cloth = false;
    bool depth = false;
    bool recordStops = false;                 // the trainer wants to know where each pixel stopped; with one sample a pixel only
    std::span<const float> sceneDepthM = {};  // one a pixel: splats behind it add nothing there (sdk/math/scene_depth.h); empty: no scene
};

class SplatEngine {
public:
    explicit SplatEngine(Jobs& jobs);
    ~SplatEngine();

    /** Projects every bound splat into `camera`. triangles: one frame a triangle of the avatar, world space. Splats of invalid
     *  frames, of triangle indices out of range and with non-finite numbers are invisible. compensated: AvatarData::compensated.
     *  record: fill forwardRecords(), for a backward pass. */
    void project(const BoundSplatView& splats, std::span<const TriangleFrame<float>> triangles, const Cameraf& camera, float kappaPx2,
                 bool compensated = true, bool record = false);
    /** Projects general splats (full 3×3 covariance, no gate). compensated: energy-preserving low-pass as for bound splats; plain
     *  3D Gaussian splatting files were trained without. Arrays shorter than count() is a caller's mistake. */
    void project(const StaticSplatData& splats, const Cameraf& camera, float kappaPx2, bool compensated = false);

    /** The same for splats that were packed before: faster, for sets that do not change. `triangles` is for bound ones, else empty.
     *  samples: 1 or kCoverageSamples. With more than 1, blending composites at that many positions of a pixel, each with its share of
     *  kappaPx2, and takes their mean (sdk/math/coverage.h). groups: of general splats, in their order; empty: all are drawn. */
    void project(const PackedSplats& splats, std::span<const TriangleFrame<float>> triangles, const Cameraf& camera, float kappaPx2,
                 bool compensated, uint32_t samples = 1, const GeneralDetail& detail = {}, std::span<const GeneralGroup> groups = {});
    /** Bound splats as the file codes them: 16 bytes a splat and the SH entries stay in memory, and only splats whose triangle the view
     *  may show are decoded. The others have opacity 0 in projected(). detail needs splats.groups; with it projected() holds the kept
     *  splats densely from each multiple of 4096 on. */
    void project(const CodedSplats& splats, std::span<const TriangleFrame<float>> triangles, const Cameraf& camera, float kappaPx2,
                 bool compensated, uint32_t samples = 1, const SplatDetail& detail = {});
    /** Projects more splats into the same picture, after a project() with the same camera and samples. All are sorted and blended
     *  together. Their indices into projected() begin at the next multiple of 4096; ties in depth keep the order of the calls. */
    void add(const CodedSplats& splats, std::span<const TriangleFrame<float>> triangles, const Cameraf& camera, float kappaPx2,
             bool compensated, uint32_t samples = 1, const SplatDetail& detail = {});
    void add(const PackedSplats& splats, std::span<const TriangleFrame<float>> triangles, const Cameraf& camera, float kappaPx2,
             bool compensated, uint32_t samples = 1, const GeneralDetail& detail = {}, std::span<const GeneralGroup> groups = {});
    /** Bytes of codes read since the last project(): to decide what may show, and to decode it. */
    uint64_t decidedBytes() const;
    uint64_t decodedBytes() const;

    /** Stable sort by view depth, ties by index. Optional: bin() sorts when this was not called. */
    void sort();
    /** Stable sort by view depth, then tile lists. After project(). */
    void bin();

    /** Blends all tiles into `image` over transparent black. After bin(). */
    void blend(SplatImage& image, const BlendOptions& options = {});

    /** Blends straight to premultiplied RGBA8 (what a viewer wants; a third of the memory traffic). rgba is resized to 4 a pixel;
     *  depthM, when not null, to one a pixel, as in SplatImage; sceneDepthM as in BlendOptions. After bin(). */
    void blendRgba8(std::vector<uint8_t>& rgba, std::vector<float>* depthM = nullptr, std::span<const float> sceneDepthM = {});

    std::span<const ProjectedSplat> projected() const;
    /** One a splat of the last project() that recorded, else empty. Those of splats that are not shown hold anything. */
    std::span<const ForwardRecord<float>> forwardRecords() const;
    const TileLists& tiles() const;
    /** Per pixel, row-major: one past the last entry that was blended, as an index into tiles().entries (tiles().offset of the
     *  pixel's tile when nothing was). Only after blend with recordStops. */
    std::span<const uint32_t> stops() const;
    /** Per pixel: T after the last blended entry, ≥ 1e-6; more precise than 1 − alpha. Only after blend with recordStops. */
    std::span<const float> stopTransmittance() const;
    /** Splats that the last view shows. After sort() or bin(). */
    uint32_t visibleCount() const;
    /** Bytes held between frames. */
    uint64_t bufferBytes() const;

    struct Buffers;  // private to sdk/splat

private:
    Jobs& jobs_;
    std::unique_ptr<Buffers> buffers_;
};

}  // namespace dpl
