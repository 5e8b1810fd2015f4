// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/sample.h"

#include "tests/unit/viewer/stand_in.h"

namespace {

using namespace dpl;
namespace fs = std::filesystem;

class SampleTest : public test::FolderTest {
protected:
    std::atomic<bool> cancel_{false};
};

TEST_F(SampleTest, isMadeOnceAndThenThere) {
    const fs::path doppel = program("[ \"$1 $2\" = 'sample-avatar -o' ] && echo made >>\"$3\"");
    for (int i = 0; i < 2; ++i) {
        const auto file = sampleAvatar(doppel, folder_, cancel_);
        ASSERT_TRUE(file) << file.error().message;
        EXPECT_EQ(readFile(*file)->size(), 5u);
    }
}

TEST_F(SampleTest, saysWhatTheProgramSays) {
    const auto file = sampleAvatar(program("echo 'doppel: the disk is full' >&2; exit 1"), folder_, cancel_);
    ASSERT_FALSE(file);
    EXPECT_NE(file.error().message.find("the disk is full"), std::string::npos) << file.error().message;
    const auto nowhere = sampleAvatar(folder_ / "none", folder_, cancel_);
    ASSERT_FALSE(nowhere);
    EXPECT_EQ(nowhere.error().code, Code::NotFound);
}

TEST_F(SampleTest, endsWhenTheViewerIsClosed) {
    cancel_ = true;
    const auto file = sampleAvatar(program("sleep 60"), folder_, cancel_);
    ASSERT_FALSE(file);
    EXPECT_EQ(file.error().code, Code::Cancelled);
}

}  // namespace
