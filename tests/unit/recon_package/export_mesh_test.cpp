// SPDX-License-Identifier: Apache-2.0
// The exported mesh as a stock viewer reads it: unit normals, an unlit material, the avatar's colours, skeleton and clips.
#include "reconstruction/output/package/export_mesh.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "sdk/core/files.h"
#include "sdk/format/gltf_mesh.h"
#include "sdk/format/skinned_gltf.h"
#include "tests/unit/format/glb_parts.h"
#include "tests/unit/format/sample_avatars.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl {
namespace {

/** Layers with vertex colours, of which one has a triangle without area and vertices of no other triangle. */
AvatarData coloured() {
    AvatarData a = test::layeredAvatar(3, 1, 8, 4);
    const LayerData& last = a.mesh.layers.back();
    Triangle& flat = a.mesh.triangles[last.firstTriangle];
    flat.y = flat.x;  // the corner of the grid is then of one triangle less
    const uint32_t end = last.firstTriangle + last.triangleCount;
    for (uint32_t t = end - 2; t < end; ++t) a.mesh.triangles[t] = Triangle(last.firstVertex);  // and the far corner of none
    auto decoded = decodedAvatar(a);
    EXPECT_TRUE(decoded) << (decoded ? "" : decoded.error().message);
    return decoded ? std::move(*decoded) : AvatarData{};
}

class ExportMesh : public testing::Test {
protected:
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() / ("doppel_export_mesh_" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder_);
        avatar_ = coloured();
        ASSERT_TRUE(bool(writeFileAtomically(folder_ / "avatar.glb", *writeAvatar(avatar_))));
        const auto line = exportMesh(folder_ / "avatar.glb", folder_ / "mesh.glb");
        ASSERT_TRUE(line) << line.error().message;
        bytes_ = *readFile(folder_ / "mesh.glb", 1u << 24);
        parts_ = test::split(bytes_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    nlohmann::json attribute(size_t layer, const char* name) const {
        return parts_.json["meshes"][layer]["primitives"][0]["attributes"][name];
    }
    template <class T>
    std::vector<T> values(size_t layer, const char* name) {
        const auto bytes = parts_.accessor(attribute(layer, name).get<size_t>());
        std::vector<T> out(bytes.size() / sizeof(T));
        std::memcpy(out.data(), bytes.data(), bytes.size());
        return out;
    }

    std::filesystem::path folder_;
    AvatarData avatar_;
    std::vector<uint8_t> bytes_;
    test::GlbParts parts_;
};

TEST_F(ExportMesh, everyVertexHasAUnitNormalOfItsTriangles) {
    ASSERT_EQ(parts_.json["meshes"].size(), avatar_.mesh.layers.size());
    for (size_t l = 0; l < avatar_.mesh.layers.size(); ++l) {
        const LayerData& layer = avatar_.mesh.layers[l];
        const auto normals = values<Vec3f>(l, "NORMAL"), positions = values<Vec3f>(l, "POSITION");
        const nlohmann::json& accessor = parts_.json["accessors"][attribute(l, "NORMAL").get<size_t>()];
        EXPECT_EQ(accessor["type"], "VEC3");
        EXPECT_EQ(accessor["componentType"], 5126);
        ASSERT_EQ(normals.size(), layer.vertexCount);
        for (size_t v = 0; v < normals.size(); ++v) ASSERT_NEAR(glm::length(normals[v]), 1, 1e-5f) << layer.name << " " << v;
        for (uint32_t t = layer.firstTriangle; t < layer.firstTriangle + layer.triangleCount; ++t) {
            const Triangle c = avatar_.mesh.triangles[t] - layer.firstVertex;
            const Vec3f across = glm::cross(positions[c.y] - positions[c.x], positions[c.z] - positions[c.x]);
            for (int k = 0; k < 3; ++k)  // the grids are wavy, not folded
                if (glm::length(across) > 0) {
                    ASSERT_GT(glm::dot(normals[c[k]], across), 0) << layer.name << " " << t;
                }
        }
    }
}

TEST_F(ExportMesh, theMaterialIsUnlitAndTheColoursAreThoseOfTheAvatar) {
    const nlohmann::json& used = parts_.json["extensionsUsed"];
    EXPECT_EQ(used, nlohmann::json::array({"KHR_materials_unlit"}));
    EXPECT_FALSE(parts_.json.contains("extensionsRequired")) << "any viewer opens it";
    for (size_t l = 0; l < avatar_.mesh.layers.size(); ++l) {
        const nlohmann::json& primitive = parts_.json["meshes"][l]["primitives"][0];
        const nlohmann::json& material = parts_.json["materials"][primitive["material"].get<size_t>()];
        EXPECT_TRUE(material["extensions"].contains("KHR_materials_unlit"));
        EXPECT_FALSE(material["pbrMetallicRoughness"].contains("baseColorFactor")) << "white: the vertex colours alone";
        EXPECT_TRUE(parts_.json["accessors"][attribute(l, "COLOR_0").get<size_t>()].value("normalized", false));
        const auto colours = values<glm::u16vec4>(l, "COLOR_0");
        const LayerData& layer = avatar_.mesh.layers[l];
        ASSERT_EQ(colours.size(), layer.vertexCount);
        for (size_t v = 0; v < colours.size(); ++v) {
            EXPECT_EQ(colours[v].a, 65535);
            for (int c = 0; c < 3; ++c) {  // COLOR_0 is linear; a screen shows sRGB
                const double linear = colours[v][c] / 65535.0;
                const double shown = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
                ASSERT_NEAR(255 * shown, avatar_.mesh.colours[layer.firstVertex + v][c], 1) << layer.name << " " << v;
            }
        }
    }
}

TEST_F(ExportMesh, otherReadersFindMeshSkeletonAndClipsButNoSplats) {
    const auto read = readSkinnedGltf(bytes_);
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->meshes.size(), avatar_.mesh.layers.size());
    size_t vertices = 0, triangles = 0;
    for (const SkinnedGltf::Mesh& mesh : read->meshes) {
        EXPECT_TRUE(mesh.skinned);
        vertices += mesh.positions.size(), triangles += mesh.triangles.size();
    }
    EXPECT_EQ(vertices, avatar_.mesh.restPositions.size());
    EXPECT_EQ(triangles, avatar_.mesh.triangles.size());
    EXPECT_EQ(read->joints.size(), avatar_.joints.size());
    ASSERT_EQ(read->animations.size(), avatar_.clips.size());
    EXPECT_EQ(read->animations[1].name, avatar_.clips[1].name);
    EXPECT_FALSE(parts_.json.contains("extensions"));
}

TEST_F(ExportMesh, skinnedSplatsLieOnTheTrianglesOfTheirLayer) {
    const auto lines = exportMesh(folder_ / "avatar.glb", folder_ / "skinned.glb", {.skinnedSplats = true});
    ASSERT_TRUE(lines) << lines.error().message;
    bytes_ = *readFile(folder_ / "skinned.glb", 1u << 24);
    parts_ = test::split(bytes_);
    const std::string name = "DPL_skinned_gaussian_splatting";
    EXPECT_EQ(parts_.json["extensionsUsed"], nlohmann::json::array({"KHR_materials_unlit", name}));
    EXPECT_FALSE(parts_.json.contains("extensionsRequired")) << "others show the mesh";
    uint32_t count = 0;
    for (size_t l = 0; l < avatar_.mesh.layers.size(); ++l) {
        const LayerData& layer = avatar_.mesh.layers[l];
        const nlohmann::json& extension = parts_.json["meshes"][l]["primitives"][0]["extensions"][name];
        EXPECT_EQ(extension["lowPassVariance"], avatar_.kappaPx2);
        auto bytes = [&](const char* attribute) { return parts_.accessor(extension["attributes"][attribute].get<size_t>()); };
        const auto triangle = bytes("TRIANGLE"), uv = bytes("BARYCENTRIC"), outside = bytes("OUTSIDE"), red = bytes("SH_DEGREE_1_COEF_2");
        uint32_t i = 0;
        for (uint32_t t = 0; t < layer.triangleCount; ++t)
            for (uint32_t s = avatar_.splats.triangleStart[layer.firstTriangle + t];
                 s < avatar_.splats.triangleStart[layer.firstTriangle + t + 1]; ++s, ++i) {
                uint32_t parent;
                Vec2f place;
                Vec3f sh;
                std::memcpy(&parent, triangle.data() + 4 * i, 4), std::memcpy(&place, uv.data() + 8 * i, 8);
                std::memcpy(&sh, red.data() + 12 * i, 12);
                ASSERT_EQ(parent, t) << layer.name;
                ASSERT_EQ(place, avatar_.splats.uv[s]);
                ASSERT_EQ(sh.x, avatar_.splats.sh[size_t(s) * 12 + 9]);
                ASSERT_EQ(outside[i], avatar_.splats.flags[s] & kSplatSingleFace);
            }
        EXPECT_EQ(triangle.size(), size_t(i) * 4);
        count += i;
    }
    EXPECT_EQ(count, avatar_.splats.count());
    EXPECT_EQ(lines->find("left out"), std::string::npos) << *lines;
}

TEST_F(ExportMesh, skinnedSplatsLeaveOutLayersWithoutSplatsAndAreRefusedWhereThereAreNone) {
    AvatarData bare = avatar_;
    const LayerData& first = bare.mesh.layers[0];
    const uint32_t gone = bare.splats.triangleStart[first.triangleCount], floats = shCoefficientCount(bare.splats.shDegree) * 3;
    auto cut = [&](auto& values, size_t each) { values.erase(values.begin(), values.begin() + std::ptrdiff_t(gone * each)); };
    cut(bare.splats.uv, 1), cut(bare.splats.phi, 1), cut(bare.splats.scaleM, 1), cut(bare.splats.opacity, 1), cut(bare.splats.flags, 1);
    cut(bare.splats.sh, floats);
    for (uint32_t& start : bare.splats.triangleStart) start = start > gone ? start - gone : 0;
    const std::vector<Vec3f> normals(bare.mesh.restPositions.size(), Vec3f(0, 0, 1));
    const auto file = writeGltfMesh(bare, normals, {.skinnedSplats = true});
    ASSERT_TRUE(file) << file.error().message;
    const nlohmann::json json = test::split(*file).json;
    EXPECT_FALSE(json["meshes"][0]["primitives"][0].contains("extensions"));
    EXPECT_TRUE(json["meshes"][1]["primitives"][0].contains("extensions"));
    bare.splats = {};
    bare.splats.triangleStart.assign(bare.mesh.triangles.size() + 1, 0);
    EXPECT_NE(writeGltfMesh(bare, normals, {.skinnedSplats = true}).error().message.find("no splats"), std::string::npos);
}

TEST_F(ExportMesh, skinnedSplatsSayWhatTheyCannotHold) {
    const AvatarData moving = test::withCorrectives(avatar_, 1);
    ASSERT_TRUE(bool(writeFileAtomically(folder_ / "moving.glb", *writeAvatar(moving))));
    const auto lines = exportMesh(folder_ / "moving.glb", folder_ / "skinned.glb", {.skinnedSplats = true});
    ASSERT_TRUE(lines) << lines.error().message;
    EXPECT_NE(lines->find("left out: pose correctives"), std::string::npos) << *lines;
}

TEST_F(ExportMesh, refusesOtherEndingsAndFilesWithoutAMesh) {
    const auto ply = exportMesh(folder_ / "avatar.glb", folder_ / "mesh.ply");
    ASSERT_FALSE(ply);
    EXPECT_NE(ply.error().message.find("mesh.ply: with --mesh the file must end in .glb"), std::string::npos) << ply.error().message;
    const auto mesh = exportMesh(folder_ / "mesh.glb", folder_ / "again.glb");
    ASSERT_FALSE(mesh) << "it is no avatar any more";
    EXPECT_NE(mesh.error().message.find("mesh.glb"), std::string::npos) << mesh.error().message;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "again.glb"));
}

TEST_F(ExportMesh, theWriterRefusesNormalsThatAreNotUnitOrNotOfTheMesh) {
    std::vector<Vec3f> normals(avatar_.mesh.restPositions.size(), Vec3f(0, 0, 1));
    EXPECT_TRUE(bool(writeGltfMesh(avatar_, normals)));
    normals[7] = Vec3f(0, 0, 0.5f);
    EXPECT_NE(writeGltfMesh(avatar_, normals).error().message.find("normal 7"), std::string::npos);
    normals[7] = Vec3f(std::numeric_limits<float>::quiet_NaN());
    EXPECT_NE(writeGltfMesh(avatar_, normals).error().message.find("normal 7"), std::string::npos);
    normals.pop_back();
    EXPECT_FALSE(bool(writeGltfMesh(avatar_, normals)));
    AvatarData empty = avatar_;
    empty.mesh = {}, empty.splats = {}, empty.splats.triangleStart = {0};
    EXPECT_FALSE(bool(writeGltfMesh(empty, {})));
}

}  // namespace
}  // namespace dpl
