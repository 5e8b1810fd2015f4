// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/verdict_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "sdk/core/files.h"

namespace {

using namespace dpl;

TEST(VerdictFile, aRefusedScanIsNoWrongArgument) {
    const auto folder = std::filesystem::temp_directory_path() / ("doppel_verdict_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder);
    const Error error = refuse(folder, {"ingest"}, fail(Code::InvalidArgument, "too few pictures"));
    EXPECT_EQ(error.code, Code::Unsupported);
    EXPECT_EQ(error.message, "too few pictures");
    const auto bytes = readFile(folder / "verdict.json");
    ASSERT_TRUE(bytes);
    EXPECT_EQ(nlohmann::json::parse(bytes->begin(), bytes->end())["refused"]["reason"], "too few pictures");
    EXPECT_EQ(refuse(folder, {"ingest"}, fail(Code::Io, "no space")).code, Code::Io) << "not about the scan";
    std::filesystem::remove_all(folder);
}

}  // namespace
