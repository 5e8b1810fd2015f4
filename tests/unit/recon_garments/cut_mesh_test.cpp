// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/cut_mesh.h"

#include <cmath>
#include <map>

#include <gtest/gtest.h>

namespace dpl {
namespace {

constexpr uint8_t kOpen = 9;

TaggedMesh sheet(int cells) {
    TaggedMesh out;
    for (int y = 0; y <= cells; ++y)
        for (int x = 0; x <= cells; ++x) out.mesh.positions.push_back(Vec3f(float(x) + 0.13f * float((x * 7 + y * 5) % 3), float(y), 0));
    const auto at = [&](int x, int y) { return uint32_t(y * (cells + 1) + x); };
    for (int y = 0; y < cells; ++y)
        for (int x = 0; x < cells; ++x) {
            out.mesh.triangles.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
            out.mesh.triangles.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
        }
    out.tags.assign(out.mesh.triangles.size(), kOpen);
    out.columns = 1;
    for (const Vec3f& p : out.mesh.positions) out.rows.push_back(2 * p.x + p.y);
    return out;
}

double area(const TaggedMesh& m, int tag) {
    double sum = 0;
    for (size_t t = 0; t < m.tags.size(); ++t) {
        const Triangle& tri = m.mesh.triangles[t];
        const Vec3f n = glm::cross(m.mesh.positions[tri.y] - m.mesh.positions[tri.x], m.mesh.positions[tri.z] - m.mesh.positions[tri.x]);
        EXPECT_GT(n.z, 0) << "a triangle was turned over";
        if (tag < 0 || m.tags[t] == tag) sum += 0.5 * n.z;
    }
    return sum;
}

TEST(CutMesh, cutsAlongALineAndStaysConforming) {
    TaggedMesh m = sheet(10);
    const double before = area(m, -1);
    std::vector<float> value;
    for (const Vec3f& p : m.mesh.positions) value.push_back(p.x + 0.37f * p.y - 6.1f);
    cutAtZero(m, value, kOpen, 1);
    EXPECT_NEAR(area(m, -1), before, 1e-4);
    std::map<std::pair<uint32_t, uint32_t>, int> uses;
    for (const Triangle& t : m.mesh.triangles)
        for (int k = 0; k < 3; ++k) ++uses[{t[k], t[(k + 1) % 3]}];
    for (const auto& [edge, count] : uses) {
        EXPECT_EQ(count, 1);  // a directed edge belongs to one triangle
        if (uses.contains({edge.second, edge.first})) continue;
        const Vec3f middle = 0.5f * (m.mesh.positions[edge.first] + m.mesh.positions[edge.second]);
        EXPECT_TRUE(middle.y < 1e-4f || middle.y > 10 - 1e-4f || middle.x < 0.3f || middle.x > 9.9f) << "a crack inside the sheet";
    }
    // Each part lies on its side but for the fifth of an edge by which cuts go through vertices.
    for (size_t t = 0; t < m.tags.size(); ++t) {
        const Triangle& tri = m.mesh.triangles[t];
        const Vec3f centre = (m.mesh.positions[tri.x] + m.mesh.positions[tri.y] + m.mesh.positions[tri.z]) / 3.0f;
        const float side = centre.x + 0.37f * centre.y - 6.1f;
        EXPECT_GT(m.tags[t] == 1 ? side : -side, -0.3f);
    }
    EXPECT_GT(area(m, 1), 0.2 * before);
    EXPECT_GT(area(m, kOpen), 0.2 * before);
    for (size_t v = 0; v < m.rows.size(); ++v) EXPECT_NEAR(m.rows[v], 2 * m.mesh.positions[v].x + m.mesh.positions[v].y, 1e-4);
}

TEST(CutMesh, makesNoSliver) {
    for (float shift = 3; shift < 5; shift += 0.083f) {
        TaggedMesh m = sheet(10);
        std::vector<float> value;
        for (const Vec3f& p : m.mesh.positions) value.push_back(p.x + 0.2f * p.y - shift);
        cutAtZero(m, value, kOpen, 1);
        for (const Triangle& t : m.mesh.triangles) {
            float longest = 0;
            for (int k = 0; k < 3; ++k) longest = std::max(longest, glm::length(m.mesh.positions[t[k]] - m.mesh.positions[t[(k + 1) % 3]]));
            const float twice =
                glm::length(glm::cross(m.mesh.positions[t.y] - m.mesh.positions[t.x], m.mesh.positions[t.z] - m.mesh.positions[t.x]));
            EXPECT_GT(twice / (longest * longest), 0.08f);  // height over longest edge
        }
    }
}

TEST(CutMesh, leavesOtherTagsTheirTag) {
    TaggedMesh m = sheet(6);
    for (size_t t = 0; t < m.tags.size(); ++t) m.tags[t] = m.mesh.positions[m.mesh.triangles[t].x].y < 3 ? 4 : kOpen;
    const double fours = area(m, 4);
    std::vector<float> value;
    for (const Vec3f& p : m.mesh.positions) value.push_back(p.x - 2.5f);
    cutAtZero(m, value, kOpen, 1);
    EXPECT_NEAR(area(m, 4), fours, 1e-4);
    EXPECT_GT(area(m, 1), 0);
}

}  // namespace
}  // namespace dpl
