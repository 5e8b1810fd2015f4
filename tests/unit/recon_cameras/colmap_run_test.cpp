// SPDX-License-Identifier: Apache-2.0
// COLMAP is called as its manual says, its answers are read, and its failures become sentences. A script stands in for COLMAP, so these
// tests need none; tools/prove-cameras runs the real one.
#include "reconstruction/input/cameras/colmap_run.h"
#include "tests/unit/heard_task.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

namespace dpl {
namespace {

namespace fs = std::filesystem;

/** A folder whose `bin` is the whole PATH, with a `colmap` that notes its arguments and then does as `script` says. */
class ColmapStandIn : public ::testing::Test {
protected:
    fs::path folder_;
    std::string path_ = std::getenv("PATH");

    void SetUp() override {
        folder_ = fs::temp_directory_path() /
                  ("dpl_colmap_run_" + std::to_string(::getpid()) + "_" + ::testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::remove_all(folder_);
        fs::create_directories(folder_ / "bin");
        ::setenv("PATH", (folder_ / "bin").c_str(), 1);
    }
    void TearDown() override {
        ::setenv("PATH", path_.c_str(), 1);
        std::error_code ignored;
        fs::remove_all(folder_, ignored);
    }
    void standIn(const std::string& script) const {
        const fs::path file = folder_ / "bin" / "colmap";
        std::ofstream(file) << "#!/bin/sh\nPATH=/usr/bin:/bin\nF=" << folder_.string() << "\necho \"$@\" >>$F/calls\n" << script << "\n";
        fs::permissions(file, fs::perms::owner_all);
    }
    std::string calls() const {
        std::ostringstream all;
        all << std::ifstream(folder_ / "calls").rdbuf();
        return all.str();
    }
    ColmapRun run() const {
        ColmapRun run{.folder = folder_, .images = {"a.jpg", "b.jpg", "c.jpg"}, .pairs = {{0, 1}, {1, 2}}};
        run.widthPx = 640, run.heightPx = 480, run.focalPx = 500;
        return run;
    }
};

const char* kModel = R"(
if [ "$1" = mapper ]; then
    mkdir -p $F/sparse/0 $F/sparse/1
    for m in 0 1; do echo "1 SIMPLE_RADIAL 640 480 510 320 240 -0.01" >$F/sparse/$m/cameras.txt; done
    printf '1 1 0 0 0 0 0 0 1 a.jpg\n\n' >$F/sparse/0/images.txt
    printf '1 1 0 0 0 0 0 0 1 a.jpg\n\n2 1 0 0 0 1 0 0 1 b.jpg\n\n' >$F/sparse/1/images.txt
fi)";

TEST_F(ColmapStandIn, largestModelIsTheAnswer) {
    standIn(kModel);
    test::HeardTask task;
    const TaskScope scope(&task);
    const auto images = runColmap(run());
    ASSERT_TRUE(images) << images.error().message;
    ASSERT_EQ(images->size(), 2u);
    EXPECT_EQ((*images)[1].name, "b.jpg");
    EXPECT_EQ((*images)[1].camera.fx, 510);
    EXPECT_EQ((*images)[1].lens.k1, -0.01);
    EXPECT_TRUE(std::is_sorted(task.heard.begin(), task.heard.end(), [](const auto& a, const auto& b) { return a.first < b.first; }));
    EXPECT_FALSE(task.heard.empty());
}

TEST_F(ColmapStandIn, aPictureThatIsPutNowhereIsLeftOut) {
    standIn(std::string(kModel) + R"(
[ "$1" != mapper ] || printf '3 1 0 0 0 0 0 1e9 1 c.jpg\n\n' >>$F/sparse/1/images.txt)");
    test::HeardTask task;
    const TaskScope scope(&task);
    const auto images = runColmap(run());
    ASSERT_TRUE(images) << images.error().message;
    ASSERT_EQ(images->size(), 2u);
    EXPECT_EQ((*images)[1].name, "b.jpg");
}

TEST_F(ColmapStandIn, argumentsAreThoseOfTheManual) {
    standIn(kModel);
    fs::create_directories(folder_ / "masks");
    ASSERT_TRUE(runColmap(run()));
    const std::string text = calls();
    for (const char* part :
         {"feature_extractor", "--ImageReader.camera_params 500.000000,320.000000,240.000000,0", "--ImageReader.single_camera 1",
          "--ImageReader.mask_path", "--SiftExtraction.use_gpu 0", "matches_importer", "--SiftMatching.use_gpu 0", "mapper"})
        EXPECT_NE(text.find(part), std::string::npos) << part << " in\n" << text;
    std::ostringstream pairs;
    pairs << std::ifstream(folder_ / "pairs.txt").rdbuf();
    EXPECT_EQ(pairs.str(), "a.jpg b.jpg\nb.jpg c.jpg\n");
}

TEST_F(ColmapStandIn, noModelIsAnEmptyAnswer) {
    standIn("[ \"$1\" != mapper ] || { echo no good initial image pair; exit 1; }");
    const auto images = runColmap(run());
    ASSERT_TRUE(images) << images.error().message;
    EXPECT_TRUE(images->empty());
}

TEST_F(ColmapStandIn, failureNamesTheLog) {
    standIn("echo cannot open the database; exit 3");
    const auto images = runColmap(run());
    ASSERT_FALSE(images);
    for (const char* part : {"exit status 3", "cannot open the database", "colmap.log"})
        EXPECT_NE(images.error().message.find(part), std::string::npos) << images.error().message;
}

TEST_F(ColmapStandIn, damagedModelIsRefused) {
    standIn("[ \"$1\" != mapper ] || { mkdir -p $F/sparse/0; echo x >$F/sparse/0/images.bin; echo y >$F/sparse/0/cameras.bin; }");
    const auto images = runColmap(run());
    ASSERT_FALSE(images);
    EXPECT_NE(images.error().message.find("cameras.bin"), std::string::npos) << images.error().message;
}

TEST_F(ColmapStandIn, missingColmapIsNamedWithItsRemedy) {
    const auto images = runColmap(run());
    ASSERT_FALSE(images);
    EXPECT_EQ(images.error().code, Code::NotFound);
    EXPECT_NE(images.error().message.find("apt-get install colmap"), std::string::npos) << images.error().message;
}

TEST_F(ColmapStandIn, cancelStopsAtOnce) {
    standIn("sleep 60");
    test::HeardTask cancelled(0);
    const TaskScope scope(&cancelled);
    const auto images = runColmap(this->run());
    ASSERT_FALSE(images);
    EXPECT_EQ(images.error().code, Code::Cancelled);
}

}  // namespace
}  // namespace dpl
