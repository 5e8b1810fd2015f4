// SPDX-License-Identifier: Apache-2.0
// Turns a garment pattern into a sheet: mesh the whole solid, cut it along the hem, move its border onto the hem line, remesh.
#include <algorithm>
#include <cmath>
#include <map>

#include "reconstruction/subject/sample/garments.h"

namespace dpl {
namespace {

/** Gradient by finite differences. */
Vec3f slope(const ScalarField& f, const Vec3f& p) {
    constexpr float h = 8e-4f;
    const Vec3f a(h, -h, -h), b(-h, -h, h), c(-h, h, -h), d(h, h, h);
    return (a * f(p + a) + b * f(p + b) + c * f(p + c) + d * f(p + d)) / (4 * h * h);
}

/** Moves p to the hem line, where `keep` and `field` are both 0. Steps are at most 6 mm. */
Vec3f ontoHem(const GarmentPattern& g, Vec3f p) {
    for (int i = 0; i < 10; ++i) {
        for (const ScalarField* f : {&g.keep, &g.field}) {
            const Vec3f n = slope(*f, p);
            const float n2 = glm::dot(n, n);
            if (n2 < 1e-3f) continue;
            Vec3f step = n * ((*f)(p) / n2);
            const float length = glm::length(step);
            if (length > 0.006f) step *= 0.006f / length;
            p -= step;
        }
    }
    return p;
}

/** The next vertex along the border, per border vertex. `tangled` receives the vertices at which borders touch. */
std::map<uint32_t, uint32_t> borderLoops(const SurfaceMesh& mesh, std::vector<uint32_t>& tangled) {
    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    for (const Triangle& t : mesh.triangles)
        for (int c = 0; c < 3; ++c) edges[{t[c], t[(c + 1) % 3]}] = 1;
    std::map<uint32_t, uint32_t> next;
    tangled.clear();
    for (const auto& [edge, one] : edges)
        if (!edges.contains({edge.second, edge.first}) && !next.try_emplace(edge.first, edge.second).second) tangled.push_back(edge.first);
    return next;
}

/** Removes triangles until no vertex lies on two borders. */
void dropTangles(SurfaceMesh& mesh) {
    std::vector<uint32_t> tangled;
    for (int round = 0; round < 20; ++round) {
        borderLoops(mesh, tangled);
        if (tangled.empty()) return;
        std::erase_if(mesh.triangles, [&](const Triangle& t) {
            for (uint32_t v : tangled)
                if (t.x == v || t.y == v || t.z == v) return true;
            return false;
        });
    }
}

/** Closes small border loops with triangle fans. The cut leaves such holes where a fold touches the hem line from inside. */
void healPinholes(SurfaceMesh& mesh) {
    constexpr size_t kPinholeEdges = 20;  // every real opening has more than 40
    std::vector<uint32_t> tangled;
    auto next = borderLoops(mesh, tangled);
    while (!next.empty()) {
        std::vector<uint32_t> loop;
        for (uint32_t v = next.begin()->first; next.contains(v);) {
            loop.push_back(v);
            const uint32_t to = next[v];
            next.erase(v);
            v = to;
        }
        if (loop.size() > kPinholeEdges) continue;
        Vec3f centre(0);
        for (uint32_t v : loop) centre += mesh.positions[v] / float(loop.size());
        const uint32_t hub = uint32_t(mesh.positions.size());
        mesh.positions.push_back(centre);
        for (size_t i = 0; i < loop.size(); ++i) mesh.triangles.push_back({loop[(i + 1) % loop.size()], loop[i], hub});
    }
}

/** Removes triangles with two or three border edges, which make a hem ragged. */
void dropEars(SurfaceMesh& mesh) {
    for (int round = 0; round < 3; ++round) {
        std::map<std::pair<uint32_t, uint32_t>, int> edges;
        for (const Triangle& t : mesh.triangles)
            for (int c = 0; c < 3; ++c) edges[{t[c], t[(c + 1) % 3]}] = 1;
        const size_t before = mesh.triangles.size();
        std::erase_if(mesh.triangles, [&](const Triangle& t) {
            int open = 0;
            for (int c = 0; c < 3; ++c) open += !edges.contains({t[(c + 1) % 3], t[c]});
            return open >= 2;
        });
        if (mesh.triangles.size() == before) return;
    }
}

}  // namespace

SurfaceMesh sewGarment(const GarmentPattern& pattern, Jobs& jobs) {
    SampleGrid grid;
    const float step = 0.62f * pattern.edgeLengthM;
    appendSamples(grid.xs, pattern.low.x, pattern.high.x, step);
    appendSamples(grid.ys, pattern.low.y, pattern.high.y, step);
    appendSamples(grid.zs, pattern.low.z, pattern.high.z, step);
    const RemeshOptions even{[&](const Vec3f&) { return pattern.edgeLengthM; }, 4};
    SurfaceMesh mesh = remesh(marchField(pattern.field, grid, jobs), pattern.field, even, jobs);
    std::vector<float> keep(mesh.positions.size());
    for (size_t v = 0; v < keep.size(); ++v) keep[v] = pattern.keep(mesh.positions[v]);
    // Keep triangles up to 0.35 edge lengths beyond the hem line; their border vertices are moved onto it below.
    const float slack = -0.35f * pattern.edgeLengthM;
    std::erase_if(mesh.triangles, [&](const Triangle& t) { return keep[t.x] < slack || keep[t.y] < slack || keep[t.z] < slack; });
    dropTangles(mesh);
    dropEars(mesh);
    dropTangles(mesh);
    mesh = largestPiece(mesh);
    healPinholes(mesh);
    std::vector<uint32_t> tangled;
    const auto loops = borderLoops(mesh, tangled);
    for (int round = 0; round < 3; ++round) {
        std::vector<Vec3f> moved = mesh.positions;
        std::map<uint32_t, uint32_t> before;
        for (const auto& [a, b] : loops) before[b] = a;
        for (const auto& [v, after] : loops) {
            const auto it = before.find(v);
            Vec3f p = mesh.positions[v];
            if (it != before.end()) p = 0.4f * p + 0.3f * (mesh.positions[it->second] + mesh.positions[after]);
            moved[v] = ontoHem(pattern, p);
        }
        mesh.positions = std::move(moved);
    }
    mesh = remesh(mesh, pattern.field, {even.edgeLength, 4}, jobs);
    if (pattern.mirroredPair) {
        const uint32_t count = uint32_t(mesh.positions.size());
        const size_t faces = mesh.triangles.size();
        for (uint32_t v = 0; v < count; ++v) mesh.positions.push_back({-mesh.positions[v].x, mesh.positions[v].y, mesh.positions[v].z});
        for (size_t t = 0; t < faces; ++t) {
            const Triangle f = mesh.triangles[t];
            mesh.triangles.push_back({f.x + count, f.z + count, f.y + count});
        }
    }
    return mesh;
}

}  // namespace dpl
