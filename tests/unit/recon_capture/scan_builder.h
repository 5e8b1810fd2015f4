// SPDX-License-Identifier: Apache-2.0
// Writes small valid scan folders for the reader's tests, which then break one thing at a time.
#pragma once

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include <unistd.h>
#include <cmath>

#include <gtest/gtest.h>

namespace dpl {

/** A temporary folder, removed by the destructor. */
struct TemporaryFolder {
    std::filesystem::path path;
    TemporaryFolder() {
        static int made = 0;  // a test may hold several folders
        const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
        path = std::filesystem::temp_directory_path() / (std::string("dpl_") + info->test_suite_name() + "_" + info->name() + "_" +
                                                         std::to_string(::getpid()) + "_" + std::to_string(made++));
        std::filesystem::remove_all(path);
        std::filesystem::create_directories(path);
    }
    ~TemporaryFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path, ignored);
    }
};

inline void writeText(const std::filesystem::path& path, const std::string& text) {
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
}

/** Changes bytes among the compressed pixels of a JPEG or PNG, behind all headers. */
inline void damagePixels(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(in), {}};
    in.close();
    const size_t scan = bytes.find("\xff\xda"), data = bytes.find("IDAT");
    const size_t begin = data != std::string::npos ? data + 4 : scan + 14;
    for (size_t i = (begin + bytes.size()) / 2; i + 12 < bytes.size(); ++i) bytes[i] = char(7 * i % 251);
    writeText(path, bytes);
}

/** Builds a scan whose subject is an upright textured ellipse in the middle of a grey picture, which passes the ingest check. */
struct ScanBuilder {
    static constexpr int kWidth = 96, kHeight = 128;
    std::filesystem::path root;
    nlohmann::json manifest;

    explicit ScanBuilder(const std::filesystem::path& folder, int staticFrames = 20, int dynamicFrames = 0) : root(folder) {
        manifest = {{"format", "avatar-scan"},
                    {"version", 1},
                    {"name", "tiny"},
                    {"image_size", {kWidth, kHeight}},
                    {"camera_model", "pinhole"},
                    {"distortion", {0.0, 0.0}},
                    {"labels", {{"background", 0}, {"body", 1}, {"top", 2}}},
                    {"keypoint_names", {"nose", "pelvis", "ankle_l"}},
                    {"frames", nlohmann::json::array()}};
        for (int i = 0; i < staticFrames; ++i)
            addFrame("full_" + std::to_string(100 + i), "static_full", 6.283185307179586 * i / staticFrames);
        for (int i = 0; i < dynamicFrames; ++i)
            addFrame("dyn_" + std::to_string(100 + i), "dynamic", 6.283185307179586 * i / dynamicFrames);
    }

    static cv::Mat picture(int seed, cv::Mat& mask) {
        cv::Mat noise(kHeight, kWidth, CV_8UC3), image(kHeight, kWidth, CV_8UC3, cv::Scalar(110, 110, 110));
        cv::RNG rng(uint64_t(seed) + 1);
        rng.fill(noise, cv::RNG::UNIFORM, 60, 200);
        mask = cv::Mat::zeros(kHeight, kWidth, CV_8U);
        cv::ellipse(mask, {kWidth / 2, kHeight / 2}, {18, 50}, 0, 0, 360, 255, -1);
        noise.copyTo(image, mask);
        return image;
    }

    /** A camera at azimuth `angle` about the subject, 2.5 m away at 1 m height, in the file's z-up world. */
    static nlohmann::json camera(double angle) {
        const double c = std::cos(angle), s = std::sin(angle);
        // Eye at (2.5 s, −2.5 c, 1); forward (−s, c, 0); right (c, s, 0); down (0, 0, −1).
        const double ex = 2.5 * s, ey = -2.5 * c, ez = 1;
        return {{"fx", 100.0},
                {"fy", 100.0},
                {"cx", kWidth / 2.0},
                {"cy", kHeight / 2.0},
                {"R", {c, s, 0, 0, 0, -1, -s, c, 0}},
                {"t", {-(c * ex + s * ey), ez, -(-s * ex + c * ey)}}};
    }

    void addFrame(const std::string& name, const std::string& kind, double angle) {
        cv::Mat mask;
        const cv::Mat image = picture(int(manifest["frames"].size()), mask);
        std::filesystem::create_directories(root / "images");
        std::filesystem::create_directories(root / "masks");
        cv::imwrite((root / "images" / (name + ".jpg")).string(), image, {cv::IMWRITE_JPEG_QUALITY, 95});
        cv::imwrite((root / "masks" / (name + ".png")).string(), mask);
        cv::imwrite((root / "labels.png").string(), mask / 255);
        const nlohmann::json points = {{"names", {"pelvis", "nose", "ankle_l"}},
                                       {"xy", {{0, 0}, {0, 0}, {0, 0}}},
                                       {"detections", {{48.0, 64.0}, {48.0, 20.0}, nullptr}},
                                       {"confidence", {0.5, 1.0, 1.0}}};
        writeText(root / "keypoints" / (name + ".json"), points.dump());
        const bool test = manifest["frames"].size() % 10 == 5;
        manifest["frames"].push_back({{"id", manifest["frames"].size()},
                                      {"name", name},
                                      {"kind", kind},
                                      {"split", test ? "test" : "train"},
                                      {"image", "images/" + name + ".jpg"},
                                      {"mask", "masks/" + name + ".png"},
                                      {"keypoints", "keypoints/" + name + ".json"},
                                      {"camera", camera(angle)}});
    }

    const std::filesystem::path& write() {
        writeText(root / "scan.json", manifest.dump());
        return root;
    }
};

/** Succeeds when the message contains every one of `words`. */
inline ::testing::AssertionResult mentions(const std::string& message, std::initializer_list<const char*> words) {
    for (const char* word : words)
        if (message.find(word) == std::string::npos) return ::testing::AssertionFailure() << "'" << word << "' is not in: " << message;
    return ::testing::AssertionSuccess();
}

}  // namespace dpl
