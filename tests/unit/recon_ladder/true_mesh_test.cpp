// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/ladder/true_mesh.h"

#include <gtest/gtest.h>

#include "tests/unit/recon_ladder/toy_truth.h"

namespace dpl::test {
namespace {

class TrueMeshTest : public testing::Test {
protected:
    TrueMeshTest() { writeTruth(toy_); }
    Result<std::optional<TrueMesh>> read() { return readTrueMesh(toy_.table.scan); }
    std::filesystem::path file(const char* name) const { return toy_.table.scan.root / name; }

    ToyReconstruction toy_;
};

TEST_F(TrueMeshTest, skinsTheTemplateAsTheRigDoes) {
    const auto mesh = read();
    ASSERT_TRUE(mesh) << mesh.error().message;
    ASSERT_TRUE(*mesh);
    for (size_t f = 0; f < ToyReconstruction::kFrames; ++f) {
        const std::vector<Vec3f> expected = ballIn(toy_.avatar, toy_.truth[f], toy_.jobs),
                                 skinned = skinnedTruth(**mesh, (*mesh)->frames[f]);
        const auto surface = trueSurface(**mesh, (*mesh)->frames[f], toy_.table.scan.frames[f].kind);
        ASSERT_TRUE(surface && *surface);
        ASSERT_EQ(skinned.size(), expected.size());
        for (size_t v = 0; v < expected.size(); ++v) {
            EXPECT_LT(glm::length(skinned[v] - expected[v]), 1e-5f);
            EXPECT_LT(glm::length((**surface)[v] - expected[v]), 1e-5f);
        }
    }
}

TEST_F(TrueMeshTest, aScanWithoutTruthHasNone) {
    std::filesystem::remove(file("truth.json"));
    const auto mesh = read();
    ASSERT_TRUE(mesh) << mesh.error().message;
    EXPECT_FALSE(*mesh);
}

TEST_F(TrueMeshTest, everyCutOfItsFilesIsRefusedByName) {
    for (const char* name : {"geometry/template.ply", "geometry/weights.bin", "truth.json"}) {
        const auto whole = must(readFile(file(name)));
        for (size_t cut = 0; cut < whole.size(); cut += 1 + whole.size() / 97) {
            mustWrite(file(name), std::span(whole).first(cut));
            const auto mesh = read();
            ASSERT_FALSE(mesh) << name << " of " << cut << " bytes";
            EXPECT_EQ(mesh.error().message.find("bytes wanted"), std::string::npos) << mesh.error().message;
        }
        mustWrite(file(name), whole);
    }
    const auto mesh = read();
    ASSERT_TRUE(mesh && *mesh);
    const auto posed = must(readFile(file("posed/frame_7.bin")));
    mustWrite(file("posed/frame_7.bin"), std::span(posed).first(posed.size() - 4));
    const auto surface = trueSurface(**mesh, (*mesh)->frames[7], FrameKind::Dynamic);
    ASSERT_FALSE(surface);
    EXPECT_NE(surface.error().message.find("frame_7.bin"), std::string::npos) << surface.error().message;
}

TEST_F(TrueMeshTest, aPosedFileOutsideOfTheScanIsRefused) {
    auto bytes = must(readFile(file("truth.json")));
    nlohmann::json truth = nlohmann::json::parse(bytes);
    truth["frames"][7]["posed"] = "../../elsewhere.bin";
    mustWrite(file("truth.json"), truth.dump());
    const auto mesh = read();
    ASSERT_FALSE(mesh);
    EXPECT_NE(mesh.error().message.find("frame_7"), std::string::npos) << mesh.error().message;
}

TEST_F(TrueMeshTest, aRunLooksAtAllOfItBeforeItTrains) {
    const Scan& scan = toy_.table.scan;
    ASSERT_TRUE(checkTruth(scan));
    const auto posed = must(readFile(file("posed/frame_7.bin")));
    std::vector<uint8_t> notFinite = posed;
    std::fill_n(notFinite.begin() + 4, 4, uint8_t(0xff));
    for (const std::span<const uint8_t> bytes :
         {std::span<const uint8_t>(), std::span<const uint8_t>(posed).first(posed.size() - 4), std::span<const uint8_t>(notFinite)}) {
        mustWrite(file("posed/frame_7.bin"), bytes);
        const Status checked = checkTruth(scan);
        ASSERT_FALSE(checked);
        EXPECT_NE(checked.error().message.find("frame_7.bin"), std::string::npos) << checked.error().message;
    }
    std::filesystem::remove(file("posed/frame_7.bin"));
    EXPECT_FALSE(checkTruth(scan));
    std::filesystem::remove(file("truth.json"));
    EXPECT_TRUE(checkTruth(scan)) << "a scan without truth needs none";
}

}  // namespace
}  // namespace dpl::test
