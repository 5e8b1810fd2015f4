// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/surface/body_places.h"

#include <cmath>
#include <string>

#include "sdk/avatar/humanoid.h"

namespace dpl {
namespace {

constexpr std::array<PlaceWords, kBodyPlaces> kWords = {{
    {"the face", "face", 3},
    {"the sides and back of the head", "head", 1},
    {"the left hand", "left_hand", 1.5},
    {"the right hand", "right_hand", 1.5},
    {"the left arm", "left_arm", 0.7},
    {"the right arm", "right_arm", 0.7},
    {"the chest and belly", "chest", 1},
    {"the back", "back", 1},
    {"the left side of the trunk", "left_flank", 0.5},
    {"the right side of the trunk", "right_flank", 0.5},
    {"the left leg", "left_leg", 0.7},
    {"the right leg", "right_leg", 0.7},
    {"the left foot", "left_foot", 0.5},
    {"the right foot", "right_foot", 0.5},
}};

bool contains(const std::string& text, std::string_view part) {
    return text.find(part) != std::string::npos;
}

/** The place of a joint's triangles. Of head and trunk the side decides. */
BodyPlace placeOf(const std::string& bone, BodySide side) {
    const bool left = bone.starts_with("left");
    if (bone == "head" || bone == "neck" || bone == "jaw" || contains(bone, "Eye"))
        return side == BodySide::Front ? BodyPlace::Face : BodyPlace::Head;
    for (const char* finger : {"Hand", "Thumb", "Index", "Middle", "Ring", "Little"})
        if (contains(bone, finger)) return left ? BodyPlace::LeftHand : BodyPlace::RightHand;
    if (contains(bone, "UpperArm") || contains(bone, "LowerArm")) return left ? BodyPlace::LeftArm : BodyPlace::RightArm;
    if (contains(bone, "UpperLeg") || contains(bone, "LowerLeg")) return left ? BodyPlace::LeftLeg : BodyPlace::RightLeg;
    if (contains(bone, "Foot") || contains(bone, "Toes")) return left ? BodyPlace::LeftFoot : BodyPlace::RightFoot;
    switch (side) {  // hips, spine, chest, shoulders
        case BodySide::Front:
            return BodyPlace::Chest;
        case BodySide::Back:
            return BodyPlace::Back;
        case BodySide::Left:
            return BodyPlace::LeftFlank;
        case BodySide::Right:
            return BodyPlace::RightFlank;
    }
    return BodyPlace::Chest;
}

}  // namespace

const PlaceWords& wordsOf(BodyPlace place) {
    return kWords[size_t(place)];
}

BodySide sideOf(const Vec3f& n) {
    if (std::abs(n.x) > std::abs(n.z)) return n.x > 0 ? BodySide::Left : BodySide::Right;
    return n.z >= 0 ? BodySide::Front : BodySide::Back;
}

std::vector<uint32_t> jointOfTriangles(const MeshData& mesh) {
    std::vector<uint32_t> out;
    out.reserve(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) {
        uint32_t best = 0, most = 0;
        for (int a = 0; a < 12; ++a) {
            const uint32_t joint = mesh.jointIndices[t[a / 4]][a % 4];
            uint32_t sum = 0;
            for (int b = 0; b < 12; ++b)
                if (mesh.jointIndices[t[b / 4]][b % 4] == joint) sum += mesh.jointWeights[t[b / 4]][b % 4];
            if (sum > most || (sum == most && joint < best)) best = joint, most = sum;
        }
        out.push_back(best);
    }
    return out;
}

std::vector<double> restAreas(const MeshData& mesh) {
    std::vector<double> out;
    out.reserve(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) {
        const Vec3d a(mesh.restPositions[t.x]);
        out.push_back(0.5 * glm::length(glm::cross(Vec3d(mesh.restPositions[t.y]) - a, Vec3d(mesh.restPositions[t.z]) - a)));
    }
    return out;
}

std::vector<Vec3f> restMiddles(const MeshData& mesh) {
    std::vector<Vec3f> out;
    out.reserve(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles)
        out.push_back((mesh.restPositions[t.x] + mesh.restPositions[t.y] + mesh.restPositions[t.z]) / 3.0f);
    return out;
}

std::vector<Vec3f> restNormals(const MeshData& mesh) {
    std::vector<Vec3f> out;
    out.reserve(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) {
        const Vec3f a = mesh.restPositions[t.x];
        const Vec3f n = glm::cross(mesh.restPositions[t.y] - a, mesh.restPositions[t.z] - a);
        const float length = glm::length(n);
        out.push_back(length > 1e-12f ? n / length : Vec3f(0, 0, 1));
    }
    return out;
}

std::vector<BodyPlace> placesOf(std::span<const JointData> joints, const MeshData& mesh) {
    std::vector<std::string> bones = humanoidBones(joints);
    for (size_t j = 0; j < joints.size(); ++j)
        if (bones[j].empty() && joints[j].parent >= 0) bones[j] = bones[size_t(joints[j].parent)];
    const std::vector<uint32_t> jointOf = jointOfTriangles(mesh);
    const std::vector<Vec3f> normals = restNormals(mesh);
    std::vector<BodyPlace> places;
    places.reserve(jointOf.size());
    for (size_t t = 0; t < jointOf.size(); ++t) places.push_back(placeOf(bones[jointOf[t]], sideOf(normals[t])));
    return places;
}

}  // namespace dpl
