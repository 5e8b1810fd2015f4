// SPDX-License-Identifier: Apache-2.0
// Meshes whose depth is hard to draw, for the tests of every renderer.
#pragma once

#include <algorithm>
#include <numeric>
#include <random>
#include <string>

#include "tests/reference/random_avatar.h"

namespace dpl {

struct MeshDepthCase {
    std::string name;
    std::vector<Vec3f> positions;
    std::vector<Triangle> triangles;
    Cameraf camera;
    double minCovered = 0.1, maxCovered = 1;
};

/** Random avatars, whose centre is 1 m above the origin, and single triangles and walls. */
inline std::vector<MeshDepthCase> meshDepthCases() {
    std::vector<MeshDepthCase> cases;
    for (uint32_t seed = 1; seed <= 4; ++seed) {
        const AvatarData avatar = randomAvatar(seed, 6 + 2 * seed, 0);
        std::mt19937 random(seed);
        std::normal_distribution<float> normal;
        Vec3f direction = glm::normalize(Vec3f(normal(random), 0.5f * normal(random), normal(random)));
        const auto add = [&](const char* name, const Cameraf& camera, double minCovered) {
            cases.push_back(
                {std::string(name) + ", " + std::to_string(seed), avatar.mesh.restPositions, avatar.mesh.triangles, camera, minCovered});
        };
        const Vec3f middle(0, 1, 0);
        add("random avatar", lookAt(middle + 1.8f * direction, middle, 71, 64, 90), 0.1);
        add("far away", lookAt(middle + 400.0f * direction, middle, 40, 40, 9000), 0.1);
        add("camera inside", lookAt(middle, middle + direction, 64, 48, 30), 0.99);
        add("near plane through the surface",
            lookAt(middle + 0.5f * direction, middle + 2.0f * glm::vec3(direction.z, 0.1f, -direction.x), 64, 64, 30), 0.05);
        add("one pixel", lookAt(middle + 1.8f * direction, middle, 1, 1, 1), 1);
        Cameraf offAxis = lookAt(middle + 1.5f * direction, middle, 50, 60, 70);
        offAxis.cx = -20, offAxis.cy = 90, offAxis.fy = 40;
        add("off-axis", offAxis, 0);
    }
    // One triangle, seen from the origin along +z, and the same with its corners in reverse order.
    Cameraf camera;
    camera.widthPx = 64, camera.heightPx = 48, camera.fx = camera.fy = 40, camera.cx = 32, camera.cy = 24;
    const auto one = [&](const char* name, Vec3f a, Vec3f b, Vec3f c, double minCovered, double maxCovered) {
        cases.push_back({name, {a, b, c}, {{0, 1, 2}}, camera, minCovered, maxCovered});
        cases.push_back({std::string(name) + ", other side", {a, b, c}, {{2, 1, 0}}, camera, minCovered, maxCovered});
    };
    const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    one("larger than the view", {-1e4f, -1e4f, 3}, {3e4f, -1e4f, 3.5f}, {0, 3e4f, 4}, 1, 1);
    one("floor under the camera", {-50, 1, -40}, {60, 1, -40}, {0, 1, 200}, 0.4, 0.6);
    one("one corner behind the eye", {0, 0.2f, -1}, {0.5f, -0.3f, 2}, {-0.6f, -0.2f, 2}, 0.1, 0.9);
    one("two corners behind the eye", {0, 0, 2}, {0.7f, 0.5f, -1}, {-0.7f, 0.6f, -1}, 0.1, 0.9);
    one("behind the eye", {0, 0, -2}, {0.7f, 0.5f, -1}, {-0.7f, 0.6f, -1}, 0, 0);
    one("nearer than the near plane", {-1, -1, 0.049f}, {3, -1, 0.049f}, {-1, 3, 0.049f}, 0, 0);
    one("just beyond the near plane", {-1, -1, 0.051f}, {3, -1, 0.051f}, {-1, 3, 0.051f}, 1, 1);
    one("one point", {0.1f, 0.1f, 2}, {0.1f, 0.1f, 2}, {0.1f, 0.1f, 2}, 0, 0);
    one("two corners alike", {0.11f, 0.13f, 2}, {0.11f, 0.13f, 2}, {0.7f, 0.3f, 2}, 0, 0);
    one("corners in a line", {-0.5f, -0.31f, 2}, {0, 0.02f, 2.5f}, {0.5f, 0.35f, 3}, 0, 0.02);
    one("edge-on", {-0.3f, -0.2f, 2}, {0.6f, 0.4f, 4}, {-0.9f, -0.6f, 6}, 0, 0.02);
    one("a needle of 1 to 10,000", {-1, -0.33f, 2}, {1, 0.41f, 3}, {1, 0.4101f, 3}, 0, 0.02);
    one("a corner that is not a number", {nan, 0, 2}, {1, 0, 2}, {0, 1, 2}, 0, 0);
    one("an infinite corner", {0, 0, 2}, {inf, 0, 2}, {0, 1, 2}, 0, 0);
    one("an infinitely far corner", {0, 0, 2}, {1, 0, inf}, {0, 1, 2}, 0, 0);
    one("beside the view", {5, 0, 2}, {6, 0, 2}, {5, 1, 2}, 0, 0);
    cases.push_back({"no triangles", {{0, 0, 2}}, {}, camera, 0, 0});
    // Two walls whose edges and corners lie exactly on pixel centres; one faces the camera, one faces away.
    for (const bool turned : {false, true}) {
        MeshDepthCase grid{turned ? "centres on edges, turned" : "centres on edges", {}, {}, camera, 1, 1};
        grid.camera.fx = grid.camera.fy = 32, grid.camera.cx = 32.5f, grid.camera.cy = 24.5f;
        for (int y = -8; y <= 8; ++y)
            for (int x = -8; x <= 8; ++x) grid.positions.emplace_back(0.5f * float(x), 0.5f * float(y), 2);
        for (uint32_t y = 0; y < 16; ++y)
            for (uint32_t x = 0; x < 16; ++x) {
                const uint32_t a = y * 17 + x, b = a + 1, c = a + 17, d = a + 18;
                grid.triangles.push_back(turned ? Triangle(a, c, b) : Triangle(a, b, c));
                grid.triangles.push_back(turned ? Triangle(b, c, d) : Triangle(b, d, c));
            }
        std::vector<uint32_t> place(
            grid.positions.size());  // shuffled: renderers take corners in order of index, so neighbours then wind either way
        std::iota(place.begin(), place.end(), 0u);
        std::shuffle(place.begin(), place.end(), std::mt19937(17));
        const std::vector<Vec3f> inOrder = grid.positions;
        for (size_t i = 0; i < place.size(); ++i) grid.positions[place[i]] = inOrder[i];
        for (Triangle& t : grid.triangles) t = {place[t.x], place[t.y], place[t.z]};
        cases.push_back(grid);
    }
    // 5,000 slivers around one point. Their shared edges cross many pixels, and no gap may show.
    MeshDepthCase wall{"a fan of slivers", {{0.013f, 0.017f, 2}}, {}, camera, 1, 1};
    for (uint32_t i = 0; i <= 5000; ++i) {
        const float angle = 6.2831853f * float(i % 5000) / 5000;
        wall.positions.emplace_back(20 * std::cos(angle), 20 * std::sin(angle), 2 + 0.5f * std::cos(3 * angle));
        if (i > 0) wall.triangles.push_back(i % 2 ? Triangle(0, i, i % 5000 + 1) : Triangle(i % 5000 + 1, 0, i));
    }
    cases.push_back(wall);
    return cases;
}

}  // namespace dpl
