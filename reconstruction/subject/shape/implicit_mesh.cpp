// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/shape/implicit_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "reconstruction/subject/shape/vertex_sets.h"

namespace dpl {
namespace {

constexpr int kBlock = 6;              // cells per side of a block; blocks far from the surface are skipped
constexpr float kSlopeMargin = 1.35f;  // how much faster than the true distance the field may grow

constexpr float kUnknown = 1e9f;

/** The field at the corners of a grid, near its surface. */
struct FieldGrid {
    const SampleGrid& samples;
    size_t nx = samples.xs.size(), ny = samples.ys.size(), nz = samples.zs.size();
    size_t bx = (nx - 2) / kBlock + 1, by = (ny - 2) / kBlock + 1, bz = (nz - 2) / kBlock + 1;
    std::vector<float> values = std::vector<float>(nx * ny * nz, kUnknown);        // kUnknown where not evaluated
    std::vector<uint8_t> active = std::vector<uint8_t>(bx * by * bz, uint8_t(0));  // blocks that the surface may cross

    size_t index(size_t x, size_t y, size_t z) const { return (z * ny + y) * nx + x; }
    Vec3f at(size_t x, size_t y, size_t z) const { return {samples.xs[x], samples.ys[y], samples.zs[z]}; }
};

FieldGrid evaluate(const ScalarField& field, const SampleGrid& grid, Jobs& jobs) {
    FieldGrid g{grid};
    const auto corner = [&](size_t x, size_t y, size_t z) {
        return g.at(std::min(x, g.nx - 1), std::min(y, g.ny - 1), std::min(z, g.nz - 1));
    };
    jobs.forBlocks(g.active.size(), [&](size_t b, uint32_t) {
        const size_t x = b % g.bx, y = b / g.bx % g.by, z = b / g.bx / g.by;
        const Vec3f low = corner(x * kBlock, y * kBlock, z * kBlock), high = corner((x + 1) * kBlock, (y + 1) * kBlock, (z + 1) * kBlock);
        g.active[b] = std::abs(field(0.5f * (low + high))) < kSlopeMargin * 0.5f * glm::length(high - low) + 1e-4f;
    });
    // Each grid plane of constant z is written by one job only.
    jobs.forBlocks(g.nz, [&](size_t z, uint32_t) {
        const size_t zb = std::min(z / kBlock, g.bz - 1), zBefore = z % kBlock == 0 && z > 0 ? std::min((z - 1) / kBlock, g.bz - 1) : zb;
        for (size_t y = 0; y < g.ny; ++y) {
            const size_t yb = std::min(y / kBlock, g.by - 1), yBefore = y % kBlock == 0 && y > 0 ? (y - 1) / kBlock : yb;
            for (size_t x = 0; x < g.nx; ++x) {
                const size_t xb = std::min(x / kBlock, g.bx - 1), xBefore = x % kBlock == 0 && x > 0 ? (x - 1) / kBlock : xb;
                bool wanted = false;
                for (size_t k : {zBefore, zb})
                    for (size_t j : {yBefore, yb})
                        for (size_t i : {xBefore, xb}) wanted |= g.active[(k * g.by + j) * g.bx + i] != 0;
                if (wanted) g.values[g.index(x, y, z)] = field(g.at(x, y, z));
            }
        }
    });
    return g;
}

// The six tetrahedra around the diagonal 0-7 of a cell (corner bits x=1, y=2, z=4), all with the same orientation.
constexpr int kTetrahedra[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};

/** The surface through the cells of a grid, cell by cell. */
class Tetrahedra {
public:
    explicit Tetrahedra(const FieldGrid& grid) : grid_(grid) { vertexOfEdge_.reserve(1u << 18); }

    void addCell(size_t x, size_t y, size_t z) {
        Corner corners[8];
        int insideCount = 0;
        for (int c = 0; c < 8; ++c) {
            const size_t cx = x + (c & 1), cy = y + (c >> 1 & 1), cz = z + (c >> 2);
            corners[c] = {grid_.index(cx, cy, cz), grid_.at(cx, cy, cz)};
            insideCount += isInside(corners[c]);
        }
        if (insideCount == 0 || insideCount == 8) return;
        for (const auto& t : kTetrahedra) addTetrahedron({&corners[t[0]], &corners[t[1]], &corners[t[2]], &corners[t[3]]});
    }
    SurfaceMesh take() { return std::move(mesh_); }

private:
    struct Corner {
        size_t id;
        Vec3f at;
    };
    const FieldGrid& grid_;
    SurfaceMesh mesh_;
    std::unordered_map<uint64_t, uint32_t> vertexOfEdge_;

    bool isInside(const Corner& corner) const { return grid_.values[corner.id] < 0; }

    uint32_t vertexBetween(const Corner& a, const Corner& b) {
        const Corner &first = a.id < b.id ? a : b, &second = a.id < b.id ? b : a;
        auto [it, fresh] = vertexOfEdge_.try_emplace(uint64_t(first.id) << 32 | second.id, uint32_t(mesh_.positions.size()));
        if (fresh) {
            const float va = grid_.values[first.id], vb = grid_.values[second.id];
            const float t = std::clamp(va / (va - vb), 0.06f, 0.94f);  // avoids slivers; remesh() moves vertices onto the surface
            mesh_.positions.push_back(first.at + (second.at - first.at) * t);
        }
        return it->second;
    }

    void addTetrahedron(const std::array<const Corner*, 4>& corners) {
        const Corner *in[4], *out[4];
        int inCount = 0, outCount = 0;
        for (const Corner* c : corners) (isInside(*c) ? in[inCount++] : out[outCount++]) = c;
        if (inCount == 0 || outCount == 0) return;
        const auto on = [&](int i, int o) { return vertexBetween(*in[i], *out[o]); };
        // The normal must point away from the inside corners.
        Vec3f away(0);
        for (int i = 0; i < outCount; ++i) away += out[i]->at / float(outCount);
        for (int i = 0; i < inCount; ++i) away -= in[i]->at / float(inCount);
        const auto emit = [&](uint32_t p, uint32_t q, uint32_t r) {
            const Vec3f n = glm::cross(mesh_.positions[q] - mesh_.positions[p], mesh_.positions[r] - mesh_.positions[p]);
            if (glm::dot(n, away) >= 0)
                mesh_.triangles.push_back({p, q, r});
            else
                mesh_.triangles.push_back({p, r, q});
        };
        if (inCount == 1)
            emit(on(0, 0), on(0, 1), on(0, 2));
        else if (outCount == 1)
            emit(on(0, 0), on(1, 0), on(2, 0));
        else {
            const uint32_t p = on(0, 0), q = on(0, 1), r = on(1, 1), s = on(1, 0);
            emit(p, q, r);
            emit(p, r, s);
        }
    }
};

}  // namespace

void appendSamples(std::vector<float>& samples, float from, float to, float step) {
    const int count = std::max(1, int(std::ceil((to - from) / step - 1e-4f)));
    for (int i = samples.empty() ? 0 : 1; i <= count; ++i) samples.push_back(from + (to - from) * float(i) / float(count));
}

SurfaceMesh marchField(const ScalarField& field, const SampleGrid& grid, Jobs& jobs) {
    const FieldGrid g = evaluate(field, grid, jobs);
    Tetrahedra tetrahedra(g);
    for (size_t b = 0; b < g.active.size(); ++b) {
        if (!g.active[b]) continue;
        const size_t x0 = b % g.bx * kBlock, y0 = b / g.bx % g.by * kBlock, z0 = b / g.bx / g.by * kBlock;
        for (size_t z = z0; z < std::min(z0 + kBlock, g.nz - 1); ++z)
            for (size_t y = y0; y < std::min(y0 + kBlock, g.ny - 1); ++y)
                for (size_t x = x0; x < std::min(x0 + kBlock, g.nx - 1); ++x) tetrahedra.addCell(x, y, z);
    }
    return tetrahedra.take();
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
