// SPDX-License-Identifier: Apache-2.0
// The buffers that the engine keeps between frames, and the functions that fill them. Private to sdk/splat.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "sdk/splat/splat_engine.h"

namespace dpl {

/** A growing array that never zero-fills and never shrinks, so a warm frame allocates and clears nothing. */
template <class T>
class Scratch {
public:
    /** The content is undefined afterwards. */
    T* resize(size_t count) {
        if (count > capacity_) {
            capacity_ = count + count / 4;
            data_ = std::unique_ptr<T[]>(new T[capacity_]);
        }
        size_ = count;
        return data_.get();
    }
    /** Keeps the content. */
    T* grow(size_t count) {
        if (count > capacity_ && size_ > 0) {
            const std::unique_ptr<T[]> old = std::move(data_);
            const size_t kept = size_;
            resize(count);
            std::copy_n(old.get(), kept, data_.get());
        }
        return resize(count);
    }
    T* data() { return data_.get(); }
    const T* data() const { return data_.get(); }
    size_t size() const { return size_; }
    size_t bytes() const { return capacity_ * sizeof(T); }
    T& operator[](size_t i) { return data_[i]; }
    const T& operator[](size_t i) const { return data_[i]; }

private:
    std::unique_ptr<T[]> data_;
    size_t size_ = 0, capacity_ = 0;
};

/** Tiles that a splat may touch, both ends included. */
struct TileBox {
    uint16_t x0, y0, x1, y1;
};

constexpr uint32_t kProjectBlock = 4096;  // splats a block of projection; fixed, so that results do not depend on the thread count

/** Visible splats of block b: keys[b·kProjectBlock .. + count) hold the bits of their depths, in splat order. */
struct BlockVisible {
    uint32_t count = 0, minKey = 0xffffffffu, maxKey = 0;
    uint64_t tileEntries = 0;                     // splat-tile pairs
    uint64_t decidedBytes = 0, decodedBytes = 0;  // SplatEngine::decidedBytes, decodedBytes
};

/** A triangle in one view, as its splats read it: eight quads of four floats, which the kernel loads as such. Metres of the world, but for
 *  rest0 to rest2. */
struct alignas(32) TriangleView {
    float v0[3], planeDot;  // first corner in view space; n·(eye − v0)
    float e1[3], shown;     // edges in view space; opacity factor of the splats, 0 for a triangle that is not drawn
    float e2[3], light0;    // light0: brightness at the first corner
    float f0[3], light1;    // columns of F in view space; light1: brightness at the second corner minus light0
    float f1[3], light2;    // light2: the same for the third corner
    float rest0[3], pad0;   // v0 − eye, turned into the rest frame; metres of the subject
    float rest1[3], pad1;   // edges, turned into the rest frame
    float rest2[3], pad2;
};
static_assert(sizeof(TriangleView) == 128);

struct SplatEngine::Buffers {
    uint32_t widthPx = 0, heightPx = 0, splatCount = 0, visibleCount = 0;
    bool sortedFrame = false;  // sort() has run since project()
    uint32_t samples = 1;      // a pixel
    Scratch<TriangleView> triangles;
    Scratch<uint8_t> parentShows;           // kShows... flags, one an entry of CodedSplats::parents
    Scratch<ProjectedSplat> projected;      // splatCount, padded to whole packed groups
    Scratch<ForwardRecord<float>> records;  // the same size when the frame is recorded, else empty
    Scratch<TileBox> boxes;
    std::vector<BlockVisible> blocks;
    Scratch<uint32_t> keys[2], values[2];
    uint32_t* sorted = nullptr;  // visible splats, near first; points into values
    std::vector<uint32_t> histogram;
    Scratch<TileBox> sortedBoxes;  // boxes in depth order
    Scratch<uint32_t> tileCounts;  // tiles × workers
    TileLists tiles;
    Scratch<uint32_t> stops;
    Scratch<float> stopTransmittance;
};

/** How a set of splats is seen: what SplatEngine::project() is given besides the splats. */
struct SplatCamera {
    SubjectView view;
    float kappaPx2;  // of a pixel
    bool compensated;
    uint32_t samples = 1;  // a pixel; anything but kCoverageSamples counts as 1
};

void projectBound(Jobs& jobs, SplatEngine::Buffers& buffers, const BoundSplatView& splats, std::span<const TriangleFrame<float>> triangles,
                  const SplatCamera& seen, bool record);
void projectStatic(Jobs& jobs, SplatEngine::Buffers& buffers, const StaticSplatData& splats, const SplatCamera& seen);
// behind: appends to the splats already projected with this camera instead of replacing them.
void projectCoded(Jobs& jobs, SplatEngine::Buffers& buffers, const CodedSplats& splats, std::span<const TriangleFrame<float>> triangles,
                  const SplatCamera& seen, const SplatDetail& detail, bool behind);
void projectPacked(Jobs& jobs, SplatEngine::Buffers& buffers, const PackedSplats& splats, std::span<const TriangleFrame<float>> triangles,
                   const SplatCamera& seen, const KeptGroups& kept, bool behind);
void sortByDepth(Jobs& jobs, SplatEngine::Buffers& buffers);
void binIntoTiles(Jobs& jobs, SplatEngine::Buffers& buffers);
void blendTiles(Jobs& jobs, SplatEngine::Buffers& buffers, SplatImage& image, const BlendOptions& options);
void blendTilesRgba8(Jobs& jobs, SplatEngine::Buffers& buffers, std::vector<uint8_t>& rgba, std::vector<float>* depthM,
                     std::span<const float> sceneDepthM);

}  // namespace dpl
