// SPDX-License-Identifier: Apache-2.0
// Expressions in a file: a round trip, each kind of damage, and what a reader leaves out.
#include "sdk/format/expressions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "sdk/format/avatar_file.h"
#include "sdk/format/face_nodes.h"
#include "tests/not_finite.h"
#include "tests/unit/format/glb_parts.h"
#include "tests/unit/format/sample_avatars.h"
#include "tests/unit/format/sample_expressions.h"

namespace dpl {
namespace {

using test::GlbParts;

AvatarData plainFace() {
    return test::withExpressions(test::layeredAvatar(1, 1, 8, 3), 4, 6);
}
AvatarData correctedFace() {
    return test::withExpressions(test::withCorrectives(test::layeredAvatar(1, 1, 8, 3), 1, {.modes = 2, .nodes = 9}), 4, 6);
}

AvatarData ownFace(bool corrected) {
    const AvatarData plain = test::layeredAvatar(1, 1, 8, 3);
    return test::withOwnFace(corrected ? test::withCorrectives(plain, 1, {.modes = 2, .nodes = 9}) : plain, 4);
}

ReadLimits withoutHash() {
    ReadLimits limits;
    limits.verifyHash = false;
    return limits;
}

nlohmann::json& extensionOf(GlbParts& parts) {
    return parts.json["extensions"]["DPL_gaussian_avatar"];
}

TEST(Expressions, surviveAFileWithinAHalfOfAStep) {
    for (const AvatarData& avatar : {plainFace(), correctedFace()}) {
        const auto bytes = writeAvatar(avatar);
        ASSERT_TRUE(bytes) << bytes.error().message;
        const auto read = readAvatar(*bytes);
        ASSERT_TRUE(read) << read.error().message;
        const ExpressionData &a = avatar.expressions, &b = read->expressions;
        EXPECT_EQ(b.shapes, a.shapes);
        EXPECT_EQ(b.ends, a.ends);
        EXPECT_EQ(b.nodes, a.nodes);
        ASSERT_EQ(b.offsetsM.size(), a.offsetsM.size());
        for (size_t e = 0; e < a.offsetsM.size(); ++e) EXPECT_LT(glm::length(b.offsetsM[e] - a.offsetsM[e]), 0.05f / 32767 * 1.01f) << e;
        EXPECT_EQ(read->correctives.nodeCount, avatar.correctives.nodeCount);
        EXPECT_EQ(read->correctives.followsPose(), avatar.correctives.followsPose());
        EXPECT_EQ(*writeAvatar(*read), *bytes) << "what was read is written as it was";
    }
}

TEST(Expressions, doNotRaiseTheVersion) {
    for (const auto& [avatar, version] : {std::pair(plainFace(), 1u), std::pair(correctedFace(), 2u)}) {
        const auto info = inspectAvatar(*writeAvatar(avatar));
        ASSERT_TRUE(info) << info.error().message;
        EXPECT_EQ(info->version, version);
        EXPECT_EQ(info->expressions, 6u);
        EXPECT_EQ(info->correctiveNodes, version == 1 ? 0u : 9u) << "nodes that serve expressions alone are no pose correctives";
        EXPECT_GT(info->expressionBytes, 0u);
    }
}

TEST(Expressions, anAvatarWithoutThemKeepsItsBytes) {
    const AvatarData plain = test::withCorrectives(test::layeredAvatar(1, 1, 8, 3), 1, {.modes = 2, .nodes = 9});
    AvatarData face = test::withExpressions(plain, 4, 6);
    EXPECT_NE(*writeAvatar(face), *writeAvatar(plain));
    face.expressions = {};
    EXPECT_EQ(*writeAvatar(face), *writeAvatar(plain));
}

TEST(Expressions, ofANewerEncodingAreLeftOutAndTheAvatarIsRead) {
    for (const AvatarData& avatar : {plainFace(), correctedFace(), ownFace(false), ownFace(true)}) {
        GlbParts parts = test::split(*writeAvatar(avatar));
        extensionOf(parts)["expressions"] = {{"encoding", 3}, {"streams", "of another kind"}};
        const auto read = readAvatar(parts.bytes(), withoutHash());
        ASSERT_TRUE(read) << read.error().message;
        EXPECT_TRUE(read->expressions.empty());
        EXPECT_EQ(read->correctives.empty(), !avatar.correctives.followsPose());
    }
}

TEST(Expressions, damagedOnesAreRefused) {
    const auto face = [](GlbParts& p) -> nlohmann::json& { return extensionOf(p)["expressions"]; };
    const auto view = [&](GlbParts& p, const char* name) { return p.view(face(p)["streams"][name]); };
    const auto shorter = [&](GlbParts& p, const char* name, size_t by) {
        auto& v = p.json["bufferViews"][face(p)["streams"][name].get<size_t>()];
        v["byteLength"] = v["byteLength"].get<size_t>() - by;
    };
    const auto put16 = [&](GlbParts& p, const char* name, size_t index, uint16_t value) {
        std::memcpy(view(p, name).data() + 2 * index, &value, 2);
    };
    const auto put32 = [&](GlbParts& p, const char* name, size_t index, uint32_t value) {
        std::memcpy(view(p, name).data() + 4 * index, &value, 4);
    };
    const auto putFloat = [&](GlbParts& p, float value) { std::memcpy(view(p, "ranges").data(), &value, 4); };
    struct Damage {
        const char* what;
        std::function<void(GlbParts&)> apply;
    };
    const std::vector<Damage> both = {
        {"a number", [&](GlbParts& p) { face(p) = 1; }},
        {"no encoding", [&](GlbParts& p) { face(p).erase("encoding"); }},
        {"encoding 0", [&](GlbParts& p) { face(p)["encoding"] = 0; }},
        {"no shapes", [&](GlbParts& p) { face(p).erase("shapes"); }},
        {"an empty list of shapes", [&](GlbParts& p) { face(p)["shapes"] = nlohmann::json::array(); }},
        {"one shape fewer", [&](GlbParts& p) { face(p)["shapes"].erase(0); }},
        {"an unknown shape", [&](GlbParts& p) { face(p)["shapes"][1] = "smirk"; }},
        {"a shape with a capital letter", [&](GlbParts& p) { face(p)["shapes"][0] = "EyeBlinkLeft"; }},
        {"a shape that is a number", [&](GlbParts& p) { face(p)["shapes"][1] = 7; }},
        {"a shape twice", [&](GlbParts& p) { face(p)["shapes"][1] = face(p)["shapes"][0]; }},
        {"shapes out of order", [&](GlbParts& p) { std::swap(face(p)["shapes"][1], face(p)["shapes"][2]); }},
        {"53 shapes", [&](GlbParts& p) { face(p)["shapes"] = std::vector<std::string>(53, "jawOpen"); }},
        {"no streams", [&](GlbParts& p) { face(p).erase("streams"); }},
        {"view 9999", [&](GlbParts& p) { face(p)["streams"]["nodes"] = 9999; }},
        {"no offsets", [&](GlbParts& p) { face(p)["streams"].erase("offsets"); }},
        {"an offset too few", [&](GlbParts& p) { shorter(p, "offsets", 6); }},
        {"half a node", [&](GlbParts& p) { shorter(p, "nodes", 1); }},
        {"a count too few", [&](GlbParts& p) { shorter(p, "counts", 4); }},
        {"a range too few", [&](GlbParts& p) { shorter(p, "ranges", 4); }},
        {"a count of 4 billion", [&](GlbParts& p) { put32(p, "counts", 0, 0xffffffffu); }},
        {"a count too small", [&](GlbParts& p) { put32(p, "counts", 5, 0); }},
        {"node 65535", [&](GlbParts& p) { put16(p, "nodes", 0, 65535); }},
        {"nodes out of order", [&](GlbParts& p) { put16(p, "nodes", 1, 0); }},
        {"a range NaN", [&](GlbParts& p) { putFloat(p, kNan); }},
        {"a range infinite", [&](GlbParts& p) { putFloat(p, kInfinity); }},
        {"a range of a metre", [&](GlbParts& p) { putFloat(p, 1); }},
    };
    const std::vector<Damage> own = {
        {"no nodeCount", [&](GlbParts& p) { face(p).erase("nodeCount"); }},
        {"no nodes", [&](GlbParts& p) { face(p)["nodeCount"] = 0; }},
        {"fewer nodes", [&](GlbParts& p) { face(p)["nodeCount"] = 3; }},
        {"a million nodes", [&](GlbParts& p) { face(p)["nodeCount"] = 1000000; }},
        {"node 0 moves", [&](GlbParts& p) { put16(p, "nodes", 0, 0); }},
        {"vertex 4 billion", [&](GlbParts& p) { put32(p, "vertices", 0, 0xffffffffu); }},
        {"a vertex twice", [&](GlbParts& p) { put32(p, "vertices", 1, 1); }},
        {"a vertex too few", [&](GlbParts& p) { shorter(p, "vertices", 4); }},
        {"weights too few", [&](GlbParts& p) { shorter(p, "nodeWeights", 4); }},
        {"weights that do not sum to 255", [&](GlbParts& p) { view(p, "nodeWeights")[0] ^= 1; }},
        {"a vertex on node 65535", [&](GlbParts& p) { put16(p, "nodeIndices", 0, 65535); }},
        {"a vertex that never moves",
         [&](GlbParts& p) {
             for (size_t k = 0; k < 4; ++k) put16(p, "nodeIndices", k, 0);
         }},
    };
    const std::vector<Damage> beside = {
        {"nodes of their own", [&](GlbParts& p) { face(p)["nodeCount"] = 9; }},
        {"vertices of their own", [&](GlbParts& p) { face(p)["streams"]["vertices"] = face(p)["streams"]["counts"]; }},
        {"pose correctives without modes", [&](GlbParts& p) { extensionOf(p)["poseCorrectives"]["modeCount"] = 0; }},
    };
    const auto refused = [&](const AvatarData& avatar, const std::vector<Damage>& list) {
        const std::vector<uint8_t> good = *writeAvatar(avatar);
        ASSERT_TRUE(readAvatar(test::split(good).bytes(), withoutHash()));
        for (const Damage& damage : list) {
            GlbParts parts = test::split(good);
            damage.apply(parts);
            const auto read = readAvatar(parts.bytes(), withoutHash());
            ASSERT_FALSE(read) << damage.what << " was accepted";
            EXPECT_EQ(int(read.error().code), int(Code::CorruptData)) << damage.what << ": " << read.error().message;
        }
    };
    refused(plainFace(), both);
    refused(correctedFace(), both);
    refused(plainFace(), own);
    refused(correctedFace(), beside);
}

TEST(Expressions, onNodesOfTheirOwnSurviveAFileWithinAHalfOfAStep) {
    for (const bool corrected : {false, true}) {
        const AvatarData avatar = ownFace(corrected);
        ASSERT_GT(avatar.expressions.firstNode, 0u);
        const auto bytes = writeAvatar(avatar);
        ASSERT_TRUE(bytes) << bytes.error().message;
        const auto read = readAvatar(*bytes);
        ASSERT_TRUE(read) << read.error().message;
        const ExpressionData &a = avatar.expressions, &b = read->expressions;
        EXPECT_EQ(b.shapes, a.shapes);
        EXPECT_EQ(b.ends, a.ends);
        EXPECT_EQ(b.nodes, a.nodes);
        EXPECT_EQ(b.firstNode, a.firstNode);
        EXPECT_EQ(b.vertices, a.vertices);
        EXPECT_EQ(b.poseIndices, a.poseIndices);
        EXPECT_EQ(b.poseWeights, a.poseWeights);
        EXPECT_EQ(read->correctives.nodeIndices, avatar.correctives.nodeIndices);
        EXPECT_EQ(read->correctives.nodeWeights, avatar.correctives.nodeWeights);
        ASSERT_EQ(b.offsetsM.size(), a.offsetsM.size());
        for (size_t s = 0; s < a.shapes.size(); ++s)
            for (uint32_t e = a.begin(s); e < a.ends[s]; ++e)
                for (int axis = 0; axis < 3; ++axis)
                    EXPECT_NEAR(b.offsetsM[e][axis], a.offsetsM[e][axis],
                                s % 2 ? 0.045f / 32767 * 1.01f : 0.5f * kByteRangeM / 127 * 1.01f);
        EXPECT_EQ(*writeAvatar(*read), *bytes) << "what was read is written as it was";
    }
}

TEST(Expressions, onNodesOfTheirOwnLeaveThePoseCorrectivesOfTheFileAlone) {
    const AvatarData plain = test::withCorrectives(test::layeredAvatar(1, 1, 8, 3), 1, {.modes = 2, .nodes = 9});
    const std::vector<uint8_t> bytes = *writeAvatar(ownFace(true));
    GlbParts parts = test::split(bytes);
    extensionOf(parts)["expressions"]["encoding"] = 3;  // as a reader sees them that does not know ours
    const auto without = readAvatar(parts.bytes(), withoutHash()), want = readAvatar(*writeAvatar(plain)), face = readAvatar(bytes);
    ASSERT_TRUE(without && want && face);
    EXPECT_EQ(without->correctives.nodes, want->correctives.nodes);
    EXPECT_EQ(without->correctives.nodeIndices, want->correctives.nodeIndices);
    EXPECT_EQ(without->correctives.nodeWeights, want->correctives.nodeWeights);
    // A node of the face has what the pose does to its vertex; other vertices keep their nodes.
    const auto column = [](const PoseCorrectiveData& c, uint32_t v, uint32_t i) {
        Vec4f sum(0);
        for (int k = 0; k < 4; ++k) sum += float(c.nodeWeights[v][k]) / 255.0f * c.nodes[size_t(c.nodeIndices[v][k]) * c.columnCount() + i];
        return sum;
    };
    const ExpressionData& x = face->expressions;
    for (uint32_t v = 0; v < face->mesh.restPositions.size(); ++v) {
        const bool moves = std::binary_search(x.vertices.begin(), x.vertices.end(), v);
        if (!moves) {
            EXPECT_EQ(face->correctives.nodeIndices[v], want->correctives.nodeIndices[v]);
        }
        for (uint32_t i = 0; i < 2 && (!moves || face->correctives.nodeWeights[v][0] == 255); ++i)
            EXPECT_EQ(column(face->correctives, v, i), column(want->correctives, v, i)) << v;
    }
}

TEST(Expressions, damagedNodesOfTheirOwnAreRefused) {
    struct Damage {
        const char* what;
        const char* stream;
        size_t at;  // byte
        std::vector<uint8_t> bytes;
    };
    const std::vector<uint8_t> good = *writeAvatar(ownFace(true));
    ASSERT_TRUE(readAvatar(test::split(good).bytes(), withoutHash()));
    const auto refused = [&](const char* what, const std::function<void(GlbParts&, nlohmann::json&)>& damage) {
        GlbParts parts = test::split(good);
        damage(parts, extensionOf(parts)["expressions"]);
        const auto read = readAvatar(parts.bytes(), withoutHash());
        ASSERT_FALSE(read) << what << " was accepted";
        EXPECT_EQ(int(read.error().code), int(Code::CorruptData)) << what << ": " << read.error().message;
    };
    for (const Damage& d : std::vector<Damage>{{"a count of 4 billion", "counts", 0, {255, 255, 255, 255}},
                                               {"a count too small", "counts", 4, {0, 0, 0, 0}},
                                               {"a range NaN", "ranges", 0, {0, 0, 0xc0, 0x7f}},
                                               {"a range below 0", "ranges", 0, {0, 0, 0, 0xbf}},
                                               {"a range of a metre", "ranges", 4, {0, 0, 0x80, 0x3f}},
                                               {"a small range that was a large one", "ranges", 4, {0, 0, 0, 0x3a}},
                                               {"node 65535", "nodes", 0, {255, 255}},
                                               {"nodes out of order", "nodes", 2, {0, 0}},
                                               {"vertex 4 billion", "alone", 0, {255, 255, 255, 255}},
                                               {"a vertex twice", "alone", 4, {1, 0, 0, 0}},
                                               {"a node without a vertex", "aloneNodes", 0, {0, 0}},
                                               {"a vertex on node 65535", "aloneNodes", 0, {255, 255}},
                                               {"a vertex among several on node 65535", "nodeIndices", 6, {255, 255}},
                                               {"weights that do not sum to 255", "nodeWeights", 0, {1}},
                                               {"one node among several", "nodeWeights", 0, {255, 0, 0, 0}}})
        refused(d.what, [&](GlbParts& p, nlohmann::json& face) {
            std::copy(d.bytes.begin(), d.bytes.end(), p.view(face["streams"][d.stream]).begin() + ptrdiff_t(d.at));
        });
    for (const char* stream : {"counts", "ranges", "nodes", "offsets", "alone", "aloneNodes", "vertices", "nodeIndices", "nodeWeights"}) {
        refused(stream, [&](GlbParts&, nlohmann::json& face) { face["streams"].erase(stream); });
        refused(stream, [&](GlbParts& p, nlohmann::json& face) {
            auto& view = p.json["bufferViews"][face["streams"][stream].get<size_t>()];
            view["byteLength"] = view["byteLength"].get<size_t>() - 1;
        });
    }
    refused("no nodeCount", [](GlbParts&, nlohmann::json& face) { face.erase("nodeCount"); });
    refused("no nodes", [](GlbParts&, nlohmann::json& face) { face["nodeCount"] = 0; });
    refused("a node fewer", [](GlbParts&, nlohmann::json& face) { face["nodeCount"] = face["nodeCount"].get<int>() - 1; });
    refused("a node more", [](GlbParts&, nlohmann::json& face) { face["nodeCount"] = face["nodeCount"].get<int>() + 1; });
    refused("a million nodes", [](GlbParts&, nlohmann::json& face) { face["nodeCount"] = 1000000; });
    refused("encoding 1", [](GlbParts&, nlohmann::json& face) { face["encoding"] = 1; });
}

TEST(Expressions, noPartOfAFileIsAWholeOne) {
    const std::vector<uint8_t> good = *writeAvatar(test::withExpressions(test::tinyAvatar(), 1, 3));
    for (size_t size = 0; size < good.size(); ++size) ASSERT_FALSE(readAvatar(std::span(good).first(size), withoutHash())) << size;
}

TEST(Expressions, impossibleOnesAreNotWritten) {
    const auto refused = [](const char* what, const AvatarData& good, const std::function<void(AvatarData&)>& damage) {
        AvatarData bad = good;
        damage(bad);
        const auto bytes = writeAvatar(bad);
        ASSERT_FALSE(bytes) << what;
        EXPECT_EQ(int(bytes.error().code), int(Code::InvalidArgument)) << what;
    };
    for (const AvatarData& good : {plainFace(), correctedFace()}) {
        refused("NaN", good, [](AvatarData& a) { a.expressions.offsetsM[1].y = kNan; });
        refused("a metre", good, [](AvatarData& a) { a.expressions.offsetsM[1].y = 1; });
        refused("shape 52", good, [](AvatarData& a) { a.expressions.shapes.back() = 52; });
        refused("an entry too many", good, [](AvatarData& a) { a.expressions.nodes.push_back(1); });
        refused("ends that fall", good, [](AvatarData& a) { std::swap(a.expressions.ends[0], a.expressions.ends[1]); });
        refused("a node that is not there", good, [](AvatarData& a) { a.expressions.nodes[a.expressions.ends[0] - 1] = 9; });
    }
    for (const AvatarData& good : {ownFace(false), ownFace(true)}) {
        refused("no first node", good, [](AvatarData& a) { a.expressions.firstNode = 0; });
        refused("another first node", good, [](AvatarData& a) { ++a.expressions.firstNode; });
        refused("vertices out of order", good, [](AvatarData& a) { std::swap(a.expressions.vertices[0], a.expressions.vertices[1]); });
        refused("a vertex too few", good, [](AvatarData& a) {
            a.expressions.vertices.pop_back(), a.expressions.poseIndices.pop_back(), a.expressions.poseWeights.pop_back();
        });
        refused("a pose that knows the face", good,
                [](AvatarData& a) { a.expressions.poseIndices[0].x = uint16_t(a.expressions.firstNode); });
        refused("a node of the pose", good, [](AvatarData& a) { a.expressions.nodes[0] = uint16_t(a.expressions.firstNode - 1); });
    }
    refused("nodes for nothing", plainFace(), [](AvatarData& a) { a.expressions = {}; });
    refused("no nodes", plainFace(), [](AvatarData& a) { a.correctives = {}; });
}

class ExpressionsWithoutPose : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(NodesOfTheirOwn, ExpressionsWithoutPose, ::testing::Bool());

TEST_P(ExpressionsWithoutPose, outliveTheModesOfThePose) {
    AvatarData avatar = GetParam() ? ownFace(true) : correctedFace();
    const AvatarData before = avatar;
    dropPoseModes(avatar.correctives, avatar.expressions);
    EXPECT_FALSE(avatar.correctives.followsPose());
    ASSERT_TRUE(writeAvatar(avatar));
    const auto movedBy = [](const AvatarData& a, size_t shape, size_t vertex) {
        Vec3f sum(0);
        for (int k = 0; k < 4; ++k)
            for (uint32_t e = a.expressions.begin(shape); e < a.expressions.ends[shape]; ++e)
                if (a.expressions.nodes[e] == a.correctives.nodeIndices[vertex][k])
                    sum += float(a.correctives.nodeWeights[vertex][k]) * a.expressions.offsetsM[e];
        return sum;
    };
    for (size_t s = 0; s < before.expressions.shapes.size(); ++s)
        for (size_t v = 0; v < before.mesh.restPositions.size(); ++v) EXPECT_EQ(movedBy(avatar, s, v), movedBy(before, s, v));
    AvatarData plain = before;
    plain.expressions = {};
    dropPoseModes(plain.correctives, plain.expressions);
    EXPECT_TRUE(plain.correctives.empty());
}

TEST(Expressions, areFoundByARKitsNamesAndThoseOfLiveLink) {
    for (size_t e = 0; e < kExpressionCount; ++e) EXPECT_EQ(expressionOf(kExpressionNames[e]), e);
    EXPECT_EQ(expressionOf("JawOpen"), expressionOf("jawOpen"));
    for (const char* none : {"", "j", "jawopen", "JAWOPEN", "jawOpen ", "_neutral"}) EXPECT_FALSE(expressionOf(none)) << none;
}

}  // namespace
}  // namespace dpl
