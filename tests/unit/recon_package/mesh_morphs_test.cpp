// SPDX-License-Identifier: Apache-2.0
// Expressions of the exported mesh: in a stock viewer the face moves as the library moves it.
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <doppel/doppel.hpp>
#include <filesystem>
#include <map>
#include <set>

#include "reconstruction/output/package/export_mesh.h"
#include "reconstruction/subject/sample/sample_avatar.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/expression_names.h"
#include "sdk/format/expressions.h"
#include "sdk/format/skinned_gltf.h"
#include "tests/unit/format/glb_parts.h"

namespace dpl {
namespace {

using Weights = std::map<std::string, float>;

/** The exported mesh as a glTF viewer draws it: morph targets, then the skin in a pose that turns joints by name. */
std::vector<std::vector<Vec3f>> posedByAViewer(const SkinnedGltf& model, const Weights& weights,
                                               const std::map<std::string, Quatf>& turned) {
    std::vector<Mat4f> sceneFromNode;
    for (const SkinnedGltf::Node& node : model.nodes) {
        const auto turn = turned.find(node.name);
        const Mat4f own = glm::translate(Mat4f(1), node.translation) *
                          glm::mat4_cast(turn == turned.end() ? node.rotation : turn->second * node.rotation);
        sceneFromNode.push_back(node.parent < 0 ? own : sceneFromNode[size_t(node.parent)] * own);
    }
    std::vector<std::vector<Vec3f>> out;
    for (const SkinnedGltf::Mesh& mesh : model.meshes) {
        std::vector<Vec3f> rest = mesh.positions;
        for (const SkinnedGltf::Morph& morph : mesh.morphs)
            if (const auto weight = weights.find(morph.name); weight != weights.end())
                for (size_t v = 0; v < rest.size(); ++v) rest[v] += weight->second * morph.offsets[v];
        for (size_t v = 0; v < rest.size(); ++v) {
            Vec3f place(0);
            for (int k = 0; k < 4; ++k) {
                const SkinnedGltf::Joint& joint = model.joints[mesh.jointIndices[v][k]];
                place += mesh.jointWeights[v][k] * Vec3f(sceneFromNode[joint.node] * joint.jointFromMesh * Vec4f(rest[v], 1));
            }
            rest[v] = place;
        }
        out.push_back(std::move(rest));
    }
    return out;
}

class MeshMorphs : public testing::Test {
protected:
    static void SetUpTestSuite() {
        Jobs jobs;
        data_ = makeSampleAvatar(makeSubject(1, jobs), jobs);
        folder_ = std::filesystem::temp_directory_path() / ("doppel_mesh_morphs_" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder_);
        ASSERT_TRUE(bool(writeFileAtomically(folder_ / "avatar.glb", *writeAvatar(data_))));
        mesh_ = exported("avatar.glb", "mesh.glb");
    }
    static void TearDownTestSuite() { std::filesystem::remove_all(folder_); }

    static std::vector<uint8_t> exported(const char* avatar, const char* out, std::optional<std::string> author = {}) {
        const auto line = exportMesh({.avatar = folder_ / avatar, .out = folder_ / out, .texturePx = 256, .vrmAuthor = std::move(author)});
        EXPECT_TRUE(line) << line.error().message;
        return line ? *readFile(folder_ / out, 1u << 26) : std::vector<uint8_t>();
    }

    static AvatarData data_;
    static std::filesystem::path folder_;
    static std::vector<uint8_t> mesh_;
};
AvatarData MeshMorphs::data_;
std::filesystem::path MeshMorphs::folder_;
std::vector<uint8_t> MeshMorphs::mesh_;

TEST_F(MeshMorphs, aPosedFaceIsThatOfTheLibrary) {
    const auto model = readSkinnedGltf(mesh_);
    ASSERT_TRUE(model) << model.error().message;
    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE);
    ASSERT_TRUE(context) << context.error().message;
    auto avatar = context->loadAvatar(*readFile(folder_ / "avatar.glb", 1u << 26));
    ASSERT_TRUE(avatar) << avatar.error().message;
    const auto triangles = avatar->meshTriangles();
    ASSERT_TRUE(bool(triangles));
    const std::map<std::string, Quatf> turned = {{"head", glm::angleAxis(0.5f, glm::normalize(Vec3f(0.2f, 1, 0.1f)))},
                                                 {"neck", glm::angleAxis(-0.2f, Vec3f(1, 0, 0))}};
    std::vector<float> rotations;
    size_t found = 0;
    for (const JointData& joint : data_.joints) {
        const auto turn = turned.find(joint.name);
        const Quatf q = turn == turned.end() ? Quatf(1, 0, 0, 0) : turn->second;
        found += turn != turned.end();
        rotations.insert(rotations.end(), {q.x, q.y, q.z, q.w});
    }
    ASSERT_EQ(found, turned.size());
    ASSERT_TRUE(bool(avatar->setPose(rotations)));

    const Weights faces[] = {{},
                             {{"jawOpen", 1}},
                             {{"mouthSmileLeft", 1}, {"mouthSmileRight", 1}},
                             {{"eyeBlinkLeft", 1}, {"eyeBlinkRight", 0.5f}},
                             {{"jawOpen", 0.4f}, {"browInnerUp", 0.7f}, {"cheekPuff", 0.3f}, {"mouthSmileLeft", 0.6f}}};
    for (const Weights& face : faces) {
        std::vector<const char*> names;
        std::vector<float> weights;
        for (const auto& [name, weight] : face) names.push_back(name.c_str()), weights.push_back(weight);
        const std::array<float, DPL_EXPRESSION_COUNT> none{};
        ASSERT_TRUE(bool(avatar->setExpression(none)));
        if (!face.empty()) {
            ASSERT_TRUE(bool(avatar->setExpression(names, weights)));
        }
        std::vector<Vec3f> drawn(data_.mesh.restPositions.size());
        const DplBufferElement place = doppel::bufferElement(DPL_VERTEX_POSITION, 0, sizeof(Vec3f));
        const auto written = avatar->writeMesh({&place, 1}, std::as_writable_bytes(std::span(drawn)));
        ASSERT_TRUE(written) << written.error().message;
        const auto shown = posedByAViewer(*model, face, turned);
        float worst = 0;
        for (size_t m = 0; m < model->meshes.size(); ++m)
            for (size_t t = 0; t < model->meshes[m].triangles.size(); ++t)
                for (int k = 0; k < 3; ++k) {
                    const uint32_t v = (*triangles)[3 * (data_.mesh.layers[m].firstTriangle + t) + size_t(k)];
                    worst = std::max(worst, glm::length(shown[m][model->meshes[m].triangles[t][k]] - drawn[v]));
                }
        std::printf("%zu expressions: at most %.4f mm\n", face.size(), 1000 * double(worst));
        // Places and offsets are multiples of 15 µm: half a step each, along three axes, for four expressions is 0.05 mm.
        EXPECT_LT(worst, 3e-5f * float(1 + face.size()));
    }
}

TEST_F(MeshMorphs, targetsHaveARkitsNamesAndTakeFewBytes) {
    const auto json = test::split(mesh_).json;
    size_t moving = 0;
    for (const auto& mesh : json["meshes"]) {
        const auto& primitive = mesh["primitives"][0];
        EXPECT_EQ(primitive.contains("targets"), mesh.contains("weights")) << mesh["name"];
        if (!primitive.contains("targets")) continue;
        ++moving;
        const size_t count = primitive["targets"].size();
        ASSERT_EQ(mesh["weights"].size(), count);
        ASSERT_EQ(mesh["extras"]["targetNames"].size(), count);
        std::set<std::string> names;
        for (size_t i = 0; i < count; ++i) {
            EXPECT_EQ(mesh["weights"][i], 0) << "a face at rest";
            const std::string name = mesh["extras"]["targetNames"][i];
            EXPECT_TRUE(expressionOf(name).has_value()) << name;
            names.insert(name);
            for (const char* attribute : {"POSITION", "NORMAL"}) {
                const auto& accessor = json["accessors"][primitive["targets"][i][attribute].get<size_t>()];
                EXPECT_EQ(accessor["count"], json["accessors"][primitive["attributes"]["POSITION"].get<size_t>()]["count"]);
                EXPECT_TRUE(accessor.contains("sparse")) << "a face is a small part of a body";
                EXPECT_FALSE(accessor.contains("bufferView"));
                EXPECT_EQ(accessor["min"].size(), 3u);
            }
        }
        if (mesh["name"] == "body") {
            EXPECT_EQ(names.size(), data_.expressions.shapes.size());
        }
    }
    EXPECT_GE(moving, 1u);
    EXPECT_LT(moving, json["meshes"].size()) << "shoes have none";
}

TEST_F(MeshMorphs, anAvatarWithoutExpressionsHasNoTraceOfThem) {
    AvatarData still = data_;
    still.expressions = {};
    dropPoseModes(still.correctives, still.expressions);
    ASSERT_TRUE(bool(writeFileAtomically(folder_ / "still.glb", *writeAvatar(still))));
    test::GlbParts bare = test::split(exported("still.glb", "still-mesh.glb")), full = test::split(mesh_);
    for (size_t m = 0; m < full.json["meshes"].size(); ++m) {
        nlohmann::json &mesh = full.json["meshes"][m], &other = bare.json["meshes"][m];
        for (const char* part : {"weights", "extras"}) EXPECT_FALSE(other.contains(part));
        EXPECT_FALSE(other["primitives"][0].contains("targets"));
        for (const auto& [name, accessor] : mesh["primitives"][0]["attributes"].items()) {
            const auto a = full.accessor(accessor), b = bare.accessor(other["primitives"][0]["attributes"][name]);
            EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end())) << mesh["name"] << " " << name;
        }
    }
}

TEST_F(MeshMorphs, aVrmHasItsPresetsAndEachExpressionByName) {
    const auto bytes = exported("avatar.glb", "person.vrm", "Ada Byron");
    const auto json = test::split(bytes).json;
    const auto& vrm = json["extensions"]["VRMC_vrm"];
    const auto& preset = vrm["expressions"]["preset"];
    for (const char* name : {"happy", "angry", "sad", "relaxed", "surprised", "aa", "ih", "ou", "ee", "oh", "blink", "blinkLeft",
                             "blinkRight", "lookUp", "lookDown", "lookLeft", "lookRight"})
        EXPECT_TRUE(preset.contains(name)) << name;
    EXPECT_EQ(preset.size(), 17u);
    const auto& custom = vrm["expressions"]["custom"];
    EXPECT_EQ(custom.size(), data_.expressions.shapes.size());
    /** The shares of an expression, by ARKit's names. */
    const auto sharesOf = [&](const nlohmann::json& expression) {
        Weights out;
        for (const auto& bind : expression["morphTargetBinds"]) {
            const auto& node = json["nodes"][bind["node"].get<size_t>()];
            const auto& names = json["meshes"][node["mesh"].get<size_t>()]["extras"]["targetNames"];
            out[names.at(bind["index"].get<size_t>())] = bind["weight"];
        }
        return out;
    };
    for (const auto& [name, expression] : custom.items()) EXPECT_EQ(sharesOf(expression), (Weights{{name, 1}}));
    EXPECT_EQ(sharesOf(preset["blinkLeft"]), (Weights{{"eyeBlinkLeft", 1}}));
    EXPECT_EQ(sharesOf(preset["lookLeft"]), (Weights{{"eyeLookOutLeft", 1}, {"eyeLookInRight", 1}}));
    EXPECT_EQ(sharesOf(preset["oh"]), (Weights{{"mouthFunnel", 0.7f}, {"jawOpen", 0.4f}}));
    const auto& look = vrm["lookAt"];
    EXPECT_EQ(look["type"], "expression");
    EXPECT_GT(look["offsetFromHeadBone"][1], 0) << "eyes are above the neck";
    EXPECT_GT(look["offsetFromHeadBone"][2], 0.03) << "and before it";
    EXPECT_NEAR(look["offsetFromHeadBone"][0].get<float>(), 0, 0.01f);

    // The arms go up and the face stays, so its offsets are those of the other file.
    const auto stretched = readSkinnedGltf(bytes), hanging = readSkinnedGltf(mesh_);
    ASSERT_TRUE(stretched && hanging);
    for (size_t m = 0; m < hanging->meshes.size(); ++m) {
        const auto &a = hanging->meshes[m].morphs, &b = stretched->meshes[m].morphs;
        ASSERT_EQ(a.size(), b.size());
        for (size_t i = 0; i < a.size(); ++i)
            for (size_t v = 0; v < a[i].offsets.size(); ++v)
                ASSERT_LT(glm::length(a[i].offsets[v] - b[i].offsets[v]), 5e-5f) << a[i].name << " " << v;
    }
}

}  // namespace
}  // namespace dpl
