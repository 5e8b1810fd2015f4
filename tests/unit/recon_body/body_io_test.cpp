// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/body_io.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "small_body.h"
#include "tests/unit/format/glb_parts.h"

namespace dpl {
namespace {

TEST(BodyTools, smallBodyIsAHumanoidWithAllKeypointsButTheEyes) {
    const BodyModel body = smallBody();
    ASSERT_TRUE(checkBody(body)) << checkBody(body).error().message;
    EXPECT_EQ(body.keypoints.size(), 22u);
    EXPECT_GE(findHumanoid(body, "leftUpperArm"), 0);
    EXPECT_GE(findHumanoid(body, "rightLowerLeg"), 0);
    EXPECT_GE(findHumanoid(body, "hips"), 0);
}

TEST(BodyTools, shapedBodyMovesVerticesAndJointsAlike) {
    const BodyModel body = smallBody();
    const BodyModel tall = shapedBody(body, std::vector<double>{2.0, 0.0});
    EXPECT_NEAR(tall.joints[5].restPosition.y, body.joints[5].restPosition.y * 1.08f, 1e-5f);
    EXPECT_NEAR(tall.mesh.restPositions[20].y, body.mesh.restPositions[20].y * 1.08f, 1e-5f);
}

TEST(BodyTools, anchorPointReproducesAPointInsideTheSurface) {
    const BodyModel body = smallBody();
    std::vector<uint32_t> all;
    for (uint32_t v = 0; v < body.mesh.restPositions.size(); ++v) all.push_back(v);
    const Vec3f point(0.02f, 1.63f, 0.07f);
    Vec3f sum(0);
    float total = 0;
    for (auto [v, w] : anchorPoint(body.mesh, all, point)) sum += w * body.mesh.restPositions[v], total += w;
    EXPECT_NEAR(total, 1, 1e-5);
    EXPECT_LT(glm::length(sum - point), 1e-4f);  // anchorPoint's regularisation shifts the point by about 1e-6 of the neighbourhood's size
}

TEST(BodyTools, boneMorphsStretchOneBoneAndKeepTheFeetDown) {
    const BodyModel plain = smallBody(), body = withBoneMorphs(plain);
    ASSERT_TRUE(checkBody(body)) << checkBody(body).error().message;
    EXPECT_EQ(withBoneMorphs(body).morphs.size(), body.morphs.size());  // a second call adds nothing
    const auto length = [](const BodyModel& b, const char* from, const char* to) {
        return glm::length(b.joints[size_t(findHumanoid(b, from))].restPosition - b.joints[size_t(findHumanoid(b, to))].restPosition);
    };
    for (size_t m = plain.morphs.size(); m < body.morphs.size(); ++m) {
        std::vector<double> shape(body.morphs.size(), 0.0);
        shape[m] = 1;
        const BodyModel longer = shapedBody(body, shape);
        EXPECT_NEAR(longer.joints[size_t(findHumanoid(longer, "leftFoot"))].restPosition.y,
                    plain.joints[size_t(findHumanoid(plain, "leftFoot"))].restPosition.y, 1e-5f)
            << body.morphs[m].name;
        const float thigh = length(longer, "leftUpperLeg", "leftLowerLeg") / length(plain, "leftUpperLeg", "leftLowerLeg");
        const float forearm = length(longer, "rightLowerArm", "rightHand") / length(plain, "rightLowerArm", "rightHand");
        EXPECT_NEAR(thigh, body.morphs[m].name == "bone_upper_leg" ? 1.04f : 1.0f, 1e-4f) << body.morphs[m].name;
        EXPECT_NEAR(forearm, body.morphs[m].name == "bone_lower_arm" ? 1.04f : 1.0f, 1e-4f) << body.morphs[m].name;
    }
}

TEST(BodyTools, checkBodyNamesWhatIsWrong) {
    BodyModel body = smallBody();
    body.mesh.jointWeights.clear();
    ASSERT_FALSE(checkBody(body));
    EXPECT_NE(checkBody(body).error().message.find("no skin weights"), std::string::npos);
    body = smallBody();
    body.joints[3].restPosition.y = NAN;
    EXPECT_FALSE(checkBody(body));
    body = smallBody();
    body.keypoints[0].joints.push_back({1000, 0.5f});
    EXPECT_FALSE(checkBody(body));
    body = smallBody();
    body.morphs[0].vertexOffsets.pop_back();
    EXPECT_FALSE(checkBody(body));
}

TEST(BodyIo, ownBodyComesBackBitForBit) {
    BodyModel body = smallBody();
    body.keypoints.push_back({"eye_l", {{3, 0.25f}, {4, 0.75f}}, {}});
    const auto bytes = encodeBody(body);
    ASSERT_TRUE(bytes) << bytes.error().message;
    const auto back = decodeBody(*bytes, "fallback");
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->name, "small");
    EXPECT_EQ(back->mesh.restPositions, body.mesh.restPositions);
    EXPECT_EQ(back->mesh.colours, body.mesh.colours);
    EXPECT_EQ(back->mesh.triangles, body.mesh.triangles);
    EXPECT_EQ(back->mesh.jointWeights, body.mesh.jointWeights);
    ASSERT_EQ(back->joints.size(), body.joints.size());
    for (size_t j = 0; j < body.joints.size(); ++j) {
        EXPECT_EQ(back->joints[j].restPosition, body.joints[j].restPosition);
        EXPECT_EQ(back->joints[j].parent, body.joints[j].parent);
        EXPECT_EQ(back->joints[j].name, body.joints[j].name);
        EXPECT_EQ(back->joints[j].humanoidBone, body.joints[j].humanoidBone);
    }
    ASSERT_EQ(back->morphs.size(), 2u);
    EXPECT_EQ(back->morphs[1].jointOffsets, body.morphs[1].jointOffsets);
    EXPECT_EQ(back->morphs[1].vertexOffsets, body.morphs[1].vertexOffsets);
    ASSERT_EQ(back->keypoints.size(), body.keypoints.size());
    EXPECT_EQ(back->keypoints.back().vertices, body.keypoints.back().vertices);
    EXPECT_EQ(*encodeBody(*back), *bytes);
}

TEST(BodyIo, expressionsComeBackBitForBitAndAreNoShapeMorphs) {
    BodyModel body = smallBody();
    const size_t vertices = body.mesh.restPositions.size();
    body.expressions = {{0, std::vector<Vec3f>(vertices, Vec3f(0, -0.01f, 0))}, {17, std::vector<Vec3f>(vertices, Vec3f(0, -0.03f, 0))}};
    const auto bytes = encodeBody(body);
    ASSERT_TRUE(bytes) << bytes.error().message;
    const auto back = decodeBody(*bytes, "x");
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->morphs.size(), body.morphs.size());
    ASSERT_EQ(back->expressions.size(), 2u);
    EXPECT_EQ(back->expressions[1].expression, 17);
    EXPECT_EQ(back->expressions[1].offsetsM, body.expressions[1].offsetsM);
    EXPECT_EQ(*encodeBody(*back), *bytes);
}

TEST(BodyIo, arkitMorphsOfAForeignBodyAreItsExpressions) {
    BodyModel body = smallBody();
    body.morphs[1].name = "jawOpen";
    test::GlbParts parts = test::split(*encodeBody(body));
    for (auto& mesh : parts.json["meshes"]) mesh["extras"].erase("doppelBody");
    const auto back = decodeBody(parts.bytes(), "other");
    ASSERT_TRUE(back) << back.error().message;
    ASSERT_EQ(back->expressions.size(), 1u);
    EXPECT_EQ(back->expressions[0].expression, 17);
    for (const ShapeMorph& morph : back->morphs) EXPECT_NE(morph.name, "jawOpen");
}

TEST(BodyIo, aBodySavedBeforeExpressionsKeepsItsMorphOfThatName) {
    BodyModel body = smallBody();
    body.morphs[1].name = "jawOpen";  // as an import of a foreign body wrote it then
    const auto back = decodeBody(*encodeBody(body), "old");
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_TRUE(back->expressions.empty());
    ASSERT_EQ(back->morphs.size(), 2u);
    EXPECT_EQ(back->morphs[1].name, "jawOpen");
}

TEST(BodyIo, expressionsThatDoNotFitAreRefused) {
    const size_t vertices = smallBody().mesh.restPositions.size();
    const std::vector<Vec3f> still(vertices, Vec3f(0));
    const auto refuses = [&](std::vector<ExpressionShape> expressions) {
        BodyModel body = smallBody();
        body.expressions = std::move(expressions);
        return !checkBody(body);
    };
    EXPECT_FALSE(refuses({{3, still}, {4, still}}));
    EXPECT_TRUE(refuses({{4, still}, {3, still}}));
    EXPECT_TRUE(refuses({{3, still}, {3, still}}));
    EXPECT_TRUE(refuses({{52, still}}));
    EXPECT_TRUE(refuses({{3, std::vector<Vec3f>(vertices - 1, Vec3f(0))}}));
    EXPECT_TRUE(refuses({{3, std::vector<Vec3f>(vertices, Vec3f(0, NAN, 0))}}));
    EXPECT_TRUE(refuses({{3, std::vector<Vec3f>(vertices, Vec3f(0, 0.2f, 0))}}));
}

/** Stores positions as an optimiser does: q = (p − shift) / scale, undone by the bind matrices. */
std::vector<uint8_t> rescaled(std::vector<uint8_t> bytes, float scale, const Vec3f& shift) {
    uint32_t jsonBytes = 0;
    std::memcpy(&jsonBytes, bytes.data() + 12, 4);
    const auto gltf = nlohmann::json::parse(bytes.data() + 20, bytes.data() + 20 + jsonBytes);
    const auto change = [&](size_t accessor, size_t floats, auto&& with) {
        const auto& a = gltf["accessors"][accessor];
        const auto& view = gltf["bufferViews"][a["bufferView"].get<size_t>()];
        uint8_t* at = bytes.data() + 20 + jsonBytes + 8 + view.value("byteOffset", 0u) + a.value("byteOffset", 0u);
        for (size_t i = 0; i < a["count"].get<size_t>(); ++i, at += view.value("byteStride", 4 * floats)) {
            std::vector<float> values(floats);
            std::memcpy(values.data(), at, 4 * floats);
            with(values);
            std::memcpy(at, values.data(), 4 * floats);
        }
    };
    for (const auto& skin : gltf["skins"])
        change(skin["inverseBindMatrices"], 16, [&](std::vector<float>& m) {
            for (int r = 0; r < 4; ++r) {
                for (int c = 0; c < 3; ++c) m[12 + size_t(r)] += m[size_t(4 * c + r)] * shift[c];
                for (int c = 0; c < 3; ++c) m[size_t(4 * c + r)] *= scale;
            }
        });
    for (const auto& mesh : gltf["meshes"])
        for (const auto& primitive : mesh["primitives"]) {
            change(primitive["attributes"]["POSITION"], 3, [&](std::vector<float>& p) {
                for (int c = 0; c < 3; ++c) p[size_t(c)] = (p[size_t(c)] - shift[c]) / scale;
            });
            for (const auto& target : primitive.value("targets", nlohmann::json::array()))
                change(target["POSITION"], 3, [&](std::vector<float>& p) {
                    for (float& x : p) x /= scale;
                });
        }
    return bytes;
}

TEST(BodyIo, anOptimisedOwnBodyIsPlacedByItsBindMatrices) {
    const BodyModel body = smallBody();
    const auto bytes = encodeBody(body);
    ASSERT_TRUE(bytes) << bytes.error().message;
    const auto back = decodeBody(rescaled(*bytes, 0.25f, {0.1f, 0.8f, -0.2f}), "optimised");
    ASSERT_TRUE(back) << back.error().message;
    for (size_t v = 0; v < body.mesh.restPositions.size(); ++v)
        ASSERT_LT(glm::length(back->mesh.restPositions[v] - body.mesh.restPositions[v]), 1e-5f) << v;
    ASSERT_EQ(back->morphs.size(), body.morphs.size());
    for (size_t v = 0; v < body.mesh.restPositions.size(); ++v)
        ASSERT_LT(glm::length(back->morphs[0].vertexOffsets[v] - body.morphs[0].vertexOffsets[v]), 1e-5f) << v;
}

TEST(BodyIo, aForeignBodysHumanoidMapIsHeard) {
    const BodyModel body = smallBody();
    test::GlbParts parts = test::split(*encodeBody(body));
    for (auto& mesh : parts.json["meshes"]) mesh.erase("extras");
    auto& nodes = parts.json["nodes"];
    nlohmann::json bones = nlohmann::json::object();
    for (size_t n = 0; n < nodes.size(); ++n) {
        const std::string name = nodes[n].value("name", "");
        const int joint = findJoint(body.joints, name);
        if (joint >= 0 && !body.joints[size_t(joint)].humanoidBone.empty()) bones[body.joints[size_t(joint)].humanoidBone] = {{"node", n}};
        nodes[n]["name"] = name.starts_with("left_")    ? "right_" + name.substr(5)
                           : name.starts_with("right_") ? "left_" + name.substr(6)
                                                        : name;
    }
    parts.json["extensions"]["VRMC_vrm"] = {{"humanoid", {{"humanBones", bones}}}};
    const auto back = decodeBody(parts.bytes(), "vrm");
    ASSERT_TRUE(back) << back.error().message;
    for (const char* bone : {"leftUpperArm", "leftLowerLeg", "rightHand"})
        EXPECT_EQ(back->joints[size_t(findHumanoid(*back, bone))].restPosition, body.joints[size_t(findHumanoid(body, bone))].restPosition)
            << bone << ": the names say the other side";
}

TEST(BodyIo, everyTruncationIsAnError) {
    const auto bytes = encodeBody(smallBody());
    ASSERT_TRUE(bytes);
    for (size_t length = 0; length < bytes->size(); length += 97)
        EXPECT_FALSE(decodeBody(std::span(*bytes).first(length), "cut")) << length << " of " << bytes->size();
}

TEST(BodyIo, missingFileIsNamed) {
    const auto body = readBody("/nowhere/person.glb");
    ASSERT_FALSE(body);
    EXPECT_EQ(body.error().code, Code::NotFound);
    EXPECT_NE(body.error().message.find("person.glb"), std::string::npos);
}

}  // namespace
}  // namespace dpl
