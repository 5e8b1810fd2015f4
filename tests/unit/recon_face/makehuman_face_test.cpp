// SPDX-License-Identifier: Apache-2.0
// The face of the MakeHuman body: all 52 shapes at full weight, lids at every weight.
#include "reconstruction/subject/face/makehuman_face.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string_view>

#include "reconstruction/subject/body/body_tools.h"
#include "reconstruction/subject/body/makehuman.h"
#include "reconstruction/subject/face/body_face.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/expression_names.h"
#include "tests/unit/must.h"
#include "tests/unit/shared_data.h"

namespace dpl {
namespace {

constexpr uint32_t kSkin = 13380;  // vertices of skin, the first ones

struct Person {
    BodyModel body;
    MakeHumanMesh source;
    std::vector<MakeHumanVertex> vertices;

    std::vector<uint32_t> part(const char* group) const {
        const std::vector<uint32_t>& of = source.groups.at(group);
        std::vector<uint32_t> out;
        for (uint32_t v = kSkin; v < vertices.size(); ++v)
            if (std::binary_search(of.begin(), of.end(), vertices[v].vertex)) out.push_back(v);
        return out;
    }
    Vec3f middle(const char* group) const {
        Vec3f sum(0);
        const std::vector<uint32_t> vertices = part(group);
        for (const uint32_t v : vertices) sum += body.mesh.restPositions[v] / float(vertices.size());
        return sum;
    }
    const ExpressionShape& shape(std::string_view name) const { return body.expressions[*expressionOf(name)]; }
    Vec3f at(const ExpressionShape& shape, uint32_t v, float weight) const {
        return body.mesh.restPositions[v] + weight * shape.offsetsM[v];
    }
};

const Person* person() {
    static const std::optional<Person> kPerson = []() -> std::optional<Person> {
        const auto folder = sharedData("body-makehuman");
        if (!folder) return std::nullopt;
        Person p;
        p.body = must(importMakeHuman(*folder));
        p.body.expressions = must(makeHumanExpressions(*folder, p.body));
        p.source = must(readMakeHumanObj(must(makeHumanRoot(*folder)) / "3dobjs" / "base.obj"));
        p.vertices = makeHumanVertices(p.source);
        return p;
    }();
    return kPerson ? &*kPerson : nullptr;
}

#define NEED_PERSON()                                                                   \
    if (!person()) GTEST_SKIP() << "shared/data/body-makehuman is not on this machine"; \
    const Person& p = *person()

/** Where an expression may move skin: metres from the middle between the eyeballs, of the left side or of both. */
struct Region {
    std::string_view prefix;
    Vec3f low, high;
};
constexpr Region kRegions[] = {
    {"eye", {0.006f, -0.030f, -0.030f}, {0.062f, 0.028f, 0.040f}},      {"brow", {-0.012f, -0.006f, -0.040f}, {0.075f, 0.060f, 0.050f}},
    {"cheekP", {-0.080f, -0.105f, -0.110f}, {0.080f, -0.020f, 0.060f}}, {"cheekS", {-0.004f, -0.060f, -0.080f}, {0.066f, 0.012f, 0.060f}},
    {"nose", {-0.012f, -0.085f, -0.040f}, {0.045f, 0.010f, 0.060f}},    {"mouth", {-0.070f, -0.140f, -0.090f}, {0.070f, 0.000f, 0.070f}},
    {"jaw", {-0.110f, -0.180f, -0.130f}, {0.110f, -0.010f, 0.070f}},    {"tongue", {-0.110f, -0.180f, -0.130f}, {0.110f, -0.010f, 0.080f}},
};

TEST(MakeHumanFace, hasAll52AndPassesTheCheckOfBodies) {
    NEED_PERSON();
    EXPECT_EQ(p.body.expressions.size(), kExpressionCount);
    const Status sound = checkBody(p.body);
    EXPECT_TRUE(sound) << sound.error().message;
}

TEST(MakeHumanFace, eachMovesItsOwnRegionAndNothingElse) {
    NEED_PERSON();
    const Vec3f middle = 0.5f * (p.middle("helper-l-eye") + p.middle("helper-r-eye"));
    for (const ExpressionShape& shape : p.body.expressions) {
        const std::string_view name = kExpressionNames[shape.expression];
        const auto region =
            std::find_if(std::begin(kRegions), std::end(kRegions), [&](const Region& r) { return name.starts_with(r.prefix); });
        ASSERT_NE(region, std::end(kRegions)) << name;
        const bool middling = name == "mouthLeft" || name == "mouthRight" || name.starts_with("jaw");
        const bool rightSide = name.ends_with("Right") && !middling;
        float most = 0, outside = 0;
        Vec3f where(0);
        for (size_t v = 0; v < shape.offsetsM.size(); ++v) {
            Vec3f q = p.body.mesh.restPositions[v] - middle;
            if (rightSide) q.x = -q.x;
            if (name == "browInnerUp") q.x = std::abs(q.x);
            const bool inside = glm::all(glm::greaterThan(q, region->low)) && glm::all(glm::lessThan(q, region->high));
            const float length = glm::length(shape.offsetsM[v]);
            most = std::max(most, inside ? length : 0);
            if (!inside && length > outside) outside = length, where = q;
        }
        EXPECT_GE(most, 0.001f) << name;
        EXPECT_LE(most, 0.045f) << name;
        EXPECT_LE(outside, 0.0003f) << name << " at " << where.x << " " << where.y << " " << where.z;
    }
}

TEST(MakeHumanFace, leftAndRightMirrorEachOther) {
    NEED_PERSON();
    std::map<std::tuple<int, int, int>, uint32_t> atPlace;  // of the base mesh, which is symmetric
    const auto key = [&](uint32_t v, float side) {
        const Vec3f q = 1e5f * p.source.positionsDm[p.vertices[v].vertex];
        return std::tuple(int(std::lround(side * q.x)), int(std::lround(q.y)), int(std::lround(q.z)));
    };
    for (uint32_t v = 0; v < p.vertices.size(); ++v) atPlace.try_emplace(key(v, 1), v);
    size_t pairs = 0;
    for (const ExpressionShape& shape : p.body.expressions) {
        std::string twin = kExpressionNames[shape.expression];
        if (!twin.ends_with("Left")) continue;
        twin.replace(twin.size() - 4, 4, "Right");
        const ExpressionShape& other = p.shape(twin);
        ++pairs;
        float worst = 0;
        for (uint32_t v = 0; v < p.vertices.size(); ++v) {
            const Vec3f mirrored = Vec3f(-1, 1, 1) * other.offsetsM[atPlace.at(key(v, -1))];
            worst = std::max(worst, glm::length(mirrored - shape.offsetsM[v]));
        }
        EXPECT_LT(worst, 4e-4f) << twin << ": metres; the neutral face is symmetric to a third of a millimetre";
    }
    EXPECT_EQ(pairs, 20u);
}

TEST(MakeHumanFace, noLidGoesIntoAnEyeballAtAnyWeight) {
    NEED_PERSON();
    for (const auto& [side, group] : {std::pair{"Left", "helper-l-eye"}, {"Right", "helper-r-eye"}}) {
        const Vec3f centre = p.middle(group);
        float radius = 0;
        for (const uint32_t v : p.part(group)) radius = std::max(radius, glm::length(p.body.mesh.restPositions[v] - centre));
        EXPECT_NEAR(radius, 0.0157f, 0.0006f);
        for (const char* name : {"eyeBlink", "eyeWide", "eyeSquint", "eyeLookUp", "eyeLookDown"}) {
            const ExpressionShape& shape = p.shape(std::string(name) + side);
            for (uint32_t v = 0; v < kSkin; ++v) {
                if (shape.offsetsM[v] == Vec3f(0) || glm::length(p.body.mesh.restPositions[v] - centre) < radius) continue;
                for (int tenth = 1; tenth <= 10; ++tenth)
                    ASSERT_GE(glm::length(p.at(shape, v, 0.1f * float(tenth)) - centre), radius - 1e-5f)
                        << name << side << " at " << 0.1 * tenth << ", vertex " << v;
            }
        }
    }
}

TEST(MakeHumanFace, lipsNeverCross) {
    NEED_PERSON();
    constexpr uint32_t kProfile[] = {467, 509, 468, 474, 493, 494, 513, 495};  // hm08: down the middle of the lips
    for (const ExpressionShape& shape : p.body.expressions)
        for (int tenth = 1; tenth <= 10; ++tenth)
            for (size_t i = 1; i < std::size(kProfile); ++i)
                ASSERT_GT(p.at(shape, kProfile[i - 1], 0.1f * float(tenth)).y, p.at(shape, kProfile[i], 0.1f * float(tenth)).y - 2e-4f)
                    << kExpressionNames[shape.expression] << " at " << 0.1 * tenth << ", vertex " << kProfile[i];
}

TEST(MakeHumanFace, anOpenJawShowsTheMouthAndTakesTeethAndTongueAlong) {
    NEED_PERSON();
    const ExpressionShape& open = p.shape("jawOpen");
    EXPECT_GT(p.at(open, 474, 1).y - p.at(open, 493, 1).y, 0.010f) << "metres between the lips";
    for (const uint32_t v : p.part("helper-upper-teeth")) EXPECT_EQ(open.offsetsM[v], Vec3f(0));
    for (const char* part : {"helper-lower-teeth", "helper-tongue"}) {
        const std::vector<uint32_t> vertices = p.part(part);
        float lowest = 0;
        for (const uint32_t v : vertices) {
            EXPECT_LT(open.offsetsM[v].y, 0) << part;
            lowest = std::min(lowest, open.offsetsM[v].y);
            const float before = glm::length(p.body.mesh.restPositions[v] - p.body.mesh.restPositions[vertices[0]]);
            EXPECT_NEAR(glm::length(p.at(open, v, 1) - p.at(open, vertices[0], 1)), before, 2e-5f) << "it turns as one piece";
        }
        EXPECT_LT(lowest, -0.012f) << part;
    }
}

TEST(MakeHumanFace, aLookTurnsTheEyeballAboutItsMiddle) {
    NEED_PERSON();
    const ExpressionShape& out = p.shape("eyeLookOutLeft");
    const Vec3f centre = p.middle("helper-l-eye");
    float frontZ = 0, pupilX = 0;
    for (const uint32_t v : p.part("helper-l-eye")) {
        EXPECT_NEAR(glm::length(p.at(out, v, 1) - centre), glm::length(p.body.mesh.restPositions[v] - centre), 1e-5f);
        if (p.body.mesh.restPositions[v].z > frontZ) frontZ = p.body.mesh.restPositions[v].z, pupilX = p.at(out, v, 1).x;
    }
    EXPECT_GT(pupilX - centre.x, 0.005f) << "to the subject's left";
    for (const uint32_t v : p.part("helper-r-eye")) EXPECT_EQ(out.offsetsM[v], Vec3f(0));
}

TEST(MakeHumanFace, fitsInFewBytesOfAnAvatar) {
    NEED_PERSON();
    AvatarData avatar;
    avatar.joints = p.body.joints, avatar.mesh = p.body.mesh;
    avatar.splats.triangleStart.assign(avatar.mesh.triangles.size() + 1, 0);
    must(addBodyFace(avatar, p.body));
    const AvatarInfo info = must(inspectAvatar(must(writeAvatar(avatar))));
    std::printf("[ FACE ] %.1f KB on %u nodes\n", double(info.expressionBytes) / 1e3, avatar.correctives.nodeCount);
    EXPECT_EQ(info.expressions, kExpressionCount);
    EXPECT_LE(info.expressionBytes, 150'000u);
}

TEST(MakeHumanFace, aBodyOfAnotherMeshIsRefused) {
    NEED_PERSON();
    BodyModel other = p.body;
    other.mesh.restPositions.pop_back();
    const auto refused = makeHumanExpressions(*sharedData("body-makehuman"), other);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Code::InvalidArgument);
}

}  // namespace
}  // namespace dpl
