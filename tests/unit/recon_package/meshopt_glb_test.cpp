// SPDX-License-Identifier: Apache-2.0
// A mesh in the codecs of EXT_meshopt_compression is the mesh that went in.
#include "reconstruction/output/package/meshopt_glb.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sdk/format/avatar_file.h"
#include "sdk/format/gltf_mesh.h"
#include "sdk/format/skinned_gltf.h"
#include "tests/unit/format/one_pixel_png.h"
#include "tests/unit/format/sample_avatars.h"
#include "tests/unit/recon_package/meshopt_decoder.h"

namespace dpl {
namespace {

/** A mesh with everything that is compressed: layers, expressions (one of a few vertices, one of all), clips. */
struct Written {
    AvatarData avatar;
    std::vector<Vec3f> normals;
    std::vector<Vec2f> uv;
    std::vector<MeshMorph> morphs;
    std::vector<uint8_t> glb;

    Written() {
        avatar = *decodedAvatar(test::layeredAvatar(5, 0, 8, 20));
        const size_t count = avatar.mesh.restPositions.size();
        MeshMorph few{2, {3, 4, 9, 200}, {}, {}}, all{17, {}, {}, {}};
        for (uint32_t v = 0; v < count; ++v) {
            const float angle = float(v) * 0.37f;
            normals.emplace_back(std::cos(angle) * 0.6f, std::sin(angle) * 0.6f, 0.8f);
            uv.emplace_back(std::fmod(float(v) * 0.01f, 1.0f), std::fmod(float(v) * 0.007f, 1.0f));
            all.vertices.push_back(v), all.offsetsM.emplace_back(0, float(v % 64) * kPositionStepM, kPositionStepM);
        }
        few.offsetsM.assign(few.vertices.size(), Vec3f(40 * kPositionStepM, 0, -3 * kPositionStepM));
        few.turns.assign(few.vertices.size(), Vec3f(0.25f, 0, 0)), all.turns.assign(count, Vec3f(0));
        morphs = {few, all};
        const std::vector<uint8_t> png = test::onePixelPng();
        auto file = writeGltfMesh(avatar, normals, {uv, png}, {.morphs = morphs});
        EXPECT_TRUE(file) << file.error().message;
        if (file) glb = std::move(*file);
    }
};

TEST(MeshoptGlb, decodesToTheMeshThatWentIn) {
    const Written written;
    const auto coded = compressByMeshopt(written.glb);
    ASSERT_TRUE(coded) << coded.error().message;
    EXPECT_LT(2 * coded->size(), written.glb.size());
    const std::vector<uint8_t> plain = test::withoutMeshopt(*coded);
    const auto before = readSkinnedGltf(written.glb), after = readSkinnedGltf(plain);
    ASSERT_TRUE(before) << before.error().message;
    ASSERT_TRUE(after) << after.error().message;
    ASSERT_EQ(after->meshes.size(), before->meshes.size());
    for (size_t m = 0; m < before->meshes.size(); ++m) {
        const SkinnedGltf::Mesh &a = before->meshes[m], &b = after->meshes[m];
        EXPECT_EQ(a.positions, b.positions);
        EXPECT_EQ(a.jointIndices, b.jointIndices);
        EXPECT_EQ(a.jointWeights, b.jointWeights);
        ASSERT_EQ(a.triangles.size(), b.triangles.size());
        for (size_t t = 0; t < a.triangles.size(); ++t) {  // the codec may begin a triangle at another corner
            glm::uvec3 c = b.triangles[t];
            for (int turn = 0; turn < 3 && c != a.triangles[t]; ++turn) c = {c.y, c.z, c.x};
            ASSERT_EQ(c, a.triangles[t]) << t;
        }
        for (size_t v = 0; v < a.uv.size(); ++v)
            ASSERT_LE(std::max(std::abs(a.uv[v].x - b.uv[v].x), std::abs(a.uv[v].y - b.uv[v].y)), kMeshoptStep / 2) << v;
        ASSERT_EQ(a.morphs.size(), b.morphs.size());
        for (size_t i = 0; i < a.morphs.size(); ++i) {
            EXPECT_EQ(a.morphs[i].name, b.morphs[i].name);
            EXPECT_EQ(a.morphs[i].offsets, b.morphs[i].offsets);
        }
    }
    ASSERT_EQ(after->animations.size(), before->animations.size());
    for (size_t c = 0; c < before->animations.size(); ++c)
        for (size_t k = 0; k < before->animations[c].channels.size(); ++k) {
            const SkinnedGltf::Channel &a = before->animations[c].channels[k], &b = after->animations[c].channels[k];
            EXPECT_EQ(a.timesS, b.timesS);
            for (size_t i = 0; i < a.values.size(); ++i)
                for (int axis = 0; axis < 4; ++axis) ASSERT_NEAR(a.values[i][axis], b.values[i][axis], kMeshoptStep) << c << " " << k;
        }
}

TEST(MeshoptGlb, normalsStayWithinHalfAStep) {
    const Written written;
    test::GlbParts plain = test::split(test::withoutMeshopt(*compressByMeshopt(written.glb))), before = test::split(written.glb);
    for (size_t m = 0; m < before.json["meshes"].size(); ++m) {
        const auto normals = [&](test::GlbParts& parts) {
            return parts.accessor(parts.json["meshes"][m]["primitives"][0]["attributes"]["NORMAL"].get<size_t>());
        };
        const auto a = normals(before), b = normals(plain);
        ASSERT_EQ(a.size(), b.size());
        for (size_t i = 0; i < a.size(); i += sizeof(float)) {
            float x, y;
            std::memcpy(&x, a.data() + i, sizeof x), std::memcpy(&y, b.data() + i, sizeof y);
            ASSERT_LE(std::abs(x - y), kMeshoptNormalStep / 2);
        }
    }
}

TEST(MeshoptGlb, anotherOrderIsTheSameMesh) {
    const Written written;
    SeamedMesh seamed{written.avatar.mesh, {}, written.uv};
    for (uint32_t v = 0; v < written.uv.size(); ++v) seamed.old.push_back(v);
    SeamedMesh ordered = seamed;
    orderForMeshopt(ordered);
    EXPECT_NE(ordered.mesh.triangles, seamed.mesh.triangles);
    const auto corners = [](const SeamedMesh& s, const LayerData& layer) {
        std::vector<std::array<uint32_t, 3>> out;
        for (uint32_t t = layer.firstTriangle; t < layer.firstTriangle + layer.triangleCount; ++t) {
            std::array<uint32_t, 3> c;
            for (int k = 0; k < 3; ++k) c[size_t(k)] = s.old[s.mesh.triangles[t][k]];
            std::rotate(c.begin(), std::min_element(c.begin(), c.end()), c.end());
            out.push_back(c);
        }
        std::sort(out.begin(), out.end());
        return out;
    };
    for (size_t l = 0; l < seamed.mesh.layers.size(); ++l)
        EXPECT_EQ(corners(ordered, ordered.mesh.layers[l]), corners(seamed, seamed.mesh.layers[l])) << "each layer keeps its triangles";
    for (size_t v = 0; v < ordered.old.size(); ++v) {
        EXPECT_EQ(ordered.mesh.restPositions[v], seamed.mesh.restPositions[ordered.old[v]]);
        EXPECT_EQ(ordered.uv[v], seamed.uv[ordered.old[v]]);
        EXPECT_EQ(ordered.mesh.jointWeights[v], seamed.mesh.jointWeights[ordered.old[v]]);
    }
}

TEST(MeshoptGlb, refusesWhatIsNoGlb) {
    const Written written;
    for (const size_t bytes : {size_t(0), size_t(11), written.glb.size() / 2, written.glb.size() - 1})
        EXPECT_FALSE(compressByMeshopt(std::span(written.glb).first(bytes))) << bytes;
}

}  // namespace
}  // namespace dpl
