// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "sdk/core/files.h"

namespace {

using namespace dpl;
using nlohmann::json;

class Stages : public testing::Test {
protected:
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() / ("doppel_stages_" + std::to_string(::getpid()));
        std::filesystem::remove_all(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    Result<StageOutput> runOnce(const json& inputs, const std::function<Status(StageContext&)>& work) {
        StageChain chain(folder_, progress_);
        return chain.run("probe", 1, inputs, work);
    }

    std::filesystem::path folder_;
    Progress progress_{Progress::Style::Quiet};
};

TEST_F(Stages, runsOnceAndIsReusedUntilItsInputsChange) {
    int runs = 0;
    auto work = [&](StageContext& context) { return ++runs, writeFileAtomically(context.folder / "result", "x"); };
    auto first = runOnce({{"a", 1}}, work);
    ASSERT_TRUE(first) << first.error().message;
    EXPECT_EQ(first->folder, folder_ / "stages/probe");
    EXPECT_TRUE(std::filesystem::exists(first->folder / "result"));
    ASSERT_TRUE(runOnce({{"a", 1}}, work));
    EXPECT_EQ(runs, 1);
    auto second = runOnce({{"a", 2}}, work);
    ASSERT_TRUE(second);
    EXPECT_EQ(runs, 2);
    EXPECT_NE(second->key, first->key);
}

TEST_F(Stages, aDamagedOrMissingFileIsMadeAgain) {
    int runs = 0;
    const auto work = [&](StageContext& context) -> Status {
        std::filesystem::create_directories(context.folder / "deep");
        DPL_RETURN_IF_ERROR(writeFileAtomically(context.folder / "deep/result", "whole"));
        return ++runs, Status{};
    };
    const auto again = [&] {
        const auto done = runOnce({{"a", 1}}, work);
        EXPECT_TRUE(done) << done.error().message;
        const auto bytes = readFile(folder_ / "stages/probe/deep/result");
        EXPECT_TRUE(bytes && std::string(bytes->begin(), bytes->end()) == "whole");
        return runs;
    };
    EXPECT_EQ(again(), 1);
    EXPECT_EQ(again(), 1);
    ASSERT_TRUE(writeFileAtomically(folder_ / "stages/probe/deep/result", "whulf"));  // the same size
    EXPECT_EQ(again(), 2) << "a damaged file";
    std::filesystem::remove(folder_ / "stages/probe/deep/result");
    EXPECT_EQ(again(), 3) << "a missing file";
    std::filesystem::remove(folder_ / "stages/probe/deep/result");
    std::filesystem::create_directories(folder_ / "stages/probe/deep/result");
    EXPECT_EQ(again(), 4) << "a folder in its place";
    const auto manifest = readFile(folder_ / "stages/probe/manifest.json");
    ASSERT_TRUE(manifest);
    json without = json::parse(*manifest);
    without.erase("files");
    ASSERT_TRUE(writeFileAtomically(folder_ / "stages/probe/manifest.json", without.dump()));
    EXPECT_EQ(again(), 5) << "a manifest without hashes";
    EXPECT_EQ(again(), 5);
}

TEST_F(Stages, aDamagedManifestIsNamed) {
    progress_ = Progress(Progress::Style::Usual);
    const auto said = [&] {
        testing::internal::CaptureStderr();
        EXPECT_TRUE(runOnce({{"a", 1}}, [](StageContext&) { return Status{}; }));
        return testing::internal::GetCapturedStderr();
    };
    EXPECT_EQ(said().find("runs again"), std::string::npos) << "the first run";
    for (const char* damaged : {"{", "[]", "{}"}) {
        ASSERT_TRUE(writeFileAtomically(folder_ / "stages/probe/manifest.json", std::string_view(damaged)));
        EXPECT_NE(said().find("probe runs again: " + (folder_ / "stages/probe/manifest.json").string() + " is missing or damaged"),
                  std::string::npos)
            << damaged;
    }
}

TEST_F(Stages, aFailedStageLeavesNoFinishedFolderButKeepsItsCheckpoint) {
    auto failing = [&](StageContext& context) -> Status {
        DPL_RETURN_IF_ERROR(writeFileAtomically(context.folder / "checkpoint", "half"));
        return fail(Code::Cancelled, "stopped");
    };
    auto result = runOnce({{"a", 1}}, failing);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, Code::Cancelled);
    EXPECT_EQ(result.error().message, "probe: stopped");
    EXPECT_FALSE(std::filesystem::exists(folder_ / "stages/probe"));

    bool sawCheckpoint = false;
    ASSERT_TRUE(runOnce({{"a", 1}}, [&](StageContext& context) -> Status {
        sawCheckpoint = std::filesystem::exists(context.folder / "checkpoint");
        return {};
    }));
    EXPECT_TRUE(sawCheckpoint);
}

TEST_F(Stages, aCheckpointOfOtherInputsIsDropped) {
    ASSERT_FALSE(runOnce({{"a", 1}}, [&](StageContext& context) -> Status {
        DPL_RETURN_IF_ERROR(writeFileAtomically(context.folder / "checkpoint", "half"));
        return fail(Code::Cancelled, "stopped");
    }));
    bool sawCheckpoint = true;
    ASSERT_TRUE(runOnce({{"a", 2}}, [&](StageContext& context) -> Status {
        sawCheckpoint = std::filesystem::exists(context.folder / "checkpoint");
        return {};
    }));
    EXPECT_FALSE(sawCheckpoint);
}

}  // namespace
