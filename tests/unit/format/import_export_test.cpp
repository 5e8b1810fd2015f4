// SPDX-License-Identifier: Apache-2.0
// PLY, KHR_gaussian_splatting and skinned glTF, as other programs use them; and pinned avatar files of versions 1 to 3.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "sdk/format/gltf_splats.h"
#include "sdk/format/ply.h"
#include "sdk/format/skinned_gltf.h"
#include "tests/unit/format/glb_parts.h"
#include "tests/unit/format/sample_avatars.h"
#include "tests/unit/shared_data.h"

namespace dpl {
namespace {

std::vector<uint8_t> fileBytes(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

StaticSplatData someSplats(uint32_t degree) {
    StaticSplatData s;
    s.shDegree = degree;
    for (int i = 0; i < 5; ++i) {
        s.position.emplace_back(i, i * 0.5f, -i), s.rotation.push_back(glm::normalize(Quatf(1, 0.1f * i, 0.2f, -0.3f)));
        s.scaleM.emplace_back(0.01f * (i + 1), 0.02f, 0.003f), s.opacity.push_back(0.1f + 0.2f * i);
        for (uint32_t k = 0; k < shCoefficientCount(degree) * 3; ++k) s.sh.push_back(0.01f * k + i);
    }
    return s;
}

TEST(AvatarVersion1, pinnedBytesStillRead) {
    const auto bytes = fileBytes(sourceFolder() / "tests/unit/format/pinned/avatar_v1.glb");
    ASSERT_FALSE(bytes.empty());
    auto a = readAvatar(bytes);
    ASSERT_TRUE(a) << a.error().message;
    EXPECT_EQ(a->name, "tiny");
    ASSERT_EQ(a->joints.size(), 2u);
    EXPECT_EQ(a->joints[1].name, "spine");
    EXPECT_EQ(a->joints[1].restPosition, Vec3f(0, 1.25f, 0));
    EXPECT_EQ(a->joints[0].humanoidBone, "hips");
    ASSERT_EQ(a->mesh.restPositions.size(), 4u);
    EXPECT_EQ(a->mesh.restPositions[3], Vec3f(0, 1.5f, 0.25f));
    EXPECT_EQ(a->mesh.colours[2], glm::u8vec4(200, 120, 10, 255));
    EXPECT_EQ(a->mesh.jointWeights[1], glm::u8vec4(128, 127, 0, 0));
    EXPECT_EQ(a->mesh.triangles[1], glm::uvec3(0, 2, 3));
    EXPECT_EQ(a->splats.triangleStart, (std::vector<uint32_t>{0, 2, 3}));
    // Exact: the codes decoded in double by the documented formulas, rounded to float.
    EXPECT_EQ(a->splats.uv[1], Vec2f(0.5f, 0.25f));
    EXPECT_EQ(a->splats.phi[1], float(326 * 3.14159265358979323846 / 1024));
    EXPECT_EQ(a->splats.scaleM[0].y, 0.002f);  // the smallest and the largest scale of a chunk are exact
    EXPECT_EQ(a->splats.scaleM[1], Vec2f(0.02f, 0.02f));
    EXPECT_NEAR(a->splats.scaleM[0].x, 0.01f, 0.01f * std::log(10.0) / 2047 / 2);
    EXPECT_EQ(a->splats.opacity[1], float(128 / 255.0));
    EXPECT_EQ(a->splats.flags, (std::vector<uint8_t>{kSplatSingleFace, kSplatCloth, 0}));
    EXPECT_EQ(a->splats.sh[3], -1.0f);
    EXPECT_EQ(a->splats.sh[5], 1.0f);
    ASSERT_EQ(a->clips.size(), 1u);
    EXPECT_EQ(a->clips[0].rootTranslations[1], Vec3f(0, 0.125f, 0));
    EXPECT_EQ(a->evidence[0].reason, "gain below 0.1 dB");
}

TEST(AvatarVersion2, pinnedBytesStillRead) {
    const auto bytes = fileBytes(sourceFolder() / "tests/unit/format/pinned/avatar_v2.glb");
    ASSERT_FALSE(bytes.empty());
    auto a = readAvatar(bytes);
    ASSERT_TRUE(a) << a.error().message;
    const PoseCorrectiveData& c = a->correctives;
    EXPECT_EQ(c.modeCount, 2u);
    EXPECT_EQ(c.nodeCount, 2u);
    EXPECT_EQ(c.joints, (std::vector<uint32_t>{1}));
    EXPECT_EQ(c.mean, (std::vector<float>{0, 0.125f, 0, -0.25f, 0, 0}));
    EXPECT_EQ(c.modes, (std::vector<float>{1, 0, 0, 0, 0, 0, 0, 0, 0.5f, 0, 0, -0.75f}));
    EXPECT_EQ(c.reach, 1.25f);
    EXPECT_EQ(c.reachOffModes, 1e6f) << "absent: nothing fades";
    ASSERT_EQ(c.nodeIndices.size(), 4u);
    EXPECT_EQ(c.nodeIndices[2], glm::u16vec4(1, 0, 0, 0));
    EXPECT_EQ(c.nodeWeights[2], glm::u8vec4(200, 55, 0, 0));
    // Exact: the largest magnitude of a mode and component is stored as float, other values are code / 32767 of it.
    ASSERT_EQ(c.nodes.size(), 4u);
    EXPECT_EQ(c.nodes[0], Vec4f(0.02f, 0, 0, -0.5f));
    EXPECT_EQ(c.nodes[1], Vec4f(0, -0.01f, 0, 0.25f));
    EXPECT_EQ(c.nodes[2], Vec4f(float(-16384 * double(0.02f) / 32767), 0, 0, float(16384 * 0.5 / 32767)));
    EXPECT_EQ(c.nodes[3], Vec4f(0, float(8192 * double(0.01f) / 32767), 0, 0));
    EXPECT_EQ(*writeAvatar(*a), bytes);
}

TEST(AvatarVersion3, pinnedBytesStillRead) {
    const auto bytes = fileBytes(sourceFolder() / "tests/unit/format/pinned/avatar_v3.glb");
    ASSERT_FALSE(bytes.empty());
    auto a = readAvatar(bytes);
    ASSERT_TRUE(a) << a.error().message;
    const PoseCorrectiveData& c = a->correctives;
    const MotionModeData& m = c.motion;
    EXPECT_EQ(c.modeCount, 2u);
    ASSERT_EQ(m.groups.size(), 2u);
    EXPECT_EQ(m.groups[0].columnCount, 1u);
    EXPECT_EQ(m.groups[1].columnCount, 1u);
    EXPECT_EQ(m.groups[0].reach, 2.0f);
    EXPECT_EQ(m.groups[1].reach, 0.75f);
    EXPECT_EQ(m.joints, (std::vector<uint32_t>{1}));
    EXPECT_EQ(m.still, (std::vector<Vec4f>{{0, 0, 0.6f, 0.8f}}));
    EXPECT_EQ(m.rangeRad, (std::vector<Vec2f>{{0.0625f, 1.5f}}));
    EXPECT_EQ(m.movedFromRad, 0.125f);
    EXPECT_EQ(m.movedToRad, 0.375f);
    EXPECT_EQ(m.holdsS, (std::vector<float>{0, 1.5f}));
    EXPECT_EQ(m.modes, (std::vector<float>{1, 0, 0, 0, -0.5f, 1.25f, 0, 0}));
    ASSERT_EQ(c.nodes.size(), 8u);
    EXPECT_EQ(c.nodes[2], Vec4f(0, 0, 0.03f, 0));
    EXPECT_EQ(c.nodes[7], Vec4f(0, 0, 0, -0.5f));
    EXPECT_EQ(*writeAvatar(*a), bytes);
}

TEST(Ply, writesAndReadsEveryDegreeWithAndWithoutNormals) {
    for (uint32_t degree = 0; degree <= 3; ++degree)
        for (bool normals : {true, false}) {
            const StaticSplatData s = someSplats(degree);
            auto bytes = writePly(s, {.normals = normals});
            ASSERT_TRUE(bytes);
            auto back = readPly(*bytes);
            ASSERT_TRUE(back) << back.error().message;
            EXPECT_EQ(back->shDegree, degree);
            EXPECT_TRUE(back->position == s.position);
            EXPECT_TRUE(back->sh == s.sh);
            for (int i = 0; i < 5; ++i) {
                EXPECT_NEAR(back->opacity[i], s.opacity[i], 1e-6);        // logit and sigmoid in float
                EXPECT_NEAR(back->scaleM[i].x / s.scaleM[i].x, 1, 1e-6);  // log and exp in float
                EXPECT_LT(glm::length(back->rotation[i] - s.rotation[i]), 1e-6f);
            }
        }
    auto padded = writePly(someSplats(0), {.padToDegree3 = true});
    const std::string text(padded->begin(), padded->end());
    const size_t body = padded->size() - (text.find("end_header\n") + 11);
    EXPECT_EQ(body, 5u * 62 * 4);
    EXPECT_EQ(readPly(*padded)->shDegree, 3u);
}

TEST(Ply, damagedFilesAreRefused) {
    const std::vector<uint8_t> good = *writePly(someSplats(1));
    for (size_t size = 0; size < good.size(); size += 7) EXPECT_FALSE(readPly(std::span(good).first(size))) << size;
    auto changed = [&](const std::string& from, const std::string& to) {
        std::string text(good.begin(), good.end());
        const size_t at = text.find(from);
        EXPECT_NE(at, std::string::npos);
        text.replace(at, from.size(), to);
        return readPly(std::span(reinterpret_cast<const uint8_t*>(text.data()), text.size()));
    };
    EXPECT_FALSE(changed("vertex 5", "vertex 6"));
    EXPECT_FALSE(changed("vertex 5", "vertex 99999999999999999999"));
    EXPECT_FALSE(changed("float opacity", "float opacities"));
    EXPECT_FALSE(changed("float f_rest_8", "float g_rest_8"));
    EXPECT_FALSE(changed("float x", "list x"));
    EXPECT_FALSE(changed("binary_little_endian", "ascii"));
    std::vector<uint8_t> bad = good;
    const uint32_t nan = 0x7fc00000;
    std::memcpy(bad.data() + bad.size() - 4, &nan, 4);
    EXPECT_EQ(readPly(bad)->count(), 4u) << "the last splat is left out";
}

TEST(Ply, readsAFileOfAnotherProgram) {
    const auto shared = sharedData();
    if (!shared || !std::filesystem::exists(*shared / "splats/donut.inria-sh0.ply"))
        GTEST_SKIP() << "no shared data with splats/donut.inria-sh0.ply";
    auto s = readPly(fileBytes(*shared / "splats/donut.inria-sh0.ply"));
    ASSERT_TRUE(s) << s.error().message;
    EXPECT_EQ(s->count(), 45624u);
    EXPECT_EQ(s->shDegree, 0u);
}

TEST(GltfSplats, holdsWhatTheExtensionAsksFor) {
    const StaticSplatData s = someSplats(1);
    auto bytes = writeGltfSplats(s);
    ASSERT_TRUE(bytes) << bytes.error().message;
    auto parts = test::split(*bytes);
    const auto& primitive = parts.json["meshes"][0]["primitives"][0];
    EXPECT_EQ(primitive["mode"], 0);
    EXPECT_EQ(primitive["extensions"]["KHR_gaussian_splatting"]["kernel"], "ellipse");
    EXPECT_EQ(primitive["attributes"].size(), 2 + 3 + 4u);
    const auto scale = parts.accessor(primitive["attributes"]["KHR_gaussian_splatting:SCALE"].get<size_t>());
    float first;
    std::memcpy(&first, scale.data(), 4);
    EXPECT_EQ(first, 0.01f);  // linear, as ratified
    EXPECT_FALSE(writeGltfSplats({}));
}

TEST(SkinnedGltf, readsAnAvatarAsAnyBody) {
    const AvatarData a = test::layeredAvatar(5, 0, 12, 4);
    for (bool draco : {true, false}) {
        auto body = readSkinnedGltf(*writeAvatar(a, {.draco = draco}));
        ASSERT_TRUE(body) << body.error().message;
        ASSERT_EQ(body->meshes.size(), 3u);
        ASSERT_EQ(body->joints.size(), 12u);
        EXPECT_TRUE(body->meshes[1].skinned);
        EXPECT_EQ(body->meshes[0].positions.size(), a.mesh.layers[0].vertexCount);
        EXPECT_EQ(body->meshes[0].triangles[3], a.mesh.triangles[3]);
        const auto world = body->restTransforms();
        for (const auto& joint : body->joints) {  // at rest, joint transform and inverse bind matrix cancel
            const Mat4f m = world[joint.node] * joint.jointFromMesh;
            for (int c = 0; c < 4; ++c) EXPECT_LT(glm::length(m[c] - Mat4f(1)[c]), 1e-5f);
        }
        for (size_t n = 0; n < body->nodes.size(); ++n) EXPECT_LT(body->nodes[n].parent, int32_t(n));
        ASSERT_EQ(body->animations.size(), 2u);
        EXPECT_NEAR(body->animations[0].endS(), 4 / 30.0, 1e-6);
    }
}

TEST(SkinnedGltf, aBodyWithoutSkinWeightsIsNamedSo) {
    auto parts = test::split(*writeAvatar(test::tinyAvatar(), {.draco = false}));
    parts.json["meshes"][0]["primitives"][0]["attributes"].erase("WEIGHTS_0");
    auto body = readSkinnedGltf(parts.bytes());
    ASSERT_FALSE(body);
    EXPECT_EQ(int(body.error().code), int(Code::NotFound));
    EXPECT_NE(body.error().message.find("no skin weights"), std::string::npos);
    SkinnedGltfOptions clipsOnly;
    clipsOnly.requireSkin = false;
    EXPECT_TRUE(readSkinnedGltf(parts.bytes(), clipsOnly));
}

TEST(SkinnedGltf, morphTargetsWithNamesAlsoSparse) {
    auto parts = test::split(*writeAvatar(test::tinyAvatar(), {.draco = false}));
    const size_t at = parts.bin.size();
    const float offset[3] = {0, 0.5f, 0};
    const uint16_t index[2] = {2, 0};
    parts.bin.resize(at + 16);
    std::memcpy(parts.bin.data() + at, offset, 12), std::memcpy(parts.bin.data() + at + 12, index, 4);
    auto& j = parts.json;
    j["buffers"][0]["byteLength"] = parts.bin.size();
    const size_t values = j["bufferViews"].size(), accessor = j["accessors"].size();
    j["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", at}, {"byteLength", 12}});
    j["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", at + 12}, {"byteLength", 2}});
    j["accessors"].push_back(
        {{"componentType", 5126},
         {"type", "VEC3"},
         {"count", 4},
         {"sparse",
          {{"count", 1}, {"indices", {{"bufferView", values + 1}, {"componentType", 5123}}}, {"values", {{"bufferView", values}}}}}});
    j["meshes"][0]["primitives"][0]["targets"] = nlohmann::json::array({{{"POSITION", accessor}}, {{"POSITION", 0}}});
    j["meshes"][0]["extras"]["targetNames"] = {"height"};
    j["meshes"][0]["weights"] = {0.25, 0};
    auto body = readSkinnedGltf(parts.bytes());
    ASSERT_TRUE(body) << body.error().message;
    ASSERT_EQ(body->meshes[0].morphs.size(), 2u);
    EXPECT_EQ(body->meshes[0].morphs[0].name, "height");
    EXPECT_EQ(body->meshes[0].morphs[1].name, "morph1");
    EXPECT_EQ(body->meshes[0].morphs[0].restWeight, 0.25f);
    EXPECT_EQ(body->meshes[0].morphs[0].offsets[2], Vec3f(0, 0.5f, 0));
    EXPECT_EQ(body->meshes[0].morphs[0].offsets[0], Vec3f(0));
    const uint16_t far = 4;
    std::memcpy(parts.bin.data() + at + 12, &far, 2);
    EXPECT_FALSE(readSkinnedGltf(parts.bytes()));
}

TEST(SkinnedGltf, sampleChannelInterpolates) {
    SkinnedGltf::Channel c;
    c.path = SkinnedGltf::Path::Translation, c.timesS = {1, 3}, c.values = {{0, 0, 0, 0}, {2, 4, 6, 0}};
    EXPECT_EQ(sampleChannel(c, 0), Vec4f(0));
    EXPECT_EQ(sampleChannel(c, 2), Vec4f(1, 2, 3, 0));
    EXPECT_EQ(sampleChannel(c, 9), Vec4f(2, 4, 6, 0));
    c.interpolation = SkinnedGltf::Interpolation::Step;
    EXPECT_EQ(sampleChannel(c, 2.9f), Vec4f(0));
    c.interpolation = SkinnedGltf::Interpolation::Cubic;
    c.values = {{}, {0, 0, 0, 0}, {}, {}, {2, 4, 6, 0}, {}};
    EXPECT_EQ(sampleChannel(c, 2), Vec4f(1, 2, 3, 0));  // with zero tangents the middle is the mean
    c.interpolation = SkinnedGltf::Interpolation::Linear, c.path = SkinnedGltf::Path::Rotation;
    const float h = std::sqrt(0.5f);
    c.values = {{0, 0, 0, 1}, {0, 0, -h, -h}};  // takes the shorter arc, although the signs differ
    EXPECT_NEAR(sampleChannel(c, 2).z, std::sin(0.7853981634 / 2), 1e-6);
}

}  // namespace
}  // namespace dpl
