// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/shape/implicit_mesh.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "reconstruction/shape/vertex_sets.h"

namespace dpl {
namespace {

constexpr int kBlock = 6;              // cells per side of a block; blocks far from the surface are skipped
constexpr float kSlopeMargin = 1.35f;  // how much faster than the true distance the field may grow

struct GridValues {
    std::vector<float> values;  // kUnknown where not evaluated
    size_t nx, ny, nz;
    size_t index(size_t x, size_t y, size_t z) const { return (z * ny + y) * nx + x; }
};
constexpr float kUnknown = 1e9f;

// The six tetrahedra around the diagonal 0-7 of a cell (corner bits x=1, y=2, z=4), all with the same orientation.
constexpr int kTetrahedra[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};

}  // namespace

void appendSamples(std::vector<float>& samples, float from, float to, float step) {
    const int count = std::max(1, int(std::ceil((to - from) / step - 1e-4f)));
    for (int i = samples.empty() ? 0 : 1; i <= count; ++i) samples.push_back(from + (to - from) * float(i) / float(count));
}

SurfaceMesh marchField(const ScalarField& field, const SampleGrid& grid, Jobs& jobs) {
    GridValues g;
    g.nx = grid.xs.size(), g.ny = grid.ys.size(), g.nz = grid.zs.size();
    g.values.assign(g.nx * g.ny * g.nz, kUnknown);
    const size_t bx = (g.nx - 2) / kBlock + 1, by = (g.ny - 2) / kBlock + 1, bz = (g.nz - 2) / kBlock + 1;
    std::vector<uint8_t> active(bx * by * bz, 0);
    auto corner = [&](size_t x, size_t y, size_t z) {
        return Vec3f(grid.xs[std::min(x, g.nx - 1)], grid.ys[std::min(y, g.ny - 1)], grid.zs[std::min(z, g.nz - 1)]);
    };
    jobs.forBlocks(active.size(), [&](size_t b, uint32_t) {
        const size_t x = b % bx, y = b / bx % by, z = b / bx / by;
        const Vec3f low = corner(x * kBlock, y * kBlock, z * kBlock), high = corner((x + 1) * kBlock, (y + 1) * kBlock, (z + 1) * kBlock);
        active[b] = std::abs(field(0.5f * (low + high))) < kSlopeMargin * 0.5f * glm::length(high - low) + 1e-4f;
    });
    // Each grid plane of constant z is written by one job only.
    jobs.forBlocks(g.nz, [&](size_t z, uint32_t) {
        const size_t zb = std::min(z / kBlock, bz - 1), zBefore = z % kBlock == 0 && z > 0 ? std::min((z - 1) / kBlock, bz - 1) : zb;
        for (size_t y = 0; y < g.ny; ++y) {
            const size_t yb = std::min(y / kBlock, by - 1), yBefore = y % kBlock == 0 && y > 0 ? (y - 1) / kBlock : yb;
            for (size_t x = 0; x < g.nx; ++x) {
                const size_t xb = std::min(x / kBlock, bx - 1), xBefore = x % kBlock == 0 && x > 0 ? (x - 1) / kBlock : xb;
                bool wanted = false;
                for (size_t k : {zBefore, zb})
                    for (size_t j : {yBefore, yb})
                        for (size_t i : {xBefore, xb}) wanted |= active[(k * by + j) * bx + i] != 0;
                if (wanted) g.values[g.index(x, y, z)] = field({grid.xs[x], grid.ys[y], grid.zs[z]});
            }
        }
    });

    SurfaceMesh mesh;
    std::unordered_map<uint64_t, uint32_t> vertexOfEdge;
    vertexOfEdge.reserve(1u << 18);
    auto vertexOn = [&](size_t a, size_t b, const Vec3f& pa, const Vec3f& pb) {
        const bool ordered = a < b;
        const uint64_t key = ordered ? uint64_t(a) << 32 | b : uint64_t(b) << 32 | a;
        auto [it, fresh] = vertexOfEdge.try_emplace(key, uint32_t(mesh.positions.size()));
        if (fresh) {
            const size_t first = ordered ? a : b, second = ordered ? b : a;
            const float va = g.values[first], vb = g.values[second];
            const float t = std::clamp(va / (va - vb), 0.06f, 0.94f);  // avoids slivers; remesh() moves vertices onto the surface
            mesh.positions.push_back(ordered ? pa + (pb - pa) * t : pb + (pa - pb) * t);
        }
        return it->second;
    };
    for (size_t b = 0; b < active.size(); ++b) {
        if (!active[b]) continue;
        const size_t x0 = b % bx * kBlock, y0 = b / bx % by * kBlock, z0 = b / bx / by * kBlock;
        for (size_t z = z0; z < std::min(z0 + kBlock, g.nz - 1); ++z)
            for (size_t y = y0; y < std::min(y0 + kBlock, g.ny - 1); ++y)
                for (size_t x = x0; x < std::min(x0 + kBlock, g.nx - 1); ++x) {
                    size_t id[8];
                    Vec3f at[8];
                    int insideCount = 0;
                    for (int c = 0; c < 8; ++c) {
                        const size_t cx = x + (c & 1), cy = y + (c >> 1 & 1), cz = z + (c >> 2);
                        id[c] = g.index(cx, cy, cz);
                        at[c] = {grid.xs[cx], grid.ys[cy], grid.zs[cz]};
                        insideCount += g.values[id[c]] < 0;
                    }
                    if (insideCount == 0 || insideCount == 8) continue;
                    for (const auto& tet : kTetrahedra) {
                        int in[4], out[4], inCount = 0, outCount = 0;
                        for (int c : tet) (g.values[id[c]] < 0 ? in[inCount++] : out[outCount++]) = c;
                        if (inCount == 0 || outCount == 0) continue;
                        auto on = [&](int p, int q) { return vertexOn(id[p], id[q], at[p], at[q]); };
                        // The normal must point away from the inside corners.
                        Vec3f away(0);
                        for (int i = 0; i < outCount; ++i) away += at[out[i]] / float(outCount);
                        for (int i = 0; i < inCount; ++i) away -= at[in[i]] / float(inCount);
                        auto emit = [&](uint32_t p, uint32_t q, uint32_t r) {
                            const Vec3f n = glm::cross(mesh.positions[q] - mesh.positions[p], mesh.positions[r] - mesh.positions[p]);
                            if (glm::dot(n, away) >= 0)
                                mesh.triangles.push_back({p, q, r});
                            else
                                mesh.triangles.push_back({p, r, q});
                        };
                        if (inCount == 1)
                            emit(on(in[0], out[0]), on(in[0], out[1]), on(in[0], out[2]));
                        else if (outCount == 1)
                            emit(on(in[0], out[0]), on(in[1], out[0]), on(in[2], out[0]));
                        else {
                            const uint32_t p = on(in[0], out[0]), q = on(in[0], out[1]), r = on(in[1], out[1]), s = on(in[1], out[0]);
                            emit(p, q, r);
                            emit(p, r, s);
                        }
                    }
                }
    }
    return mesh;
}

SurfaceMesh withoutUnused(const SurfaceMesh& mesh, std::vector<uint32_t>* oldIndex) {
    std::vector<uint32_t> newIndex(mesh.positions.size(), UINT32_MAX);
    for (const Triangle& t : mesh.triangles) newIndex[t.x] = newIndex[t.y] = newIndex[t.z] = 0;
    SurfaceMesh out;
    if (oldIndex) oldIndex->clear();
    for (uint32_t v = 0; v < newIndex.size(); ++v) {
        if (newIndex[v] == UINT32_MAX) continue;
        newIndex[v] = uint32_t(out.positions.size());
        out.positions.push_back(mesh.positions[v]);
        if (oldIndex) oldIndex->push_back(v);
    }
    for (const Triangle& t : mesh.triangles) out.triangles.push_back({newIndex[t.x], newIndex[t.y], newIndex[t.z]});
    return out;
}

SurfaceMesh largestPiece(const SurfaceMesh& mesh) {
    VertexSets pieces(mesh.positions.size(), mesh.triangles);
    std::vector<size_t> size(mesh.positions.size(), 0);
    for (const Triangle& t : mesh.triangles) ++size[pieces.find(t.x)];
    const uint32_t best = uint32_t(std::max_element(size.begin(), size.end()) - size.begin());
    SurfaceMesh kept;
    kept.positions = mesh.positions;
    for (const Triangle& t : mesh.triangles)
        if (pieces.find(t.x) == best) kept.triangles.push_back(t);
    return withoutUnused(kept);
}

std::vector<Vec3f> vertexNormals(std::span<const Vec3f> positions, std::span<const Triangle> triangles) {
    std::vector<Vec3f> normals(positions.size(), Vec3f(0));
    for (const Triangle& t : triangles) {
        const Vec3f n = glm::cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]);
        normals[t.x] += n, normals[t.y] += n, normals[t.z] += n;
    }
    for (Vec3f& n : normals) {
        const float length = glm::length(n);
        n = length > 0 ? n / length : Vec3f(0, 1, 0);
    }
    return normals;
}

std::vector<std::vector<uint32_t>> vertexNeighbours(size_t vertexCount, const std::vector<Triangle>& triangles) {
    std::vector<std::vector<uint32_t>> neighbours(vertexCount);
    for (const Triangle& t : triangles)
        for (int c = 0; c < 3; ++c) {
            neighbours[t[c]].push_back(t[(c + 1) % 3]);
            neighbours[t[c]].push_back(t[(c + 2) % 3]);
        }
    for (auto& list : neighbours) {
        std::sort(list.begin(), list.end());
        list.erase(std::unique(list.begin(), list.end()), list.end());
    }
    return neighbours;
}

}  // namespace dpl
