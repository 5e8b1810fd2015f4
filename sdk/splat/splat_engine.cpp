// SPDX-License-Identifier: Apache-2.0
#include "sdk/splat/splat_engine.h"

#include "sdk/splat/buffers.h"

namespace dpl {

SplatEngine::SplatEngine(Jobs& jobs) : jobs_(jobs), buffers_(std::make_unique<Buffers>()) {}
SplatEngine::~SplatEngine() = default;

void SplatEngine::project(const BoundSplatView& splats, std::span<const TriangleFrame<float>> triangles, const Cameraf& camera,
                          float kappaPx2, bool compensated, bool record) {
    projectBound(jobs_, *buffers_, splats, triangles, {camera, kappaPx2, compensated}, record);
}

void SplatEngine::project(const StaticSplatData& splats, const Cameraf& camera, float kappaPx2, bool compensated) {
    projectStatic(jobs_, *buffers_, splats, {camera, kappaPx2, compensated});
}

void SplatEngine::project(const CodedSplats& splats, std::span<const TriangleFrame<float>> triangles, const SubjectView& view,
                          float kappaPx2, bool compensated, uint32_t samples, const SplatDetail& detail) {
    projectCoded(jobs_, *buffers_, splats, triangles, {view, kappaPx2, compensated, samples}, detail, /*behind=*/false);
}

void SplatEngine::project(const PackedSplats& splats, std::span<const TriangleFrame<float>> triangles, const SubjectView& view,
                          float kappaPx2, bool compensated, uint32_t samples, const KeptGroups& kept) {
    projectPacked(jobs_, *buffers_, splats, triangles, {view, kappaPx2, compensated, samples}, kept, /*behind=*/false);
}

void SplatEngine::add(const CodedSplats& splats, std::span<const TriangleFrame<float>> triangles, const SubjectView& view, float kappaPx2,
                      bool compensated, uint32_t samples, const SplatDetail& detail) {
    projectCoded(jobs_, *buffers_, splats, triangles, {view, kappaPx2, compensated, samples}, detail, /*behind=*/true);
}

void SplatEngine::add(const PackedSplats& splats, std::span<const TriangleFrame<float>> triangles, const SubjectView& view, float kappaPx2,
                      bool compensated, uint32_t samples, const KeptGroups& kept) {
    projectPacked(jobs_, *buffers_, splats, triangles, {view, kappaPx2, compensated, samples}, kept, /*behind=*/true);
}

void SplatEngine::sort() {
    sortByDepth(jobs_, *buffers_);
}

void SplatEngine::bin() {
    if (!buffers_->sortedFrame) sort();
    binIntoTiles(jobs_, *buffers_);
}

void SplatEngine::blend(SplatImage& image, const BlendOptions& options) {
    blendTiles(jobs_, *buffers_, image, options);
}

void SplatEngine::blendRgba8(std::vector<uint8_t>& rgba, std::vector<float>* depthM, std::span<const float> sceneDepthM) {
    blendTilesRgba8(jobs_, *buffers_, rgba, depthM, sceneDepthM);
}

void SplatEngine::writeSorted(std::span<ScreenSplat> out) const {
    constexpr size_t kGrain = 4096;
    const ProjectedSplat* projected = buffers_->projected.data();
    const uint32_t* sorted = buffers_->sorted;
    const auto unorm16 = [](float x) { return uint16_t(std::clamp(x, 0.f, 1.f) * 65535 + 0.5f); };
    jobs_.forRange(out.size(), kGrain, [&](size_t begin, size_t end, uint32_t) {
        for (size_t i = begin; i < end; ++i) {
            const ProjectedSplat& p = projected[sorted[out.size() - 1 - i]];
            out[i] = {p.x,
                      p.y,
                      p.depthM,
                      p.conicA,
                      p.conicB / p.conicA,
                      p.inverseVarianceY,
                      unorm16(p.red),
                      unorm16(p.green),
                      unorm16(p.blue),
                      unorm16(p.opacity)};
        }
    });
}

std::span<const ProjectedSplat> SplatEngine::projected() const {
    return {buffers_->projected.data(), buffers_->splatCount};
}
std::span<const ForwardRecord<float>> SplatEngine::forwardRecords() const {
    return {buffers_->records.data(), std::min<size_t>(buffers_->records.size(), buffers_->splatCount)};
}
const TileLists& SplatEngine::tiles() const {
    return buffers_->tiles;
}
std::span<const uint32_t> SplatEngine::stops() const {
    return {buffers_->stops.data(), buffers_->stops.size()};
}
std::span<const float> SplatEngine::stopTransmittance() const {
    return {buffers_->stopTransmittance.data(), buffers_->stopTransmittance.size()};
}

uint32_t SplatEngine::visibleCount() const {
    return buffers_->visibleCount;
}

uint64_t SplatEngine::decidedBytes() const {
    uint64_t bytes = 0;
    for (const BlockVisible& block : buffers_->blocks) bytes += block.decidedBytes;
    return bytes;
}

uint64_t SplatEngine::decodedBytes() const {
    uint64_t bytes = 0;
    for (const BlockVisible& block : buffers_->blocks) bytes += block.decodedBytes;
    return bytes;
}

uint64_t SplatEngine::bufferBytes() const {
    const Buffers& b = *buffers_;
    return b.triangles.bytes() + b.parentShows.bytes() + b.sortedBoxes.bytes() + b.projected.bytes() + b.records.bytes() + b.boxes.bytes() +
           b.blocks.capacity() * sizeof(BlockVisible) + b.keys[0].bytes() + b.keys[1].bytes() + b.values[0].bytes() + b.values[1].bytes() +
           b.histogram.capacity() * sizeof(uint32_t) + b.tileCounts.bytes() + b.tiles.offset.capacity() * sizeof(uint32_t) +
           b.tiles.entries.capacity() * sizeof(uint32_t) + b.stops.bytes() + b.stopTransmittance.bytes();
}

}  // namespace dpl
