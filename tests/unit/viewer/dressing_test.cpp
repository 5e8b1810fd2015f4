// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/dressing.h"

#include <gtest/gtest.h>

#include "sdk/format/avatar_file.h"
#include "tests/package/tiny_avatar.h"
#include "tests/unit/must.h"

namespace {

using namespace dpl;

TEST(DressArguments, nameTheFilesOfThoseWhoGive) {
    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE, 1);
    AvatarData data = test::tinyAvatar();
    sortSplats(data);
    std::vector<ViewedSubject> subjects;
    for (const char* name : {"ada", "ben", "cleo"}) {
        auto avatar = context->loadAvatar(must(writeAvatar(data)));
        ASSERT_TRUE(avatar) << avatar.error().message;
        subjects.push_back(must(ViewedSubject::of(std::move(*avatar), std::string(name) + ".glb")));
        subjects.back().path = std::string("/") + name + ".glb";
    }
    Outfit outfit{};
    EXPECT_TRUE(dressArguments("doppel", subjects[0], outfit, subjects, "/new.glb").empty());
    outfit[0] = subjects[1].avatar.handle(), outfit[3] = subjects[2].avatar.handle();
    EXPECT_EQ(dressArguments("doppel", subjects[0], outfit, subjects, "/new.glb"),
              (std::vector<std::string>{"doppel", "dress", "/ada.glb", "-o", "/new.glb", "--top", "/ben.glb", "--hair", "/cleo.glb"}));
    subjects[2].path.clear();
    EXPECT_FALSE(canDress(subjects[2]));
    EXPECT_EQ(dressArguments("doppel", subjects[0], outfit, subjects, "/new.glb").size(), 7u);
    subjects.erase(subjects.begin() + 1);
    EXPECT_TRUE(dressArguments("doppel", subjects[0], outfit, subjects, "/new.glb").empty()) << "who gives is gone";
}

}  // namespace
