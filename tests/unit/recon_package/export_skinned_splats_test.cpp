// SPDX-License-Identifier: Apache-2.0
// Splats on a skinned mesh, as the file holds them; tests/conformance compares what a reader of its own makes of them with the library.
#include "reconstruction/output/package/export_skinned_splats.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>

#include "sdk/core/files.h"
#include "sdk/format/gltf_mesh.h"
#include "tests/unit/format/glb_parts.h"
#include "tests/unit/format/sample_avatars.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl {
namespace {

class ExportSkinnedSplats : public testing::Test {
protected:
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() / ("doppel_skinned_splats_" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder_);
        auto decoded = decodedAvatar(test::layeredAvatar(3, 1, 8, 4));
        ASSERT_TRUE(decoded) << decoded.error().message;
        avatar_ = std::move(*decoded);
        ASSERT_TRUE(bool(writeFileAtomically(folder_ / "avatar.glb", *writeAvatar(avatar_))));
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::filesystem::path folder_;
    AvatarData avatar_;
};

TEST_F(ExportSkinnedSplats, theyLieOnTheTrianglesOfTheirLayer) {
    const auto lines = exportSkinnedSplats(folder_ / "avatar.glb", folder_ / "skinned.glb");
    ASSERT_TRUE(lines) << lines.error().message;
    test::GlbParts parts = test::split(*readFile(folder_ / "skinned.glb", 1u << 24));
    const std::string name = "DPL_skinned_gaussian_splatting";
    EXPECT_EQ(parts.json["extensionsUsed"], nlohmann::json::array({"KHR_materials_unlit", name}));
    EXPECT_FALSE(parts.json.contains("extensionsRequired")) << "others show the mesh";
    uint32_t count = 0;
    for (size_t l = 0; l < avatar_.mesh.layers.size(); ++l) {
        const LayerData& layer = avatar_.mesh.layers[l];
        const nlohmann::json& extension = parts.json["meshes"][l]["primitives"][0]["extensions"][name];
        EXPECT_EQ(extension["lowPassVariance"], avatar_.kappaPx2);
        auto bytes = [&](const char* attribute) { return parts.accessor(extension["attributes"][attribute].get<size_t>()); };
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
    EXPECT_EQ(lines->find("not in"), std::string::npos) << *lines;
}

TEST_F(ExportSkinnedSplats, theyLeaveOutLayersWithoutSplatsAndAreRefusedWhereThereAreNone) {
    AvatarData bare = avatar_;
    const LayerData& first = bare.mesh.layers[0];
    const uint32_t gone = bare.splats.triangleStart[first.triangleCount], floats = shCoefficientCount(bare.splats.shDegree) * 3;
    auto cut = [&](auto& values, size_t each) { values.erase(values.begin(), values.begin() + std::ptrdiff_t(gone * each)); };
    cut(bare.splats.uv, 1), cut(bare.splats.phi, 1), cut(bare.splats.scaleM, 1), cut(bare.splats.opacity, 1), cut(bare.splats.flags, 1);
    cut(bare.splats.sh, floats);
    for (uint32_t& start : bare.splats.triangleStart) start = start > gone ? start - gone : 0;
    const std::vector<Vec3f> normals(bare.mesh.restPositions.size(), Vec3f(0, 0, 1));
    const auto file = writeGltfSkinnedSplats(bare, normals);
    ASSERT_TRUE(file) << file.error().message;
    const nlohmann::json json = test::split(*file).json;
    EXPECT_FALSE(json["meshes"][0]["primitives"][0].contains("extensions"));
    EXPECT_TRUE(json["meshes"][1]["primitives"][0].contains("extensions"));
    bare.splats = {};
    bare.splats.triangleStart.assign(bare.mesh.triangles.size() + 1, 0);
    EXPECT_NE(writeGltfSkinnedSplats(bare, normals).error().message.find("no splats"), std::string::npos);
}

TEST_F(ExportSkinnedSplats, theySayWhatTheyCannotHold) {
    const AvatarData moving = test::withCorrectives(avatar_, 1);
    ASSERT_TRUE(bool(writeFileAtomically(folder_ / "moving.glb", *writeAvatar(moving))));
    const auto lines = exportSkinnedSplats(folder_ / "moving.glb", folder_ / "skinned.glb");
    ASSERT_TRUE(lines) << lines.error().message;
    EXPECT_NE(lines->find("not in skinned.glb: pose correctives"), std::string::npos) << *lines;
}

TEST_F(ExportSkinnedSplats, theyRefuseOtherEndings) {
    const auto ply = exportSkinnedSplats(folder_ / "avatar.glb", folder_ / "skinned.ply");
    ASSERT_FALSE(ply);
    EXPECT_NE(ply.error().message.find("skinned.ply: with --skinned-splats the file must end in .glb"), std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "skinned.ply"));
}

}  // namespace
}  // namespace dpl
