// SPDX-License-Identifier: Apache-2.0
// glTF KHR_gaussian_splatting: files by Doppel, by splat-transform, and damaged ones.
#include "sdk/format/gltf_splats.h"

#include <cstring>

#include "sdk/math/sh_rotation.h"
#include "tests/unit/format/glb_parts.h"
#include "tests/unit/format/splat_files.h"

namespace dpl {
namespace {

using namespace test;

constexpr Tolerance kExact = {1e-6f, 1e-6f, 1e-6f, 1e-6f, 1e-6f, 1e-6f};

TEST(GltfSplats, readsBackWhatWeWriteAtEveryShDegree) {
    for (uint32_t degree = 0; degree <= 3; ++degree) {
        const StaticSplatData want = ofDegree(degree);
        auto file = readSplats(*writeGltfSplats(want));
        ASSERT_TRUE(file) << file.error().message;
        EXPECT_EQ(file->format, SplatFormat::Gltf);
        EXPECT_FALSE(file->splats.compensated);
        expectSplats(file->splats, want, kExact);
    }
}

TEST(GltfSplats, readsWhatSplatTransformWrites) {
    auto file = readSplats(pinned("splats_khr.glb"));
    ASSERT_TRUE(file) << file.error().message;
    StaticSplatData want = pinnedSplats();
    const Mat3d halfTurn(-1, 0, 0, 0, -1, 0, 0, 0, 1);  // splat-transform takes a PLY as y-down and rotates it upright about z
    const ShTurn<double> turn = ShRotator().turn(halfTurn, 3);
    for (size_t i = 0; i < want.count(); ++i) {
        want.position[i] = Mat3f(halfTurn) * want.position[i];
        want.rotation[i] = Quatf(0, 0, 0, 1) * want.rotation[i];
        turn.apply(&want.sh[i * 48]);
    }
    expectSplats(file->splats, want, {1e-6f, 1e-6f, 1e-5f, 1e-6f, 1e-6f, 2e-6f});
}

/** The transform of a node applies to positions, axes and the directions of SH. */
TEST(GltfSplats, nodesPlaceTheirSplats) {
    const StaticSplatData one = ofDegree(3);
    auto parts = test::split(*writeGltfSplats(one));
    parts.json["nodes"] = {{{"children", {1}}, {"translation", {1, 2, 3}}, {"rotation", {0, 0.70710678, 0, 0.70710678}}},
                           {{"mesh", 0}, {"scale", {2, 2, 2}}, {"rotation", {0.6, 0, 0, 0.8}}, {"translation", {0.5, -1, 2}}}};
    auto placed = readGltfSplats(parts.bytes());
    ASSERT_TRUE(placed) << placed.error().message;
    const Quatf outer(0.70710678f, 0, 0.70710678f, 0), turn = outer * Quatf(0.8f, 0.6f, 0, 0);
    const Vec3f direction = glm::normalize(Vec3f(0.3f, -0.5f, 0.8f));
    for (size_t i = 0; i < one.count(); ++i) {
        EXPECT_LT(glm::length(placed->position[i] - (turn * (2.0f * one.position[i]) + outer * Vec3f(0.5f, -1, 2) + Vec3f(1, 2, 3))),
                  1e-5f);
        EXPECT_LT(glm::length(placed->scaleM[i] - 2.0f * one.scaleM[i]), 1e-6f);
        EXPECT_GT(std::abs(glm::dot(placed->rotation[i], turn * one.rotation[i])), 0.99999f);
        const Vec3f was = shColour(&one.sh[i * 48], 3, direction), is = shColour(&placed->sh[i * 48], 3, turn * direction);
        EXPECT_LT(glm::length(is - was), 1e-5f) << i;
    }
    parts.json["nodes"][1]["scale"] = {2, 2, 2.1};
    expectRefused(readSplats(parts.bytes()), "axes scaled differently", Code::Unsupported, "apply its transform");
    parts.json["nodes"][1]["scale"] = {-1, -1, -1};
    expectRefused(readSplats(parts.bytes()), "a mirror", Code::Unsupported, "mirrors");
}

/** Two primitives of different SH degree become one set; a mesh beside them is skipped. Integer attributes decode as the extension says. */
TEST(GltfSplats, primitivesAreJoinedAndIntegersDecoded) {
    auto parts = test::split(*writeGltfSplats(ofDegree(1)));
    const size_t at = parts.bin.size();
    const auto addAttribute = [&](const Bytes& raw, int component, const char* type, bool normalized) {
        const size_t offset = parts.bin.size(), index = parts.json["accessors"].size();
        parts.bin.insert(parts.bin.end(), raw.begin(), raw.end());
        while (parts.bin.size() % 4) parts.bin.push_back(0);
        parts.json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", raw.size()}});
        parts.json["accessors"].push_back({{"bufferView", parts.json["bufferViews"].size() - 1},
                                           {"componentType", component},
                                           {"type", type},
                                           {"count", 1},
                                           {"normalized", normalized}});
        return index;
    };
    Bytes place, colour;
    for (const float v : {9.0f, 8.0f, 7.0f}) append(place, v), append(colour, v / 10);
    nlohmann::json attributes;
    attributes["POSITION"] = addAttribute(place, 5126, "VEC3", false);
    attributes["KHR_gaussian_splatting:ROTATION"] = addAttribute({0, 127, 0, 0}, 5120, "VEC4", true);
    attributes["KHR_gaussian_splatting:SCALE"] = addAttribute({1, 2, 3}, 5121, "VEC3", false);
    attributes["KHR_gaussian_splatting:OPACITY"] = addAttribute({51}, 5121, "SCALAR", true);
    attributes["KHR_gaussian_splatting:SH_DEGREE_0_COEF_0"] = addAttribute(colour, 5126, "VEC3", false);
    ASSERT_GT(parts.bin.size(), at);
    parts.json["buffers"][0]["byteLength"] = parts.bin.size();
    nlohmann::json primitive = parts.json["meshes"][0]["primitives"][0], plain = primitive;
    primitive["attributes"] = attributes;
    plain.erase("extensions");
    parts.json["meshes"][0]["primitives"].push_back(primitive);
    parts.json["meshes"][0]["primitives"].push_back(plain);
    auto s = readGltfSplats(parts.bytes());
    ASSERT_TRUE(s) << s.error().message;
    ASSERT_EQ(s->count(), 8u);
    EXPECT_EQ(s->shDegree, 1u);
    EXPECT_EQ(s->position[7], Vec3f(9, 8, 7));
    EXPECT_EQ(s->rotation[7], Quatf(0, 0, 1, 0));
    EXPECT_EQ(s->scaleM[7], Vec3f(1, 2, 3));
    EXPECT_FLOAT_EQ(s->opacity[7], 0.2f);
    EXPECT_FLOAT_EQ(s->sh[7 * 12 + 1], 0.8f);
    for (size_t k = 3; k < 12; ++k) EXPECT_EQ(s->sh[7 * 12 + k], 0);
}

TEST(GltfSplats, rejectList) {
    const auto changed = [](auto change) {
        auto parts = test::split(*writeGltfSplats(ofDegree(1)));
        change(parts, parts.json["meshes"][0]["primitives"][0]);
        return readSplats(parts.bytes());
    };
    const auto with = [&](const char* key, const char* value) {
        return changed([&](auto&, auto& p) { p["extensions"]["KHR_gaussian_splatting"][key] = value; });
    };
    expectRefused(with("kernel", "cube"), "a kernel", Code::Unsupported, "'cube'");
    expectRefused(with("projection", "fisheye"), "a projection", Code::Unsupported, "'fisheye'");
    expectRefused(with("colorSpace", "lin_rec709_display"), "linear colour", Code::Unsupported, "srgb_rec709_display");
    expectRefused(with("sortingMethod", "none"), "unsorted", Code::Unsupported, "'none'");
    expectRefused(changed([](auto&, auto& p) {
                      p["extensions"]["KHR_gaussian_splatting"]["extensions"]["KHR_gaussian_splatting_compression_spz_2"]["bufferView"] = 0;
                  }),
                  "compressed", Code::Unsupported, "compression_spz_2");
    expectRefused(changed([](auto&, auto& p) { p["mode"] = 4; }), "triangles", Code::CorruptData, "mode 4");
    for (const char* name :
         {"POSITION", "KHR_gaussian_splatting:ROTATION", "KHR_gaussian_splatting:SCALE", "KHR_gaussian_splatting:OPACITY",
          "KHR_gaussian_splatting:SH_DEGREE_0_COEF_0", "KHR_gaussian_splatting:SH_DEGREE_1_COEF_2"})
        expectRefused(changed([&](auto&, auto& p) { p["attributes"].erase(name); }), name, Code::CorruptData, name);
    expectRefused(changed([](auto& parts, auto& p) {
                      parts.json["accessors"][p["attributes"]["KHR_gaussian_splatting:OPACITY"].template get<size_t>()]["count"] = 6;
                  }),
                  "six opacities", Code::CorruptData, "6 entries");
    const auto damaged = [&](const char* attribute, size_t index, float value) {
        return changed([&](auto& parts, auto& p) {
            std::memcpy(parts.accessor(p["attributes"][attribute].template get<size_t>()).data() + index * 4, &value, 4);
        });
    };
    expectRefused(damaged("KHR_gaussian_splatting:SCALE", 4, -0.1f), "a negative scale", Code::CorruptData, "negative");
    expectRefused(damaged("KHR_gaussian_splatting:OPACITY", 3, 1.5f), "an opacity of 1.5", Code::CorruptData, "opacity");
    expectRefused(damaged("KHR_gaussian_splatting:ROTATION", 3, 0.0f), "no rotation", Code::CorruptData, "rotation");
    expectRefused(changed([](auto& parts, auto&) { parts.json["nodes"][0].erase("mesh"); }), "shown by no node", Code::Unsupported,
                  "no node");
    expectRefused(changed([](auto& parts, auto&) {
                      for (int i = 0; i < 9; ++i) parts.json["nodes"].push_back({{"mesh", 0}});
                  }),
                  "ten instances", Code::CorruptData, "more than once");
    expectRefused(changed([](auto& parts, auto&) {
                      parts.json["nodes"][0]["scale"] = {1e38, 1e38, 1e38}, parts.json["nodes"][0]["translation"] = {1e38, 3e38, 0};
                  }),
                  "beyond float", Code::CorruptData, "not finite");
}

TEST(GltfSplats, truncatedFilesAndFlippedBitsDoNoHarm) {
    expectSturdy(*writeGltfSplats(ofDegree(0)));
}

}  // namespace
}  // namespace dpl
