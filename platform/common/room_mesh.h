// SPDX-License-Identifier: Apache-2.0
// The triangles of the room: a floor, a ring of columns with a beam, a backdrop around it, a stand for each avatar, and posts.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace dpl::platform {

constexpr float kStandHeightM = 0.1f, kStandRadiusM = 0.46f, kPostHeightM = 1.1f;
constexpr uint32_t kMaxStands = 16, kMaxPosts = 4;
constexpr float kMinRingRadiusM = 5.2f, kMaxRingRadiusM = 14;

enum class RoomLight { Dark, Bright };

struct RoomPlan {
    float ringRadiusM = kMinRingRadiusM;       // of the columns around the origin, between the two ends above
    float floorY = 0;                          // world, metres
    std::vector<std::array<float, 2>> stands;  // x and z of their centres, at most kMaxStands; their tops are at floorY + kStandHeightM
    std::vector<std::array<float, 2>> posts;   // x and z of slender, waist-high posts, at most kMaxPosts
    bool operator==(const RoomPlan&) const = default;
};

/** What a surface is made of; room.frag gives each its colour. */
enum class RoomSurface : uint32_t { Floor = 0, Backdrop = 1, Column = 2, Stand = 3 };

struct RoomVertex {
    float position[3], normal[3];  // world
    float surface;                 // RoomSurface
    float open;                    // 1: full light; less where a body or a wall is near
};

/** Three vertices a triangle, counter-clockwise from outside. The backdrop is seen from within. */
std::vector<RoomVertex> roomMesh(const RoomPlan& plan);

/** Most vertices that roomMesh returns. */
uint32_t maxRoomVertices();

}  // namespace dpl::platform
