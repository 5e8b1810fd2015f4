// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/output_claim.h"

#include "reconstruction/run/scan_inputs.h"
#include "reconstruction/run/stage_closeups.h"
#include "reconstruction/run/stage_observe.h"
#include "sdk/core/files.h"
#include "tests/unit/recon_capture/scan_builder.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

class OutputClaim : public testing::Test {
protected:
    /** A scan of three pictures, like no other's if `seed` is another. */
    fs::path scanAt(const char* name, int seed) {
        ScanBuilder builder(folder_.path / name, 3);
        builder.write();
        for (int i = 0; i < 3; ++i) {
            cv::Mat picture(ScanBuilder::kHeight, ScanBuilder::kWidth, CV_8UC3, cv::Scalar(seed, 10 * i, 90));
            const std::string file = (builder.root / builder.manifest["frames"][size_t(i)]["image"].get<std::string>()).string();
            EXPECT_TRUE(cv::imwrite(file, picture));
        }
        return builder.root;
    }
    ReconstructOptions run(const fs::path& scan) const {
        ReconstructOptions options;
        options.scan = scan, options.out = folder_.path / "out";
        return options;
    }
    void claim(const fs::path& scan) {
        fs::create_directories(folder_.path / "out");
        const auto read = readScan(scan);
        ASSERT_TRUE(read) << read.error().message;
        ASSERT_TRUE(claimOutput(run(scan), *read, hashFrames(*read)));
    }
    const TemporaryFolder folder_;
};

TEST_F(OutputClaim, aFolderWithoutARunIsFree) {
    EXPECT_TRUE(checkOutputIsFree(run(scanAt("ada", 1))));
}

TEST_F(OutputClaim, anotherScanIsRefusedUnlessItReplaces) {
    const fs::path ada = scanAt("ada", 1), bob = scanAt("bob", 2);
    claim(ada);
    EXPECT_TRUE(checkOutputIsFree(run(ada)));
    const Status refused = checkOutputIsFree(run(bob));
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find(ada.string()), std::string::npos) << refused.error().message;
    EXPECT_NE(refused.error().message.find("--replace"), std::string::npos);
    ReconstructOptions replacing = run(bob);
    replacing.replace = true;
    EXPECT_TRUE(checkOutputIsFree(replacing));
    claim(bob);
    EXPECT_TRUE(checkOutputIsFree(run(bob)));
    EXPECT_FALSE(checkOutputIsFree(run(ada)));
}

TEST_F(OutputClaim, theSameScanMayMoveGrowAndBeFilmedAgain) {
    const fs::path ada = scanAt("ada", 1);
    claim(ada);
    fs::rename(ada, folder_.path / "moved");
    EXPECT_TRUE(checkOutputIsFree(run(folder_.path / "moved"))) << "it shares pictures with the one that was there";
    fs::remove_all(folder_.path / "moved");
    EXPECT_TRUE(checkOutputIsFree(run(scanAt("ada", 3)))) << "it lies where the other lay";
}

TEST_F(OutputClaim, aDamagedClaimRefuses) {
    const fs::path ada = scanAt("ada", 1);
    claim(ada);
    for (const char* damaged : {"{\"source\": 3, \"pictures\": {\"a\": 1}}", "{\"pictures\": [null, 4]}"}) {
        ASSERT_TRUE(writeFileAtomically(folder_.path / "out/run.json", std::string_view(damaged)));
        EXPECT_FALSE(checkOutputIsFree(run(ada))) << damaged;
    }
    ASSERT_TRUE(writeFileAtomically(folder_.path / "out/run.json", std::string_view("{")));
    EXPECT_TRUE(checkOutputIsFree(run(ada))) << "says nothing of a scan";
}

TEST_F(OutputClaim, aFileOfTheScanIsHashedOnceARun) {
    const auto scan = readScan(scanAt("ada", 1));
    ASSERT_TRUE(scan) << scan.error().message;
    std::vector<FrameHashes> hashes = hashFrames(*scan);
    for (size_t f = 0; f < hashes.size(); ++f) hashes[f].image = "hash of picture " + std::to_string(f);  // no file has such a hash
    Progress progress(Progress::Style::Quiet);
    Jobs jobs(1);
    StageChain chain(folder_.path / "out", progress);
    dpl::Run graph(chain, jobs, progress);
    graph.put(ReadScan{*scan, hashes, "scan", {}}, "read");
    const auto complete = graph.get<CompleteScan>();
    ASSERT_TRUE(complete) << complete.error().message;
    for (size_t f = 0; f < hashes.size(); ++f) {
        EXPECT_EQ((*complete)->hashes[f].image, hashes[f].image);
        EXPECT_EQ((*complete)->hashes[f].mask, hashes[f].mask);
    }
    fs::create_directories(folder_.path / "out");
    ASSERT_TRUE(claimOutput(run(scan->root), *scan, hashes));
    const auto claim = readFile(folder_.path / "out" / "run.json");
    ASSERT_TRUE(claim);
    EXPECT_NE(std::string(claim->begin(), claim->end()).find("hash of picture 2"), std::string::npos);
}

}  // namespace
}  // namespace dpl
