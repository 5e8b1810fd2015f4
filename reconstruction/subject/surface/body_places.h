// SPDX-License-Identifier: Apache-2.0
// The places of a body in words: "the left hand", "the back". Every triangle belongs to one.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "sdk/format/avatar_data.h"

namespace dpl {

enum class BodyPlace : uint8_t {
    Face,
    Head,
    LeftHand,
    RightHand,
    LeftArm,
    RightArm,
    Chest,
    Back,
    LeftFlank,
    RightFlank,
    LeftLeg,
    RightLeg,
    LeftFoot,
    RightFoot,
};
constexpr size_t kBodyPlaces = 14;

struct PlaceWords {
    std::string_view name;  // "the left hand"
    std::string_view key;   // "left_hand", for files
    double importance;      // weight of the place when shots are chosen; people look at faces and hands
};
const PlaceWords& wordsOf(BodyPlace place);

/** Where a surface points at rest, seen by the avatar: +Z is its front, +X its left. In the order of the capture map of an avatar file. */
enum class BodySide : uint8_t { Front, Left, Back, Right };
constexpr size_t kBodySides = 4;
BodySide sideOf(const Vec3f& restNormal);

/** The joint that moves each triangle most: largest sum of weights over its corners; the lower index wins ties. F. */
std::vector<uint32_t> jointOfTriangles(const MeshData& mesh);

/** The area of each triangle at rest, m². F. */
std::vector<double> restAreas(const MeshData& mesh);

/** The middle of each triangle at rest. F. */
std::vector<Vec3f> restMiddles(const MeshData& mesh);

/** The normal of each triangle at rest, unit length; of degenerate triangles (0, 0, 1). F. */
std::vector<Vec3f> restNormals(const MeshData& mesh);

/** Joints are told by their humanoid bones (sdk/avatar/humanoid.h); a joint without one is part of its parent's place. F. */
std::vector<BodyPlace> placesOf(std::span<const JointData> joints, const MeshData& mesh);

}  // namespace dpl
