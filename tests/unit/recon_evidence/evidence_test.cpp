// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <unistd.h>

#include "reconstruction/judging/evidence/evidence_file.h"
#include "sdk/core/files.h"

namespace {

using namespace dpl;

AvatarData twoSplats() {
    AvatarData a;
    a.splats.uv = {{0, 0}, {0.2f, 0.3f}};
    a.splats.shDegree = 1;
    for (int i = 0; i < 24; ++i) a.splats.sh.push_back(float(i));
    a.correctives.modeCount = 1, a.correctives.nodeCount = 2;
    a.correctives.nodes = {Vec4f(1, 2, 3, 4), Vec4f(5, 6, 7, 8)};
    return a;
}

TEST(Evidence, colourWithoutViewKeepsTheMeanOfEachSplat) {
    AvatarData a = twoSplats();
    removePart(a, AvatarPart::ViewDependentColour);
    EXPECT_EQ(a.splats.shDegree, 0u);
    EXPECT_EQ(a.splats.sh, (std::vector<float>{0, 1, 2, 12, 13, 14}));
    EXPECT_FALSE(hasPart(a, AvatarPart::ViewDependentColour));
}

TEST(Evidence, offsetsAndLightGoOneByOne) {
    AvatarData a = twoSplats();
    removePart(a, AvatarPart::CorrectiveOffsets);
    EXPECT_EQ(a.correctives.nodes[1], Vec4f(0, 0, 0, 8));
    dropEmptyCorrectives(a);
    EXPECT_FALSE(a.correctives.empty()) << "light is still there";
    removePart(a, AvatarPart::CorrectiveLight);
    dropEmptyCorrectives(a);
    EXPECT_TRUE(a.correctives.empty());
}

TEST(Evidence, motionGoesAloneAndTakesItsColumns) {
    AvatarData a = twoSplats();
    EXPECT_FALSE(hasPart(a, AvatarPart::MotionModes));
    a.correctives.motion.groups = {{.columnCount = 1}};
    a.correctives.nodes = {Vec4f(1, 2, 3, 4), Vec4f(9), Vec4f(5, 6, 7, 8), Vec4f(9)};
    EXPECT_TRUE(hasPart(a, AvatarPart::MotionModes));
    removePart(a, AvatarPart::MotionModes);
    EXPECT_FALSE(hasPart(a, AvatarPart::MotionModes));
    EXPECT_EQ(a.correctives.nodes, twoSplats().correctives.nodes);
}

TEST(Evidence, lightOfTheSceneGoesAlone) {
    AvatarData a = twoSplats();
    EXPECT_FALSE(hasPart(a, AvatarPart::SceneLight));
    a.light.irradiance[2] = 0.5f;
    EXPECT_TRUE(hasPart(a, AvatarPart::SceneLight));
    removePart(a, AvatarPart::SceneLight);
    EXPECT_FALSE(hasPart(a, AvatarPart::SceneLight));
    EXPECT_EQ(a.correctives.nodes, twoSplats().correctives.nodes);
}

TEST(Evidence, fileHoldsWhatWasFoundAndADamagedOneIsNamed) {
    const auto path = std::filesystem::temp_directory_path() / ("doppel_evidence_" + std::to_string(::getpid()) + ".json");
    ASSERT_TRUE(writeEvidence({{AvatarPart::CorrectiveLight, {"light", true, 0.75f, 120, "measured"}}}, path));
    const auto rows = readEvidence(path);
    ASSERT_TRUE(rows) << rows.error().message;
    ASSERT_EQ(rows->size(), 1u);
    EXPECT_EQ((*rows)[0].part, AvatarPart::CorrectiveLight);
    EXPECT_TRUE((*rows)[0].row.kept);
    EXPECT_FLOAT_EQ((*rows)[0].row.gainDb, 0.75f);
    for (const char* text : {"", "[{\"id\": \"no-such-part\"}]", "[{\"id\": \"corrective-light\", \"kept\": 3}]", "{}"}) {
        ASSERT_TRUE(writeFileAtomically(path, std::string(text)));
        const auto damaged = readEvidence(path);
        ASSERT_FALSE(damaged) << text;
        EXPECT_NE(damaged.error().message.find(path.filename().string()), std::string::npos);
    }
    std::filesystem::remove(path);
}

}  // namespace
