// SPDX-License-Identifier: Apache-2.0
// The CPU splat engine: the software renderer and the trainer's forward pass draw with it.
//
//   splats + triangle frames ─► project (SIMD, blocks of splats) ─► stable sort by depth ─► bin into 16×16 tiles ─► blend front to back
//
// Stopping rule of the referee, the trainer and every renderer: an entry is blended while the pixel's T is above 1e-4, so the entry that
// brings T to 1e-4 or below still counts. All later entries together weigh less than 1e-4, so a renderer that stops later, or never,
// differs by less than 1e-4. Stopping one entry earlier would lose up to 1e-2.
//
// An engine serves one thread at a time. It keeps its buffers between frames, so a warm frame allocates nothing. Results do not depend on
// the thread count: blocks have a fixed size, and one worker blends a tile in depth order.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sdk/core/jobs.h"
#include "sdk/draw/screen_splat.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/coded_splats.h"
#include "sdk/format/splat_detail.h"
#include "sdk/math/binding.h"
#include "sdk/math/camera.h"
#include "sdk/math/coverage.h"
#include "sdk/math/detail.h"
#include "sdk/math/placement.h"
#include "sdk/math/projection.h"
#include "sdk/splat/forward_record.h"
#include "sdk/splat/packed_splats.h"

namespace dpl {

constexpr uint32_t kTileSizePx = 16;
constexpr uint32_t kMaxTargetPx = 32768;  // wider or higher targets give an empty image of size 0

/** One projected splat as binning and blending read it; one cache line. Invisible splats have opacity 0 and undefined other members. */
struct alignas(64) ProjectedSplat {
    float x, y;                    // centre, target pixels, pixel centres at +0.5
    float conicA, conicB, conicC;  // σ = ½(A dx² + C dy²) + B dx dy
    float opacity;                 // after compensation, gate and near fade
    float red, green, blue;        // clamped to [0,1]
    float radiusX, radiusY;        // half extents of the box outside which α < 1/255
    float depthM;                  // view z
    float inverseVarianceY;        // 1/Σ'yy: σ = ½(A (dx + B/A dy)² + dy²/Σ'yy), which does not cancel for needles
    uint32_t splat;                // index in the input
    float cloth;                   // 1 when kSplatCloth is set, else 0
    float pad0;
};
static_assert(sizeof(ProjectedSplat) == 64);

/** Float image, row-major, top row first. blend() resizes it. */
struct SplatImage {
    uint32_t widthPx = 0, heightPx = 0;
    std::vector<float> rgb;     // 3 a pixel, premultiplied by coverage, display-referred
    std::vector<float> alpha;   // 1 − T
    std::vector<float> cloth;   // Σ α T over cloth splats; empty unless asked for
    std::vector<float> depthM;  // Σ α T z / Σ α T, 0 where alpha is 0; empty unless asked for
};

/** Depth-ordered lists: tile k has entries [offset[k], offset[k+1]), which are indices into projected(). Only offset.back() entries are in
 *  use: `entries` never shrinks. */
struct TileLists {
    uint32_t columns = 0, rows = 0;
    std::vector<uint32_t> offset;
    std::vector<uint32_t> entries;
};

/** Which general splats level of detail keeps. groups: those of the set, in packed order; empty: all splats are drawn. */
struct KeptGroups {
    GeneralDetail detail;
    std::span<const GeneralGroup> groups = {};
};

struct BlendOptions {
    bool cloth = false;
    bool depth = false;
    bool recordStops = false;                 // fill stops() and stopTransmittance(); only with one sample a pixel
    std::span<const float> sceneDepthM = {};  // one a pixel: hides splats behind it (sdk/math/scene_depth.h); empty: no scene
};

class SplatEngine {
public:
    explicit SplatEngine(Jobs& jobs);
    ~SplatEngine();

    /** Projects bound splats into `camera`. triangles: one frame for each triangle of the avatar, world space. Splats with an invalid
     * frame, a triangle index out of range or a number that is not finite are invisible. kappaPx2: low-pass variance of a pixel.
     * compensated: AvatarData::compensated. record: fill forwardRecords() for a backward pass. */
    void project(const BoundSplatView& splats, std::span<const TriangleFrame<float>> triangles, const Cameraf& camera, float kappaPx2,
                 bool compensated = true, bool record = false);
    /** Projects general splats (full 3×3 covariance, no gate). compensated: energy-preserving low-pass as for bound splats; plain 3D
     *  Gaussian splatting files were trained without it. Arrays of different lengths are an error in the log, and nothing is drawn. */
    void project(const StaticSplatData& splats, const Cameraf& camera, float kappaPx2, bool compensated = false);

    /** The same for packed splats: faster, for sets that do not change. triangles: for bound splats, else empty. view, and the triangles,
     * in the space of the subject; a camera of the world for one that stands at its origin. samples: 1 or kCoverageSamples; with more than
     * 1, blending composites at that many positions of a pixel, each with its share of kappaPx2, and averages them (sdk/math/coverage.h).
     * kept: of general splats. */
    void project(const PackedSplats& splats, std::span<const TriangleFrame<float>> triangles, const SubjectView& view, float kappaPx2,
                 bool compensated, uint32_t samples = 1, const KeptGroups& kept = {});
    /** Bound splats as the file codes them. Only splats whose triangle may show in the view are decoded; the others have opacity 0 in
     *  projected(). detail needs splats.groups; with level of detail, projected() holds the kept splats densely from each multiple of 4096
     *  on. */
    void project(const CodedSplats& splats, std::span<const TriangleFrame<float>> triangles, const SubjectView& view, float kappaPx2,
                 bool compensated, uint32_t samples = 1, const SplatDetail& detail = {});
    /** Adds splats to the picture, after project() with the same samples and the same camera in the world. All are sorted and blended
     * together. The new splats begin at the next multiple of 4096 in projected(); ties in depth keep the order of the calls. */
    void add(const CodedSplats& splats, std::span<const TriangleFrame<float>> triangles, const SubjectView& view, float kappaPx2,
             bool compensated, uint32_t samples = 1, const SplatDetail& detail = {});
    void add(const PackedSplats& splats, std::span<const TriangleFrame<float>> triangles, const SubjectView& view, float kappaPx2,
             bool compensated, uint32_t samples = 1, const KeptGroups& kept = {});
    /** Bytes of codes read since the last project(): to decide which splats may show, and to decode those. */
    uint64_t decidedBytes() const;
    uint64_t decodedBytes() const;

    /** Stable sort by view depth, ties by index. Optional: bin() sorts when this was not called. */
    void sort();
    /** Sorts unless sort() did, and makes the tile lists. After project(). When the lists would exceed 2²⁷ entries, only the nearest splats
     *  are drawn and a warning is logged. */
    void bin();

    /** Blends all tiles into `image` over transparent black. After bin(). */
    void blend(SplatImage& image, const BlendOptions& options = {});

    /** Blends to premultiplied RGBA8, with a third of the memory traffic of the float image. rgba is resized to 4 values a pixel; depthM,
     *  unless null, to one a pixel, as in SplatImage; sceneDepthM as in BlendOptions. After bin(). */
    void blendRgba8(std::vector<uint8_t>& rgba, std::vector<float>* depthM = nullptr, std::span<const float> sceneDepthM = {});

    /** Writes the visible splats, farthest first. After sort() or bin(). out: visibleCount() of them. */
    void writeSorted(std::span<ScreenSplat> out) const;

    std::span<const ProjectedSplat> projected() const;
    /** One for each splat when the last project() recorded, else empty. Undefined for splats that are not shown. */
    std::span<const ForwardRecord<float>> forwardRecords() const;
    const TileLists& tiles() const;
    /** Per pixel, row-major: one past the last blended entry, as an index into tiles().entries; where nothing was blended, the tile's
     *  tiles().offset. Only after blend() with recordStops. */
    std::span<const uint32_t> stops() const;
    /** Per pixel: T after the last blended entry, ≥ 1e-6; more precise than 1 − alpha. Only after blend() with recordStops. */
    std::span<const float> stopTransmittance() const;
    /** Number of visible splats. After sort() or bin(). */
    uint32_t visibleCount() const;
    /** Bytes held between frames. */
    uint64_t bufferBytes() const;

    struct Buffers;  // private to sdk/splat

private:
    Jobs& jobs_;
    std::unique_ptr<Buffers> buffers_;
};

}  // namespace dpl
