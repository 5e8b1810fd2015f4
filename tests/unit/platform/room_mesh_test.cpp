// SPDX-License-Identifier: Apache-2.0
#include "platform/common/room_mesh.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sdk/math/types.h"

namespace {

using namespace dpl;
using namespace dpl::platform;

Vec3f at(const RoomVertex& v) {
    return {v.position[0], v.position[1], v.position[2]};
}

Vec3f normalOf(const RoomVertex& v) {
    return {v.normal[0], v.normal[1], v.normal[2]};
}

/** Highest point of a surface straight above or below (x, z). */
float heightAt(const std::vector<RoomVertex>& mesh, RoomSurface surface, float x, float z) {
    float highest = -INFINITY;
    for (size_t i = 0; i < mesh.size(); i += 3) {
        if (RoomSurface(mesh[i].surface) != surface) continue;
        const Vec3f a = at(mesh[i]), b = at(mesh[i + 1]) - a, c = at(mesh[i + 2]) - a;
        const float det = b.x * c.z - b.z * c.x;
        if (std::abs(det) < 1e-9f) continue;
        const float u = ((x - a.x) * c.z - (z - a.z) * c.x) / det, v = (b.x * (z - a.z) - b.z * (x - a.x)) / det;
        if (u >= 0 && v >= 0 && u + v <= 1) highest = std::max(highest, a.y + u * b.y + v * c.y);
    }
    return highest;
}

TEST(RoomMesh, trianglesTurnTheSideOfTheirNormalsToTheViewer) {
    const auto mesh = roomMesh({7, -0.1f, {{0, 0}, {1, 0}}, {{0.2f, 1}}});
    ASSERT_EQ(mesh.size() % 3, 0u);
    for (size_t i = 0; i < mesh.size(); i += 3) {
        const Vec3f across = glm::cross(at(mesh[i + 1]) - at(mesh[i]), at(mesh[i + 2]) - at(mesh[i]));
        ASSERT_GT(glm::length(across), 1e-9f) << "triangle " << i / 3 << " has no area";
        const Vec3f mean = normalOf(mesh[i]) + normalOf(mesh[i + 1]) + normalOf(mesh[i + 2]);
        EXPECT_GT(glm::dot(across, mean), 0) << "triangle " << i / 3 << " of surface " << mesh[i].surface;
    }
}

TEST(RoomMesh, floorAndStandsLieWhereThePlanSays) {
    const auto mesh = roomMesh({kMinRingRadiusM, -0.1f, {{0.5f, 0}, {-0.5f, 0}}});
    EXPECT_NEAR(heightAt(mesh, RoomSurface::Floor, 2, 1), -0.1f, 1e-5f);
    for (const float x : {0.5f, -0.5f}) EXPECT_NEAR(heightAt(mesh, RoomSurface::Stand, x + 0.1f, 0.05f), 0, 1e-5f);
    EXPECT_EQ(heightAt(mesh, RoomSurface::Stand, 0.5f + 1.01f * kStandRadiusM, 0), -INFINITY);
}

TEST(RoomMesh, floorHasNoCornerWhereAUserStands) {
    int corners = 0;
    for (const RoomVertex& v : roomMesh({kMinRingRadiusM, -0.1f, {}, {}}))
        if (v.surface == float(RoomSurface::Floor) && v.position[1] == -0.1f) {
            EXPECT_GT(std::hypot(v.position[0], v.position[2]), kMinRingRadiusM) << "shadows lie higher";
            ++corners;
        }
    EXPECT_GT(corners, 0);
}

TEST(RoomMesh, postsLieWhereThePlanSays) {
    const auto mesh = roomMesh({kMinRingRadiusM, -0.1f, {}, {{0.2f, 1}}});
    EXPECT_NEAR(heightAt(mesh, RoomSurface::Column, 0.21f, 1.01f), kPostHeightM - 0.1f, 1e-5f);
    EXPECT_EQ(heightAt(mesh, RoomSurface::Column, 0.3f, 1), -INFINITY);
}

TEST(RoomMesh, columnsStandAroundWhatTheyShow) {
    for (const float ring : {kMinRingRadiusM, 9.0f, kMaxRingRadiusM, 100.0f})
        for (const RoomVertex& v : roomMesh({ring, 0, {}})) {
            if (RoomSurface(v.surface) != RoomSurface::Column) continue;
            EXPECT_GT(std::hypot(v.position[0], v.position[2]), std::min(ring, kMaxRingRadiusM) - 0.5f) << v.position[1];
        }
}

TEST(RoomMesh, takesNoMoreStandsAndPostsThanItSays) {
    RoomPlan plan;
    plan.ringRadiusM = kMaxRingRadiusM;
    plan.stands.resize(kMaxStands);
    plan.posts.resize(kMaxPosts);
    EXPECT_EQ(roomMesh(plan).size(), maxRoomVertices());
    plan.stands.resize(kMaxStands + 5);
    plan.posts.resize(kMaxPosts + 5);
    EXPECT_EQ(roomMesh(plan).size(), maxRoomVertices());
    EXPECT_LT(roomMesh({}).size(), maxRoomVertices());
}

}  // namespace
