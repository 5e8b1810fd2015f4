// SPDX-License-Identifier: Apache-2.0
// dplLoadAvatarFile: what it loads is what dplLoadAvatar loads of the bytes, and every wrong file is an error that names it.
#include <sys/stat.h>
#if !defined(_WIN32)
#include <unistd.h>
#endif

#include <algorithm>
#include <fstream>

#include "sdk/format/ply.h"
#include "sdk/include/doppel/doppel.hpp"
#include "tests/not_finite.h"
#include "tests/unit/api/api_fixture.h"

namespace dpl::test {
namespace {

namespace fs = std::filesystem;

class LoadFile : public ApiTest {
protected:
    void SetUp() override {
        ApiTest::SetUp();
        folder_ = fs::path(testing::TempDir()) / fs::path(u8"doppel_load_file_жест");
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    void TearDown() override {
        fs::remove_all(folder_);
        ApiTest::TearDown();
    }
    fs::path written(const std::string& name, const std::vector<uint8_t>& bytes) {
        std::ofstream(folder_ / name, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
        return folder_ / name;
    }
    static std::string utf8(const fs::path& path) {
        const std::u8string text = path.u8string();
        return {text.begin(), text.end()};
    }
    void fails(const fs::path& path, DplResult code, const char* words) {
        DplAvatar avatar = avatar_;
        EXPECT_EQ(dplLoadAvatarFile(context_, utf8(path).c_str(), &avatar), code) << path << ": " << dplGetLastError();
        EXPECT_EQ(avatar, avatar_) << "outputs are written only on DPL_OK";
        EXPECT_TRUE(errorSays(words)) << dplGetLastError();
        EXPECT_TRUE(errorSays(utf8(path.filename()).c_str())) << "names the file: " << dplGetLastError();
    }
    fs::path folder_;
};

TEST_F(LoadFile, warningsNameTheFile) {
    StaticSplatData two;
    two.position = {{0, 1, 0}, {0, kNan, 0}}, two.rotation.assign(2, {1, 0, 0, 0});
    two.scaleM.assign(2, Vec3f(0.1f)), two.opacity.assign(2, 0.9f), two.sh.assign(6, 0);
    const fs::path path = written("broken.ply", *writePly(two));
    std::vector<std::string> lines;
    dplSetLogCallback([](void* user, DplLogLevel, const char* text) { static_cast<std::vector<std::string>*>(user)->push_back(text); },
                      &lines);
    DplAvatar avatar = nullptr;
    EXPECT_EQ(dplLoadAvatarFile(context_, utf8(path).c_str(), &avatar), DPL_OK) << dplGetLastError();
    dplSetLogCallback(nullptr, nullptr);
    EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
    EXPECT_TRUE(std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
        return line.find(utf8(path) + ": ") == 0 && line.find("1 of 2 splats left out") != std::string::npos;
    })) << testing::PrintToString(lines);
}

TEST_F(LoadFile, loadsWhatLoadAvatarLoadsOfItsBytes) {
    const fs::path path = written("tiny.glb", tinyFile());
    DplAvatar avatar = nullptr;
    ASSERT_EQ(dplLoadAvatarFile(context_, utf8(path).c_str(), &avatar), DPL_OK) << dplGetLastError();
    fs::remove(path);  // the file is needed no more
    const DplCamera camera = frontCamera();
    std::vector<uint8_t> expected, pixels;
    const DplImage first = imageFor(camera, expected), second = imageFor(camera, pixels);
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &first), DPL_OK) << dplGetLastError();
    ASSERT_EQ(dplRender(context_, avatar, &camera, 1, &second), DPL_OK) << dplGetLastError();
    EXPECT_EQ(pixels, expected);
    EXPECT_GT(std::count_if(pixels.begin(), pixels.end(), [](uint8_t c) { return c > 20; }), 500);
    EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
}

TEST_F(LoadFile, theWrapperTakesLiteralsAndStrings) {
    const std::string path = utf8(written("tiny.glb", tinyFile()));
    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE, 1);
    ASSERT_TRUE(context);
    const auto avatar = context->loadAvatarFile(path);
    ASSERT_TRUE(avatar) << avatar.error().message;
    EXPECT_GT(avatar->info()->splatCount, 0u);
    const auto missing = context->loadAvatarFile("no such file.glb");
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().code, DPL_ERROR_NOT_FOUND);
    EXPECT_EQ(missing.error().message, "dplLoadAvatarFile: cannot open no such file.glb: No such file or directory; check the path");
}

TEST_F(LoadFile, wrongArgumentsAreTheProgramsMistake) {
    const std::string path = utf8(written("tiny.glb", tinyFile()));
    DplAvatar avatar = nullptr;
    EXPECT_EQ(dplLoadAvatarFile(context_, nullptr, &avatar), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("path is NULL"));
    EXPECT_EQ(dplLoadAvatarFile(context_, "", &avatar), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("path is empty"));
    EXPECT_EQ(dplLoadAvatarFile(context_, path.c_str(), nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("avatar is NULL"));
    EXPECT_EQ(dplLoadAvatarFile(nullptr, path.c_str(), &avatar), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("context"));
    EXPECT_EQ(avatar, nullptr);
}

TEST_F(LoadFile, wrongFilesAreErrorsThatNameThem) {
    std::vector<uint8_t> half = tinyFile(), flipped = half;
    half.resize(half.size() / 2), flipped[flipped.size() / 2] ^= 1;
    fails(folder_ / "nowhere.glb", DPL_ERROR_NOT_FOUND, "check the path");
    fails(written("empty.glb", {}), DPL_ERROR_CORRUPT_DATA, "is empty");
    fails(written("half.glb", half), DPL_ERROR_CORRUPT_DATA, "its header states");
    fails(written("flipped.glb", flipped), DPL_ERROR_CORRUPT_DATA, "dplLoadAvatarFile: ");
    fails(written("notes.txt", {'h', 'e', 'l', 'l', 'o'}), DPL_ERROR_UNSUPPORTED, "neither an avatar");
    fails(written("torn.ply", {'p', 'l', 'y', '\n'}), DPL_ERROR_CORRUPT_DATA, "dplLoadAvatarFile: ");
    log_.clear();
    fs::create_directory(folder_ / "folder.glb");
#if !defined(_WIN32)
    fails(folder_ / "folder.glb", DPL_ERROR_IO, "is not a file");
    fails(written("file", {'x'}) / "below.glb", DPL_ERROR_IO, "Not a directory");
    EXPECT_EQ(::mkfifo((folder_ / "pipe.glb").c_str(), 0600), 0);
    fails(folder_ / "pipe.glb", DPL_ERROR_IO, "is not a file");  // nobody writes to it: opening it must not wait
    fails("/dev/zero", DPL_ERROR_IO, "is not a file");
    fails(folder_ / std::string(5000, 'x'), DPL_ERROR_IO, "cannot open");
    if (::geteuid() != 0) {  // root may read everything
        fs::permissions(written("mine.glb", half), fs::perms::none);
        fails(folder_ / "mine.glb", DPL_ERROR_IO, "check the permissions");
    }
    written("huge.ply", {'p', 'l', 'y', '\n'});  // sparse: 5 GiB that take no room
    fs::resize_file(folder_ / "huge.ply", uint64_t(5) << 30);
    fails(folder_ / "huge.ply", DPL_ERROR_UNSUPPORTED, "more than");
    const fs::path latin = folder_ / "caf\xe9.glb";  // a name that is not UTF-8 is a name on Linux
    written("caf\xe9.glb", tinyFile());
    DplAvatar avatar = nullptr;
    EXPECT_EQ(dplLoadAvatarFile(context_, latin.c_str(), &avatar), DPL_OK) << dplGetLastError();
    EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
#else
    fails(folder_ / "folder.glb", DPL_ERROR_IO, "cannot open");
#endif
    EXPECT_EQ(log_.find("dplLoadAvatarFile"), log_.npos) << "a wrong file is not the program's mistake";
}

}  // namespace
}  // namespace dpl::test
