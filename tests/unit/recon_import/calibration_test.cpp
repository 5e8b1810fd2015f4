// SPDX-License-Identifier: Apache-2.0
// Calibrations of fixed cameras: axes, units, and the data of a real recording.
#include "reconstruction/input/import/calibration.h"

#include "tests/unit/recon_import/made_captures.h"
#include "tests/unit/shared_data.h"

namespace dpl {
namespace {

void expectMadeCamera(const Result<std::vector<CalibratedCamera>>& cameras) {
    ASSERT_TRUE(cameras) << cameras.error().message;
    ASSERT_EQ(cameras->size(), 1u);
    EXPECT_EQ((*cameras)[0].name, "cam01");
    const Camerad& camera = (*cameras)[0].camera;
    EXPECT_LT(glm::length(camera.eye() - kMadeEye), 1e-9);
    EXPECT_LT(glm::length(camera.pixelOf(camera.toView(kMadePoint)) - kMadePixel), 1e-6);
}

TEST(Calibration, qualisysProjectsAKnownPoint) {
    expectMadeCamera(parseQualisys(qualisysText(), "made"));
}

TEST(Calibration, qualisysPicturesThatWereCutAreMoved) {
    std::string text = qualisysText();
    for (const auto& [from, to] : {std::pair{"left=\"0\" right=\"95\"", "left=\"10\" right=\"105\""},
                                   {"centerPointU=\"3072\"", "centerPointU=\"3712\""}})  // 10 px of 1/64 px further right
        text.replace(text.find(from), std::strlen(from), to);
    expectMadeCamera(parseQualisys(text, "made"));
}

TEST(Calibration, pose2simProjectsAKnownPoint) {
    expectMadeCamera(parsePose2sim(pose2simText(), "made"));
}

TEST(Calibration, realRecordingMatchesItsConversion) {
    const auto data = sharedData("real-multiview-balance/Calib.qca.txt");
    if (!data) GTEST_SKIP() << "shared data (real-multiview-balance) is not on this machine";
    const auto cameras = readCalibration(*data);
    ASSERT_TRUE(cameras) << cameras.error().message;
    const auto truth = nlohmann::json::parse(std::ifstream(data->parent_path() / "cameras.json"));
    ASSERT_EQ(cameras->size(), 4u);
    for (size_t i = 0; i < 4; ++i) {
        const auto& expected = truth["cameras"][i];
        const Camerad& camera = (*cameras)[i].camera;
        EXPECT_EQ((*cameras)[i].name, expected["name"].get<std::string>());
        const Vec3d zUp(0.2, -0.3, 1.1);  // a point in the lab
        Vec3d view(0);
        for (int row = 0; row < 3; ++row) {
            const auto& m = expected["world_to_camera"][size_t(row)];
            view[row] = m[0].get<double>() * zUp.x + m[1].get<double>() * zUp.y + m[2].get<double>() * zUp.z + m[3].get<double>();
        }
        const Vec2d pixel(expected["fx"].get<double>() * view.x / view.z + expected["cx"].get<double>(),
                          expected["fy"].get<double>() * view.y / view.z + expected["cy"].get<double>());
        const Vec2d ours = camera.pixelOf(camera.toView({zUp.x, zUp.z, -zUp.y}));
        EXPECT_LT(glm::length(ours - pixel), 1e-3) << i;  // the file's numbers are rounded to 8 digits
        EXPECT_EQ((*cameras)[i].lens.k1, expected["dist_k1k2p1p2k3"][0]);
    }
}

template <class Parse>
void expectRefused(Parse parse, const std::string& good, const char* from, const char* to, std::initializer_list<const char*> words) {
    std::string text = good;
    const size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, std::strlen(from), to);
    const auto cameras = parse(text, "made.file");
    ASSERT_FALSE(cameras) << to;
    EXPECT_TRUE(mentions(cameras.error().message, words));
    EXPECT_TRUE(mentions(cameras.error().message, {"made.file"}));
}

TEST(Calibration, qualisysRefusals) {
    const auto refuse = [](const char* from, const char* to, std::initializer_list<const char*> words) {
        expectRefused(parseQualisys, qualisysText(), from, to, words);
    };
    refuse("x=\"0\"", "x=\"nan\"", {"cam01", "'x'"});
    refuse(" z=\"1000\"", "", {"cam01", "'z'"});
    refuse("r11=\"1\"", "r11=\"2\"", {"cam01", "not a rotation"});
    refuse("right=\"95\"", "right=\"-5\"", {"fov_video"});
    refuse("right=\"95\"", "right=\"1e9\"", {"fov_video"});
    refuse("focalLengthU=\"6400\"", "focalLengthU=\"0\"", {"fx"});
    refuse("<camera serial=\"cam01\" model=\"none\">", "<cam>", {"XML"});
    refuse("<cameras>", "<!DOCTYPE a [<!ENTITY b \"c\">]><cameras>", {"XML"});
    const auto none = parseQualisys("<calibration/>", "made.file");
    ASSERT_FALSE(none);
    EXPECT_TRUE(mentions(none.error().message, {"no camera"}));
}

TEST(Calibration, pose2simRefusals) {
    const auto refuse = [](const char* from, const char* to, std::initializer_list<const char*> words) {
        expectRefused(parsePose2sim, pose2simText(), from, to, words);
    };
    refuse("fisheye = false", "fisheye = true", {"fisheye", "undistort"});
    refuse("rotation = [ 1.5707963267948966, 0.0, 0.0]", "rotation = [ 1.57, 0.0]", {"rotation"});
    refuse("translation = [ 0.0,", "translation = [ nan,", {"translation"});
    refuse("size = [ 96.0, 128.0]", "size = [ 96.0, 1e12]", {"size"});
    refuse("matrix = [ [ 100.0, 0.0, 48.0],", "matrix = [ [ 100.0, 0.0],", {"matrix"});
    refuse("distortions = [ 0.0, 0.0, 0.0, 0.0]", "distortions = [ 0.0, 0.0, 0.0, 0.0, 0.1]", {"k3"});
    refuse("[cam_01]", "[cam_01", {"TOML"});
    refuse("[cam_01]", "[!]", {"TOML"});
    refuse("[cam_01]", "[[ = ]]", {"TOML"});
    refuse("size = [ 96.0,", "size = [ 96.0\u1c00,", {"ASCII"});
    const auto none = parsePose2sim("[metadata]\nerror = 0.0\n", "made.file");
    ASSERT_FALSE(none);
    EXPECT_TRUE(mentions(none.error().message, {"no table"}));
}

TEST(Calibration, everyTruncationIsRefusedOrComplete) {
    const std::string qca = qualisysText(), toml = pose2simText();
    const size_t lastTag = qca.rfind('>');
    for (size_t length = 0; length <= lastTag; ++length) EXPECT_FALSE(parseQualisys(qca.substr(0, length), "cut")) << length;
    const size_t needed = toml.find("fisheye");  // the camera is complete from here on
    for (size_t length = 0; length + 3 < needed; ++length) EXPECT_FALSE(parsePose2sim(toml.substr(0, length), "cut")) << length;
}

}  // namespace
}  // namespace dpl
