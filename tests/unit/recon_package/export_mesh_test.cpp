// SPDX-License-Identifier: Apache-2.0
// The exported mesh as a stock viewer reads it: unit normals, an unlit material, a texture, skeleton and clips.
#include "reconstruction/output/package/export_mesh.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>

#include "sdk/core/files.h"
#include "sdk/format/gltf_mesh.h"
#include "sdk/format/skinned_gltf.h"
#include "tests/unit/format/glb_parts.h"
#include "tests/unit/format/one_pixel_png.h"
#include "tests/unit/format/sample_avatars.h"
#include "tests/unit/recon_package/stock_viewer.h"

namespace dpl {
namespace {

/** Layers of which one has a triangle without area and vertices of no other triangle. */
AvatarData layers() {
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
        avatar_ = layers();
        ASSERT_TRUE(bool(writeFileAtomically(folder_ / "avatar.glb", *writeAvatar(avatar_))));
        write();
    }
    void write(const std::function<void(MeshExportOptions&)>& change = {}) {
        MeshExportOptions options = {.avatar = folder_ / "avatar.glb", .out = folder_ / "mesh.glb", .texturePx = 256};
        if (change) change(options);
        const auto line = exportMesh(options);
        ASSERT_TRUE(line) << line.error().message;
        bytes_ = *readFile(folder_ / "mesh.glb", 1u << 24);
        parts_ = test::split(bytes_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::string refusal(const std::function<void(MeshExportOptions&)>& change) {
        MeshExportOptions options = {.avatar = folder_ / "avatar.glb", .out = folder_ / "refused.glb", .texturePx = 256};
        change(options);
        const auto line = exportMesh(options);
        EXPECT_FALSE(line);
        EXPECT_FALSE(std::filesystem::exists(folder_ / "refused.glb"));
        return line ? std::string() : line.error().message;
    }

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

    std::vector<Triangle> triangleList(size_t layer) {
        const auto bytes = parts_.accessor(parts_.json["meshes"][layer]["primitives"][0]["indices"].get<size_t>());
        std::vector<Triangle> out(bytes.size() / sizeof(Triangle));
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
        ASSERT_EQ(normals.size(), positions.size());
        for (size_t v = 0; v < normals.size(); ++v) ASSERT_NEAR(glm::length(normals[v]), 1, 1e-5f) << layer.name << " " << v;
        const auto triangles = triangleList(l);
        ASSERT_EQ(triangles.size(), layer.triangleCount);
        for (size_t t = 0; t < triangles.size(); ++t) {
            const Triangle c = triangles[t];
            const Vec3f across = glm::cross(positions[c.y] - positions[c.x], positions[c.z] - positions[c.x]);
            for (int k = 0; k < 3; ++k)  // the grids are wavy, not folded
                if (glm::length(across) > 0) {
                    ASSERT_GT(glm::dot(normals[c[k]], across), 0) << layer.name << " " << t;
                }
        }
    }
}

TEST_F(ExportMesh, trianglesAndSkinAreThoseOfTheAvatar) {
    for (size_t l = 0; l < avatar_.mesh.layers.size(); ++l) {
        const LayerData& layer = avatar_.mesh.layers[l];
        const auto positions = values<Vec3f>(l, "POSITION");
        const auto weights = values<glm::u8vec4>(l, "WEIGHTS_0");
        const auto triangles = triangleList(l);
        for (size_t t = 0; t < triangles.size(); ++t)
            for (int k = 0; k < 3; ++k) {
                const uint32_t v = avatar_.mesh.triangles[layer.firstTriangle + t][k];
                EXPECT_EQ(positions[triangles[t][k]], avatar_.mesh.restPositions[v]) << layer.name << " " << t;
                EXPECT_EQ(weights[triangles[t][k]], avatar_.mesh.jointWeights[v]) << layer.name << " " << t;
            }
    }
}

TEST_F(ExportMesh, theMaterialIsUnlitAndTheTextureHoldsTheColours) {
    EXPECT_EQ(parts_.json["extensionsUsed"], nlohmann::json::array({"KHR_materials_unlit"}));
    EXPECT_FALSE(parts_.json.contains("extensionsRequired")) << "any viewer opens it";
    const test::StockViewer viewer(bytes_);
    EXPECT_EQ(viewer.texture().widthPx, 256u);
    EXPECT_EQ(viewer.texture().heightPx, 256u);
    for (size_t l = 0; l < avatar_.mesh.layers.size(); ++l) {
        const nlohmann::json& primitive = parts_.json["meshes"][l]["primitives"][0];
        const nlohmann::json& material = parts_.json["materials"][primitive["material"].get<size_t>()];
        EXPECT_TRUE(material["extensions"].contains("KHR_materials_unlit"));
        EXPECT_TRUE(material.value("doubleSided", false));
        EXPECT_FALSE(material["pbrMetallicRoughness"].contains("baseColorFactor")) << "white: the texture alone";
        EXPECT_EQ(material["pbrMetallicRoughness"]["baseColorTexture"]["index"], 0);
        EXPECT_FALSE(primitive["attributes"].contains("COLOR_0")) << "viewers multiply the texture by it";
        const auto uv = values<Vec2f>(l, "TEXCOORD_0");
        ASSERT_EQ(uv.size(), values<Vec3f>(l, "POSITION").size());
        for (const Vec2f& at : uv) ASSERT_TRUE(at.x > 0 && at.x < 1 && at.y > 0 && at.y < 1) << at.x << " " << at.y;
    }
}

TEST_F(ExportMesh, aJpegIsAJpegAndDracoHoldsTheSameMesh) {
    const auto plain = readSkinnedGltf(bytes_);
    write([](MeshExportOptions& o) { o.textureFormat = "jpg", o.compression = "draco"; });
    EXPECT_EQ(parts_.json["images"][0]["mimeType"], "image/jpeg");
    EXPECT_EQ(parts_.json["extensionsRequired"], nlohmann::json::array({"KHR_draco_mesh_compression"}));
    EXPECT_EQ(test::StockViewer(bytes_).texture().widthPx, 256u);
    const auto draco = readSkinnedGltf(bytes_);
    ASSERT_TRUE(plain && draco);
    ASSERT_EQ(draco->meshes.size(), plain->meshes.size());
    for (size_t m = 0; m < plain->meshes.size(); ++m) {
        const SkinnedGltf::Mesh &a = plain->meshes[m], &b = draco->meshes[m];
        EXPECT_EQ(a.positions, b.positions);
        EXPECT_EQ(a.triangles, b.triangles);
        EXPECT_EQ(a.jointIndices, b.jointIndices);
        ASSERT_EQ(a.uv.size(), b.uv.size());
        for (size_t v = 0; v < a.uv.size(); ++v) EXPECT_LT(glm::length(a.uv[v] - b.uv[v]), 2.0f / 65536) << v;  // 16 bits each
    }
}

TEST_F(ExportMesh, aClipByNameIsTheOnlyAnimation) {
    ASSERT_GT(avatar_.clips.size(), 1u);
    write([&](MeshExportOptions& o) { o.clip = avatar_.clips[1].name; });
    const auto read = readSkinnedGltf(bytes_);
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->animations.size(), 1u);
    EXPECT_EQ(read->animations[0].name, avatar_.clips[1].name);
}

TEST_F(ExportMesh, theSameBytesWithAnyNumberOfThreads) {
    const std::vector<uint8_t> first = bytes_;
    write([](MeshExportOptions& o) { o.threadCount = 3; });
    EXPECT_EQ(bytes_, first);
}

TEST_F(ExportMesh, otherReadersFindMeshSkeletonAndClipsButNoSplats) {
    const auto read = readSkinnedGltf(bytes_);
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->meshes.size(), avatar_.mesh.layers.size());
    size_t triangles = 0;
    for (const SkinnedGltf::Mesh& mesh : read->meshes) {
        EXPECT_TRUE(mesh.skinned);
        EXPECT_EQ(mesh.uv.size(), mesh.positions.size());
        triangles += mesh.triangles.size();
    }
    EXPECT_EQ(triangles, avatar_.mesh.triangles.size());
    EXPECT_EQ(read->joints.size(), avatar_.joints.size());
    ASSERT_EQ(read->animations.size(), avatar_.clips.size());
    EXPECT_EQ(read->animations[1].name, avatar_.clips[1].name);
    EXPECT_FALSE(parts_.json.contains("extensions"));
}

TEST_F(ExportMesh, refusesWhatItCannotWriteInASentence) {
    const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
    std::string said = refusal([&](MeshExportOptions& o) { o.out = folder_ / "mesh.ply"; });
    EXPECT_TRUE(has(said, "mesh.ply: with --mesh the file must end in .glb")) << said;
    said = refusal([&](MeshExportOptions& o) { o.avatar = folder_ / "mesh.glb"; });
    EXPECT_TRUE(has(said, "mesh.glb")) << "it is no avatar any more: " << said;
    for (const uint32_t side : {0u, 128u, 1000u, 16384u, 0x80000000u}) {
        said = refusal([&](MeshExportOptions& o) { o.texturePx = side; });
        EXPECT_TRUE(has(said, "a power of two from 256 to 8192")) << said;
    }
    said = refusal([&](MeshExportOptions& o) { o.clip = "nowhere.bvh"; });
    EXPECT_TRUE(has(said, "--clip nowhere.bvh")) << said;

    AvatarData bare = avatar_;
    bare.splats = {}, bare.splats.triangleStart.assign(bare.mesh.triangles.size() + 1, 0);
    ASSERT_TRUE(bool(writeFileAtomically(folder_ / "bare.glb", *writeAvatar(bare))));
    said = refusal([&](MeshExportOptions& o) { o.avatar = folder_ / "bare.glb"; });
    EXPECT_TRUE(has(said, "bare.glb: the avatar has no splats to take a texture from")) << said;
}

TEST_F(ExportMesh, theWriterRefusesNormalsAndPlacesThatAreNotOfTheMesh) {
    std::vector<Vec3f> normals(avatar_.mesh.restPositions.size(), Vec3f(0, 0, 1));
    std::vector<Vec2f> uv(normals.size(), Vec2f(0.5f));
    const std::vector<uint8_t> png = test::onePixelPng();
    const auto refused = [&](const char* part) {
        const auto file = writeGltfMesh(avatar_, normals, {uv, png});
        return !file && file.error().message.find(part) != std::string::npos;
    };
    EXPECT_TRUE(bool(writeGltfMesh(avatar_, normals, {uv, png})));
    normals[7] = Vec3f(0, 0, 0.5f);
    EXPECT_TRUE(refused("normal 7"));
    normals[7] = Vec3f(std::numeric_limits<float>::quiet_NaN());
    EXPECT_TRUE(refused("normal 7"));
    normals[7] = Vec3f(0, 0, 1);
    for (const float bad : {-0.1f, 1.1f, std::numeric_limits<float>::quiet_NaN()}) {
        uv[3].y = bad;
        EXPECT_TRUE(refused("texture coordinate 3")) << bad;
    }
    uv[3].y = 0;
    uv.pop_back();
    EXPECT_TRUE(refused("texture coordinates for"));
    uv.push_back(Vec2f(0));
    normals.pop_back();
    EXPECT_TRUE(refused("normals for"));
    AvatarData empty = avatar_;
    empty.mesh = {}, empty.splats = {}, empty.splats.triangleStart = {0};
    EXPECT_FALSE(bool(writeGltfMesh(empty, {}, {})));
}

}  // namespace
}  // namespace dpl
