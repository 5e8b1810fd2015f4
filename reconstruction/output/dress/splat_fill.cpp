// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/dress/splat_fill.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "reconstruction/subject/shape/spread_place.h"
#include "reconstruction/subject/surface/body_places.h"
#include "reconstruction/training/trainer/init.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr int kMostSmoothings = 2000;   // of filled colours
constexpr float kSmoothEnough = 1e-4f;  // largest change in a round, of 1: a fortieth of a grey level
constexpr float kOpacity = 0.9f;        // of filled splats; they overlap
constexpr float kSpacings = 0.8f;       // standard deviation of a filled splat over the spacing of splats
constexpr double kWeakShare = 0.33;     // of the median coverage, below which a garment's triangle is filled

/** Splats for each square metre of the trusted triangles; 0 if they have none. areas: m², of the triangles. */
double splatDensity(const LayerPart& part, std::span<const double> areas, const Marks& distrusted) {
    double splats = 0, area = 0;
    for (size_t t = 0; t < distrusted.size(); ++t) {
        const uint32_t count = part.splats.triangleStart[t + 1] - part.splats.triangleStart[t];
        if (!distrusted[t] && count > 0) splats += count, area += areas[t];
    }
    return area > 0 ? splats / area : 0;
}

/** Appends `count` splats of one colour to a triangle, at evenly spread places. */
void fillTriangle(const Vec3f& colour, double area, uint32_t count, uint8_t flags, SplatData& splats) {
    for (uint32_t k = 0; k < count; ++k) {
        splats.uv.push_back(Vec2f(spreadPlace(1.0 / 3, k)));
        splats.phi.push_back(0);
        splats.scaleM.push_back(Vec2f(std::max(2e-4f, kSpacings * float(std::sqrt(area / count)))));
        splats.opacity.push_back(kOpacity);
        splats.flags.push_back(flags);
        const size_t first = splats.sh.size();
        splats.sh.resize(first + 3 * size_t(shCoefficientCount(splats.shDegree)), 0.0f);
        for (int c = 0; c < 3; ++c) splats.sh[first + size_t(c)] = (colour[c] - 0.5f) / float(kShC0);
    }
}

/** kSplatSingleFace where a triangle's splats show one side: as training set it, which knew hair and backs that show. Triangles without
 *  splats take what the shape alone tells, and hair shows both sides. */
Marks faceFlags(const LayerPart& part) {
    const SplatData& s = part.splats;
    Marks flags = part.role == "hair" ? Marks(part.mesh.triangles.size(), 0)
                                      : triangleFlags(part.mesh.restPositions, part.mesh.triangles, {}, {}, {});
    for (size_t t = 0; t < flags.size(); ++t)
        if (s.triangleStart[t] < s.triangleStart[t + 1]) flags[t] = s.flags[s.triangleStart[t]] & kSplatSingleFace;
    return flags;
}

/** 1 for vertices of a triangle whose splats stay: their colours stay too. */
Marks verticesThatStay(const LayerPart& part, const Marks& fill, const Marks& empty) {
    Marks kept(part.mesh.restPositions.size(), 0);
    for (size_t t = 0; t < fill.size(); ++t) {
        if (fill[t] || empty[t] || part.splats.triangleStart[t] == part.splats.triangleStart[t + 1]) continue;
        for (int k = 0; k < 3; ++k) kept[part.mesh.triangles[t][k]] = 1;
    }
    return kept;
}

void copySplats(const SplatData& from, size_t begin, size_t end, SplatData& to) {
    const auto add = [&](auto& into, const auto& values, size_t width) {
        into.insert(into.end(), values.begin() + long(begin * width), values.begin() + long(end * width));
    };
    add(to.uv, from.uv, 1), add(to.phi, from.phi, 1), add(to.scaleM, from.scaleM, 1), add(to.opacity, from.opacity, 1);
    add(to.flags, from.flags, 1), add(to.sh, from.sh, 3 * size_t(shCoefficientCount(from.shDegree)));
}

}  // namespace

std::vector<Vec4f> splatColours(const LayerPart& part) {
    const SplatData& s = part.splats;
    std::vector<Vec4f> out(part.mesh.triangles.size(), Vec4f(0));
    for (size_t t = 0; t < out.size(); ++t)
        for (uint32_t i = s.triangleStart[t]; i < s.triangleStart[t + 1]; ++i) {
            const float* sh = &s.sh[i * 3 * size_t(shCoefficientCount(s.shDegree))];
            const Vec3f colour = glm::clamp(0.5f + float(kShC0) * Vec3f(sh[0], sh[1], sh[2]), 0.0f, 1.0f);
            out[t] += s.opacity[i] * s.scaleM[i].x * s.scaleM[i].y * Vec4f(colour, 1.0f);
        }
    return out;
}

std::vector<Vec3f> coloursAround(const LayerPart& part, const Marks& distrusted, const Neighbours& neighbours) {
    std::vector<Vec4f> weighted = splatColours(part);
    for (size_t t = 0; t < weighted.size(); ++t)
        if (distrusted[t]) weighted[t] = Vec4f(0);
    std::vector<Vec3f> out = spreadColours(weighted, neighbours);
    // Until each is the mean of its neighbours: then a wide area, such as a neck between face and chest, is one gradient without a seam.
    float change = 1;
    for (int round = 0; round < kMostSmoothings && change > kSmoothEnough; ++round) {
        std::vector<Vec3f> next = out;
        change = 0;
        for (size_t t = 0; t < distrusted.size(); ++t) {
            if (!distrusted[t] || neighbours[t].empty()) continue;
            Vec3f sum(0);
            for (const uint32_t other : neighbours[t]) sum += out[other];
            next[t] = sum / float(neighbours[t].size());
            const Vec3f moved = glm::abs(next[t] - out[t]);
            change = std::max({change, moved.x, moved.y, moved.z});
        }
        out = std::move(next);
    }
    return out;
}

uint32_t fillSplats(const Marks& fill, const Marks& empty, const Marks& distrusted, std::span<const Vec3f> around, LayerPart& part) {
    const std::vector<double> areas = restAreas(part.mesh);
    const double splatsPerM2 = splatDensity(part, areas, distrusted);
    const Marks flags = faceFlags(part);
    uint8_t kind = 0;  // cloth or not: as the part's other splats
    for (const uint8_t flag : part.splats.flags) kind |= flag & kSplatCloth;
    SplatData splats;
    splats.shDegree = part.splats.shDegree;
    splats.triangleStart = {0};
    uint32_t filled = 0;
    const Marks kept = verticesThatStay(part, fill, empty);
    for (size_t t = 0; t < fill.size(); ++t) {
        const double area = areas[t];
        if (fill[t] && splatsPerM2 > 0 && area > 0) {
            ++filled;
            fillTriangle(around[t], area, uint32_t(std::max(1.0, std::round(area * splatsPerM2))), uint8_t(flags[t] | kind), splats);
            for (int k = 0; k < 3; ++k)
                if (const uint32_t v = part.mesh.triangles[t][k]; !kept[v])
                    part.mesh.colours[v] = glm::u8vec4(glm::u8vec3(glm::round(around[t] * 255.0f)), 255);
        } else if (!empty[t] && !fill[t]) {
            copySplats(part.splats, part.splats.triangleStart[t], part.splats.triangleStart[t + 1], splats);
        }
        splats.triangleStart.push_back(splats.count());
    }
    part.splats = std::move(splats);
    return filled;
}

Marks grown(Marks marked, const Neighbours& neighbours, int rings) {
    for (int ring = 0; ring < rings; ++ring) {
        Marks next = marked;
        for (size_t t = 0; t < marked.size(); ++t)
            if (marked[t])
                for (const uint32_t other : neighbours[t]) next[other] = 1;
        marked = std::move(next);
    }
    return marked;
}

uint32_t mendGarment(const Marks& uncovered, LayerPart& garment) {
    const SplatData& s = garment.splats;
    const size_t count = garment.mesh.triangles.size();
    const Neighbours neighbours = triangleNeighbours(garment.mesh);
    const std::vector<double> area = restAreas(garment.mesh);
    std::vector<double> mass(count, 0), coverage(count);
    for (size_t t = 0; t < count; ++t)
        for (uint32_t i = s.triangleStart[t]; i < s.triangleStart[t + 1]; ++i)
            mass[t] += 2 * std::numbers::pi * double(s.opacity[i] * s.scaleM[i].x * s.scaleM[i].y);
    for (size_t t = 0; t < count; ++t) {  // over the neighbourhood, because splats reach across edges
        double m = mass[t], a = area[t];
        for (const uint32_t other : neighbours[t]) m += mass[other], a += area[other];
        coverage[t] = a > 0 ? m / a : 0;
    }
    std::vector<double> sorted = coverage;
    std::nth_element(sorted.begin(), sorted.begin() + long(count / 2), sorted.end());
    const Marks inner = triangleFlags(garment.mesh.restPositions, garment.mesh.triangles, {}, {}, {});
    Marks weak(count), fill(count);  // not at hems, where cloth may end before its mesh
    for (size_t t = 0; t < count; ++t) {
        weak[t] = (inner[t] & kSplatSingleFace) && coverage[t] < kWeakShare * sorted[count / 2];
        fill[t] = weak[t] && uncovered[t];
    }
    return fillSplats(fill, Marks(count, 0), weak, coloursAround(garment, weak, neighbours), garment);
}

}  // namespace dpl
