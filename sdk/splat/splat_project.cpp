// SPDX-License-Identifier: Apache-2.0
// Projection: splats in, ProjectedSplat + tile box + depth key out, in blocks of kProjectBlock splats.
#include <algorithm>
#include <cmath>

#include "sdk/splat/coded_groups.h"
#include "sdk/splat/project_kernel.h"

namespace dpl {
namespace {

constexpr uint32_t kPackAhead = 64;  // splats packed or decoded at a time: 15 KB at SH degree 3, which fits the L1 cache

ProjectView viewOf(const SplatCamera& seen) {
    const Cameraf& camera = seen.view.camera;
    const Mat3f turn = seen.view.viewFromSubject();
    const uint32_t samples = seen.samples == kCoverageSamples ? kCoverageSamples : 1;
    ProjectView v;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) v.rotation[r * 3 + c] = turn[c][r];
    const JacobianClamp<float> limit(camera);
    const Vec3f eye = camera.eye();
    const Vec3f translation = seen.view.scale * camera.viewFromWorldTranslation;
    for (int k = 0; k < 3; ++k) v.translation[k] = translation[k], v.eye[k] = eye[k];
    v.fx = camera.fx, v.fy = camera.fy, v.cx = camera.cx, v.cy = camera.cy;
    v.widthPx = camera.widthPx, v.heightPx = camera.heightPx;
    v.width = float(camera.widthPx), v.height = float(camera.heightPx);
    v.minX = limit.minX, v.maxX = limit.maxX, v.minY = limit.minY, v.maxY = limit.maxY;
    v.kappaPx2 = seen.kappaPx2 / float(samples);
    v.reachPx = samples > 1 ? kCoverageReachPx : 0;
    v.samples = samples;
    v.compensated = seen.compensated;
    return v;
}

void store(float* out, const Vec3f& v) {
    out[0] = v.x, out[1] = v.y, out[2] = v.z;
}

/** One record for each triangle. Behind the last one lies an invalid one, so the result is never null. */
std::span<const TriangleView> viewTriangles(Jobs& jobs, Scratch<TriangleView>& scratch, std::span<const TriangleFrame<float>> triangles,
                                            const SubjectView& view) {
    TriangleView* out = scratch.resize(triangles.size() + 1);
    out[triangles.size()] = TriangleView{};
    const Vec3f eye = view.camera.eye();
    const Mat3f turn = view.viewFromSubject();
    jobs.forRange(triangles.size(), 4096, [&](size_t begin, size_t end, uint32_t) {
        for (size_t i = begin; i < end; ++i) {
            const TriangleFrame<float>& t = triangles[i];
            TriangleView r{};
            if (t.valid) {
                const Mat3f restFromWorld = glm::transpose(t.worldFromRest);
                r.shown = t.shown;
                r.planeDot = view.scale * glm::dot(t.normal, eye - t.v0);
                store(r.v0, view.toView(t.v0));
                store(r.e1, turn * (t.v1 - t.v0)), store(r.e2, turn * (t.v2 - t.v0));
                store(r.f0, turn * t.f0), store(r.f1, turn * t.f1);
                store(r.rest0, restFromWorld * (t.v0 - eye));
                r.light0 = t.light.x, r.light1 = t.light.y - t.light.x, r.light2 = t.light.z - t.light.x;
                store(r.rest1, restFromWorld * (t.v1 - t.v0)), store(r.rest2, restFromWorld * (t.v2 - t.v0));
            }
            out[i] = r;
        }
    });
    return {out, triangles.size()};
}

/** Makes entries [splatCount, end) of projected() invisible. */
void hideTail(SplatEngine::Buffers& buffers, size_t end) {
    ProjectedSplat* projected = buffers.projected.grow(end);
    for (size_t i = buffers.splatCount; i < end; ++i) projected[i].opacity = 0;
}

/** One set of splats to project, and where its results go. */
struct ProjectInput {
    uint32_t count = 0, shDegree = 0;
    std::span<const TriangleView> triangles = {};  // without the invalid one behind them; data() is null for general splats
    bool behind = false;                           // after the splats projected so far, else instead of them
    bool record = false;                           // fill SplatEngine::forwardRecords()
};

/** Sizes the buffers, then runs body(task) for each block of splats; all of the task but `packed` is set. */
template <class Body>
void forProjectBlocks(Jobs& jobs, SplatEngine::Buffers& buffers, const ProjectView& view, const ProjectInput& input, Body&& body) {
    const auto allowed = [](uint32_t size) { return size > 0 && size <= kMaxTargetPx; };
    const bool drawable = allowed(view.widthPx) && allowed(view.heightPx);
    buffers.widthPx = drawable ? view.widthPx : 0, buffers.heightPx = drawable ? view.heightPx : 0;
    const uint32_t count = drawable ? input.count : 0;
    // The kernel writes whole packed groups, so there is room for the padding of the last one.
    const size_t before = input.behind ? buffers.blocks.size() : 0, first = before * kProjectBlock,
                 padded = first + groupCount(count) * kGroupSplats;
    if (input.behind) hideTail(buffers, first);
    buffers.projected.grow(padded), buffers.boxes.grow(padded);
    buffers.records.resize(input.record ? padded : 0);
    buffers.keys[0].grow(padded), buffers.values[0].grow(padded);
    buffers.splatCount = uint32_t(first) + count;
    buffers.sortedFrame = false;
    buffers.samples = view.samples;
    buffers.blocks.resize(before + (count + kProjectBlock - 1) / kProjectBlock);
    jobs.forRange(count, kProjectBlock, [&](size_t begin, size_t end, uint32_t) {
        BlockVisible visible;
        ProjectTask task{&view,
                         nullptr,
                         uint32_t(groupCount(end - begin)),
                         uint32_t(begin),
                         input.shDegree,
                         input.triangles.data(),
                         uint32_t(input.triangles.size()),
                         uint32_t(first),
                         buffers.projected.data() + first,
                         input.record ? buffers.records.data() + first : nullptr,
                         buffers.boxes.data() + first,
                         buffers.keys[0].data() + first + begin,
                         buffers.values[0].data() + first + begin,
                         &visible};
        body(task);
        buffers.blocks[before + begin / kProjectBlock] = visible;
    });
}

constexpr uint8_t kShowsFree = 1, kShowsGated = 2;  // free splats of a triangle may show; its single-face splats may show

/** Which kinds of splats of the triangle `view` may show, as flags. Tests the corners of the parallelogram in which (u, v) codes place
 *  splats (sdk/math/formulas/cull.inl). Leaves a flag out only if the kernel would hide every such splat. scaleMaxM: largest standard
 *  deviation at rest. */
uint8_t showsOf(const ProjectView& view, const TriangleView& t, float scaleMaxM) {
    using F = Formulas<float>;
    if (!(t.shown > 0)) return 0;
    constexpr float kLow = float((0 - kUvZero) / kUvSteps), kHigh = float((2047 - kUvZero) / kUvSteps);
    constexpr float kRootLevel = 3.33f;  // √(2 ln 255), for opacity 1
    const F::Lens lens{{view.fx, view.fy}, {view.cx, view.cy}, {view.minX, view.minY}, {view.maxX, view.maxY}};
    const auto vectorOf = [](const float* xyz) { return Vec3f(xyz[0], xyz[1], xyz[2]); };
    const float reachM = kRootLevel * scaleMaxM * F::largestStretch(vectorOf(t.f0), vectorOf(t.f1)) * 1.0001f;  // the factor: rounding
    const F::CullMargin margin = F::cullMargin(lens, reachM, kRootLevel, view.kappaPx2, 1 + view.reachPx);
    const auto sides = [&](float u, float v) {
        return F::cullSides(lens, margin, {view.width, view.height}, F::barycentric(vectorOf(t.v0), vectorOf(t.e1), vectorOf(t.e2), u, v));
    };
    if (!F::mayShow(
            F::eitherSides(F::eitherSides(sides(kLow, kLow), sides(kHigh, kLow)), F::eitherSides(sides(kLow, kHigh), sides(kHigh, kHigh)))))
        return 0;
    return t.planeDot > 0 ? kShowsFree | kShowsGated : kShowsFree;  // the gate is exactly 0 at planeDot ≤ 0
}

/** Decodes and projects the packed groups of a block in which any splat may show, a few groups at a time. */
void projectBlockOfCodes(const CodedSplats& splats, const uint8_t* shows, ProjectTask task) {
    alignas(64) float packed[kPackAhead / kGroupSplats * kMaxGroupFloats];
    const size_t groupFloats = size_t(groupFields(true, task.shDegree)) * kGroupSplats;
    const uint32_t end = std::min(task.firstSplat + task.groups * kGroupSplats, splats.count());
    // place, size and colour: 4 bytes each; parent: 1
    const uint64_t splatBytes = 13 + (splats.shIndex.empty() ? 0 : 2) + (splats.shDegree ? shEntryBytes(splats.shDegree) : 0);
    CodedGroups groups(splats, task.firstSplat);
    size_t chunk = size_t(std::upper_bound(splats.chunks.begin(), splats.chunks.end(), task.firstSplat,
                                           [](uint32_t i, const SplatChunk& c) { return i < c.firstSplat; }) -
                          splats.chunks.begin()) -
                   1;
    task.packed = packed;
    task.groups = 0;
    const auto flush = [&] {
        if (task.groups > 0) projectGroups(task);
        task.groups = 0;
    };
    for (uint32_t first = task.firstSplat; first < end; first += kGroupSplats) {
        const uint32_t lanes = std::min(kGroupSplats, end - first);
        bool shown = false;
        for (uint32_t i = first; i < first + lanes; ++i) {
            if (i >= splats.chunks[chunk].firstSplat + splats.chunks[chunk].splatCount) ++chunk;
            if (shown) continue;
            const uint8_t show = shows[splats.chunks[chunk].firstParent + splats.parent[i]];
            task.visible->decidedBytes += show == kShowsFree ? 5 : 1;  // parent: 1 byte; size, for the single-face bit: 4
            shown = show == (kShowsFree | kShowsGated) || (show == kShowsFree && (splats.size[i] >> 30 & 1) == 0);
        }
        if (!shown) {
            flush();
            for (uint32_t i = first; i < first + lanes; ++i) task.projected[i].opacity = 0;
            continue;
        }
        if (task.groups == kPackAhead / kGroupSplats) flush();
        if (task.groups == 0) task.firstSplat = first;
        groups.decode(first, packed + task.groups++ * groupFloats);
        task.visible->decodedBytes += lanes * splatBytes;
    }
    flush();
}

/** As projectBlockOfCodes, for the splats that level of detail keeps. They fill the entries of the block from its start, in order. The
 *  other entries are made invisible. */
void projectChosenOfCodes(const CodedSplats& splats, const uint8_t* shows, const SplatDetail& detail, ProjectTask task) {
    alignas(64) float packed[kPackAhead / kGroupSplats * kMaxGroupFloats];
    CodedGroups groups(splats, task.firstSplat, detail.shShare);
    task.shDegree = groups.shDegree();
    const size_t groupFloats = size_t(groupFields(true, task.shDegree)) * kGroupSplats;
    const uint32_t begin = task.firstSplat, end = std::min(begin + task.groups * kGroupSplats, splats.count());
    // place, size and colour: 4 bytes each; parent: 1
    const uint64_t splatBytes = 13 + (splats.shIndex.empty() ? 0 : 2) + (task.shDegree ? shEntryBytes(splats.shDegree) : 0);
    task.packed = packed;
    task.groups = 0;
    uint32_t next = begin;  // next free entry of projected()
    ChosenSplat chosen[kGroupSplats];
    uint32_t chosenCount = 0;
    const auto flush = [&] {
        if (task.groups > 0) projectGroups(task);
        task.groups = 0;
    };
    const auto put = [&] {
        if (chosenCount == 0) return;
        if (task.groups == kPackAhead / kGroupSplats) flush();
        if (task.groups == 0) task.firstSplat = next;
        groups.decode({chosen, chosenCount}, packed + task.groups++ * groupFloats);
        task.visible->decodedBytes += chosenCount * splatBytes;
        next += chosenCount, chosenCount = 0;
    };
    size_t chunk = size_t(std::upper_bound(splats.chunks.begin(), splats.chunks.end(), begin,
                                           [](uint32_t i, const SplatChunk& c) { return i < c.firstSplat; }) -
                          splats.chunks.begin()) -
                   1;
    for (size_t g = 2 * chunk; g < splats.groups.size(); ++g) {
        const SplatChunk& c = splats.chunks[g / 2];
        const uint32_t first = c.firstSplat + g % 2 * kSplatGroupSize,
                       last = std::min(first + kSplatGroupSize, c.firstSplat + c.splatCount);
        if (first >= end) break;
        if (first >= last || last <= begin) continue;
        const float share = keptShare(detail.perM2, splats.groups[g].areaM2),
                    growth = detailGrowth(share, splats.groups[g].gain, splats.groups[g].enough);
        float weight[kSplatGroupSize] = {};
        for (uint32_t rank = 0, drawn = drawnRanks(share); rank < drawn; ++rank) weight[placeOfRank(rank)] = detailWeight(share, rank);
        for (uint32_t i = std::max(first, begin); i < std::min(last, end); ++i) {
            if (!(weight[i - first] > 0)) continue;
            const uint8_t show = shows[c.firstParent + splats.parent[i]];
            task.visible->decidedBytes += show == kShowsFree ? 5 : 1;  // parent: 1 byte; size, for the single-face bit: 4
            if (show == 0 || (show == kShowsFree && (splats.size[i] >> 30 & 1) != 0)) continue;
            chosen[chosenCount++] = {i, weight[i - first], growth};
            if (chosenCount == kGroupSplats) put();
        }
    }
    put();
    flush();
    for (uint32_t i = next; i < end; ++i) task.projected[i].opacity = 0;
}

/** Projects the general splats that level of detail keeps. Groups that are kept whole are read in place; the kept splats of other groups
 *  are gathered into packed groups. They fill the block's entries densely from its start; the other entries are made invisible. */
void projectChosenOfPacked(const PackedSplats& splats, std::span<const GeneralGroup> groups, const GeneralDetail& detail,
                           ProjectTask task) {
    using namespace static_field;
    static_assert(kProjectBlock % kSplatGroupSize == 0 && kSplatGroupSize % kGroupSplats == 0);
    alignas(64) float packed[kMaxGroupFloats];
    const uint32_t fields = groupFields(false, splats.shDegree()), begin = task.firstSplat,
                   end = std::min(begin + task.groups * kGroupSplats, splats.count());
    const auto groupAt = [&](uint32_t splat) { return splats.data() + size_t(splat / kGroupSplats) * fields * kGroupSplats; };
    uint32_t next = begin, lanes = 0;  // next free entry of projected(); splats gathered so far
    const auto put = [&] {
        if (lanes == 0) return;
        for (uint32_t f = 0; f < fields; ++f) std::fill(packed + f * kGroupSplats + lanes, packed + (f + 1) * kGroupSplats, 0.0f);
        task.packed = packed, task.groups = 1, task.firstSplat = next;
        projectGroups(task);
        next += kGroupSplats, lanes = 0;
    };
    for (uint32_t first = begin; first < end; first += kSplatGroupSize) {
        const GeneralGroup& group = groups[first / kSplatGroupSize];
        const uint32_t count = std::min(kSplatGroupSize, end - first);
        const float pixelM = detail.pixelM(group.middle, group.reach),
                    share = keptShare(detail.perPixel, group.detail.areaM2 / (pixelM * pixelM));
        if (share >= 1) {
            put();
            task.packed = groupAt(first), task.groups = uint32_t(groupCount(count)), task.firstSplat = next;
            projectGroups(task);
            next += task.groups * kGroupSplats;
            continue;
        }
        const float growth = detailGrowth(share, group.detail.gain, group.detail.enough);
        float weight[kSplatGroupSize] = {};
        for (uint32_t rank = 0, drawn = drawnRanks(share); rank < drawn; ++rank) weight[placeOfRank(rank)] = detailWeight(share, rank);
        for (uint32_t place = 0; place < count; ++place) {
            if (!(weight[place] > 0)) continue;
            const float* from = groupAt(first + place) + place % kGroupSplats;
            for (uint32_t f = 0; f < fields; ++f) packed[f * kGroupSplats + lanes] = from[f * kGroupSplats];
            for (uint32_t f = kAxes; f < kOpacity; ++f) packed[f * kGroupSplats + lanes] *= growth;
            packed[kOpacity * kGroupSplats + lanes] *= weight[place];
            if (++lanes == kGroupSplats) put();
        }
    }
    put();
    for (uint32_t i = next; i < end; ++i) task.projected[i].opacity = 0;
}

/** Packs a few splats at a time, so that they stay in the worker's cache, and projects them. */
template <class Splats>
void projectUnpacked(const Splats& splats, ProjectTask task) {
    alignas(64) float packed[kPackAhead / kGroupSplats * kMaxGroupFloats];
    const size_t groupFloats = size_t(groupFields(task.triangles != nullptr, task.shDegree)) * kGroupSplats;
    uint32_t left = task.groups;
    task.packed = packed;
    while (left > 0) {
        task.groups = std::min(left, kPackAhead / kGroupSplats);
        for (uint32_t g = 0; g < task.groups; ++g) packGroup(splats, task.firstSplat + g * kGroupSplats, packed + g * groupFloats);
        projectGroups(task);
        task.firstSplat += task.groups * kGroupSplats;
        left -= task.groups;
    }
}

}  // namespace

void projectBound(Jobs& jobs, SplatEngine::Buffers& buffers, const BoundSplatView& splats, std::span<const TriangleFrame<float>> triangles,
                  const SplatCamera& seen, bool record) {
    const auto posed = viewTriangles(jobs, buffers.triangles, triangles, seen.view);
    forProjectBlocks(jobs, buffers, viewOf(seen), {usableCount(splats), splats.shDegree, posed, /*behind=*/false, record},
                     [&](const ProjectTask& task) { projectUnpacked(splats, task); });
}

void projectStatic(Jobs& jobs, SplatEngine::Buffers& buffers, const StaticSplatData& splats, const SplatCamera& seen) {
    forProjectBlocks(jobs, buffers, viewOf(seen), {usableCount(splats), splats.shDegree},
                     [&](const ProjectTask& task) { projectUnpacked(splats, task); });
}

void projectCoded(Jobs& jobs, SplatEngine::Buffers& buffers, const CodedSplats& splats, std::span<const TriangleFrame<float>> triangles,
                  const SplatCamera& seen, const SplatDetail& detail, bool behind) {
    const ProjectView view = viewOf(seen);
    const auto posed = viewTriangles(jobs, buffers.triangles, triangles, seen.view);
    const bool all = detail.full() || splats.groups.empty();
    uint8_t* shows = buffers.parentShows.resize(splats.parents.size());
    jobs.forRange(splats.chunks.size(), 16, [&](size_t begin, size_t end, uint32_t) {
        for (size_t c = begin; c < end; ++c) {
            float growth = 1;
            for (size_t g = 2 * c; g < 2 * c + 2 && !all; ++g)
                growth = std::max(
                    growth, detailGrowth(keptShare(detail.perM2, splats.groups[g].areaM2), splats.groups[g].gain, splats.groups[g].enough));
            const float largestM = growth * splats.chunks[c].scaleMaxM;
            const size_t parentsEnd = c + 1 < splats.chunks.size() ? splats.chunks[c + 1].firstParent : splats.parents.size();
            for (size_t p = splats.chunks[c].firstParent; p < parentsEnd; ++p)
                shows[p] = showsOf(view, posed.data()[std::min<size_t>(splats.parents[p], posed.size())], largestM);
        }
    });
    forProjectBlocks(jobs, buffers, view, {splats.count(), splats.shDegree, posed, behind}, [&](const ProjectTask& task) {
        if (all)
            projectBlockOfCodes(splats, shows, task);
        else
            projectChosenOfCodes(splats, shows, detail, task);
    });
}

void projectPacked(Jobs& jobs, SplatEngine::Buffers& buffers, const PackedSplats& splats, std::span<const TriangleFrame<float>> triangles,
                   const SplatCamera& seen, const KeptGroups& kept, bool behind) {
    const auto posed = splats.bound() ? viewTriangles(jobs, buffers.triangles, triangles, seen.view) : std::span<const TriangleView>();
    const size_t groupFloats = size_t(groupFields(splats.bound(), splats.shDegree())) * kGroupSplats;
    const bool all = kept.detail.full() || kept.groups.empty() || splats.bound();
    forProjectBlocks(jobs, buffers, viewOf(seen), {splats.count(), splats.shDegree(), posed, behind}, [&](ProjectTask task) {
        if (!all) return projectChosenOfPacked(splats, kept.groups, kept.detail, task);
        task.packed = splats.data() + task.firstSplat / kGroupSplats * groupFloats;
        projectGroups(task);
    });
}

}  // namespace dpl
