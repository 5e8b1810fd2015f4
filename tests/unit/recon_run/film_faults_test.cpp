// SPDX-License-Identifier: Apache-2.0
// Faults planted in the films of scan-a, each named by the first look; and none named where none was planted.
#include "reconstruction/judging/coach/film_faults.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "reconstruction/input/observe/observations.h"
#include "sdk/core/jobs.h"
#include "tests/unit/must.h"
#include "tests/unit/shared_data.h"

namespace dpl::test {
namespace {

constexpr double kPi = std::numbers::pi;

std::vector<std::string> keysOf(std::span<const FilmPicture> pictures) {
    std::vector<std::string> keys;
    for (const FilmFault& fault : filmFaults(pictures, false)) keys.push_back(fault.key);
    return keys;
}

std::string told(std::span<const FilmPicture> pictures) {
    std::string text;
    for (const FilmFault& fault : filmFaults(pictures, false)) text += "\n  " + fault.key + ": " + fault.sentence;
    return text;
}

bool has(const std::vector<std::string>& keys, const char* key) {
    return std::ranges::find(keys, key) != keys.end();
}

/** A good film of pictures of 540 × 960, without pixels: a walk of 24, hands from near, and moves. */
std::vector<FilmPicture> goodFilm() {
    std::vector<FilmPicture> film;
    const auto add = [&](FrameKind kind, double turnRad, double handPx) -> FilmPicture& {
        FilmPicture p{.kind = kind, .film = size_t(kind), .timeS = double(film.size()), .widthPx = 540, .heightPx = 960};
        p.luma = 110, p.blurPx = 0.8f, p.looked = true;
        Glance person{1, 0, std::vector<Vec2d>(33, Vec2d(270, 400)), std::vector<double>(33, 0.95), turnRad};
        for (const int side : {0, 1}) {
            const double x = 270 + (side ? -60 : 60);
            person.landmarks[11 + size_t(side)] = {x, 200}, person.landmarks[13 + size_t(side)] = {x, 330};
            person.landmarks[15 + size_t(side)] = {x, 330 + handPx / 0.75}, person.landmarks[23 + size_t(side)] = {x, 470};
            person.landmarks[25 + size_t(side)] = {x, 660}, person.landmarks[27 + size_t(side)] = {x, 850};
        }
        p.person = person;
        p.clothes = {Vec3f(60, 10, 10), Vec3f(30, 0, -10)};
        film.push_back(p);
        return film.back();
    };
    for (int i = 0; i < 24; ++i) add(FrameKind::StaticFull, 2 * kPi * i / 24 - kPi, 70);
    for (int i = 0; i < 6; ++i) add(FrameKind::StaticCloseup, 0, 300);
    for (int i = 0; i < 12; ++i) {
        FilmPicture& p = add(FrameKind::Dynamic, 0, 70);
        auto& at = p.person->landmarks;
        if (i == 3) at[13] = {330, 80}, at[14] = {210, 80}, at[15] = {400, 200}, at[16] = {140, 200};
        if (i == 6) at[15] = {350, 240}, at[16] = {190, 240};
    }
    return film;
}

TEST(FilmFaults, aGoodFilmHasNone) {
    const std::vector<FilmPicture> film = goodFilm();
    EXPECT_TRUE(keysOf(film).empty()) << told(film);
}

TEST(FilmFaults, namesTheSideThatIsInNoPicture) {
    std::vector<FilmPicture> film = goodFilm();
    std::erase_if(film, [](const FilmPicture& p) { return p.kind == FrameKind::StaticFull && p.person->turnRad < -0.2; });
    const std::vector<FilmFault> faults = filmFaults(film, false);
    ASSERT_EQ(faults.size(), 1u) << told(film);
    EXPECT_EQ(faults[0].key, "turn");
    EXPECT_NE(faults[0].sentence.find("past the person's right too"), std::string::npos) << faults[0].sentence;
}

TEST(FilmFaults, withoutNetworksOnlyThePicturesThemselvesAreJudged) {
    std::vector<FilmPicture> film = goodFilm();
    std::erase_if(film, [](const FilmPicture& p) { return p.kind != FrameKind::StaticFull; });
    for (FilmPicture& p : film) p.looked = false, p.person.reset(), p.blurPx = 4;
    film[3].luma = 2;
    EXPECT_EQ(keysOf(film), (std::vector<std::string>{"black", "blur walk", "moves"})) << told(film);
    EXPECT_TRUE(keysOf({}).size() == 1 && keysOf({})[0] == "moves") << "no picture at all";
}

/** Pictures of a shared scan, glanced at. */
class Films : public testing::Test {
protected:
    struct Shown {
        FrameKind kind;
        double timeS;
        Vec3d eye;
        ImageRgb8 image;
        Glance glance;
    };
    using Film = std::vector<Shown>;
    static inline std::unique_ptr<Jobs> jobs_;
    static inline std::vector<Observer> observers_;
    static inline Film a_, c_;

    static void glanceAt(Film& film) {
        std::vector<Status> failures(film.size());
        jobs_->forBlocks(film.size(), [&](size_t i, uint32_t worker) {
            auto glance = observers_[worker].glance(film[i].image);
            if (!glance) {
                failures[i] = glance.error();
                return;
            }
            film[i].glance = *glance;
        });
        for (const Status& s : failures) ASSERT_TRUE(s) << s.error().message;
    }
    static Film load(const std::filesystem::path& folder) {
        const Scan scan = must(readScan(folder));
        Film film;
        std::array<size_t, 3> seen{};
        constexpr size_t kEvery[] = {2, 2, 4};
        for (const ScanFrame& frame : scan.frames) {
            const size_t kind = size_t(frame.kind), count = seen[kind]++;
            if (count % kEvery[kind] == 0) film.push_back({frame.kind, double(count), frame.camera.eye(), must(readFrameImage(frame)), {}});
        }
        glanceAt(film);
        return film;
    }
    static void SetUpTestSuite() {
        const auto models = sharedData("models"), a = sharedData("scan-a"), c = sharedData("scan-c");
        if (!models || !a || !c) return;
        jobs_ = std::make_unique<Jobs>(2);
        for (size_t i = 0; i < 2; ++i) observers_.push_back(must(Observer::load(*models)));
        a_ = load(*a), c_ = load(*c);
    }
    static void TearDownTestSuite() { a_.clear(), c_.clear(), observers_.clear(), jobs_.reset(); }
    void SetUp() override {
        if (a_.empty()) GTEST_SKIP() << "shared data (models, scan-a, scan-c) is not on this machine";
    }

    static std::vector<FilmPicture> measured(const Film& film) {
        std::vector<FilmPicture> pictures;
        for (const Shown& s : film) pictures.push_back(measureFilmPicture(s.image, s.kind, size_t(s.kind), s.timeS, &s.glance));
        return pictures;
    }
    /** scan-a with its still pictures changed, and looked at again. */
    static Film changed(const std::function<void(cv::Mat)>& change) {
        Film film = a_;
        Film walk;
        std::erase_if(film, [&](const Shown& s) {
            if (s.kind == FrameKind::StaticFull) walk.push_back(s);
            return s.kind == FrameKind::StaticFull;
        });
        for (Shown& s : walk) change(matOf(s.image));
        glanceAt(walk);
        film.insert(film.end(), walk.begin(), walk.end());
        return film;
    }
    static cv::Mat matOf(ImageRgb8& image) { return {int(image.heightPx), int(image.widthPx), CV_8UC3, image.pixels.data()}; }
    static void expectNamed(const Film& film, const char* key) {
        const auto pictures = measured(film);
        EXPECT_TRUE(has(keysOf(pictures), key)) << key << " is not among:" << told(pictures);
    }
};

TEST_F(Films, nothingIsNamedInGoodFilms) {
    for (const Film* film : {&a_, &c_}) {
        const auto pictures = measured(*film);
        EXPECT_TRUE(keysOf(pictures).empty()) << told(pictures);
    }
}

TEST_F(Films, motionBlur) {
    Film film = a_;
    const cv::Mat across = cv::Mat::ones(1, 9, CV_32F) / 9;
    for (Shown& s : film)
        if (s.kind == FrameKind::StaticFull) cv::filter2D(matOf(s.image), matOf(s.image), -1, across);
    expectNamed(film, "blur walk");
}

TEST_F(Films, aClosedShutter) {
    Film film = a_;
    for (Shown& s : film)
        if (s.kind == FrameKind::StaticFull && s.timeS > 30 && s.timeS < 40) {
            std::ranges::fill(s.image.pixels, uint8_t(3));
            s.glance.landmarks.clear();
        }
    expectNamed(film, "black");
}

TEST_F(Films, halfATurn) {
    Film film = a_;
    std::erase_if(film, [](const Shown& s) { return s.kind == FrameKind::StaticFull && s.eye.x < 0; });
    expectNamed(film, "turn");
}

/** The upper part of a picture, as large as the picture: the camera stands too near. */
void cutBelow(cv::Mat rgb, double share) {
    const int row = int(share * rgb.rows);
    cv::Mat near;
    cv::resize(rgb.rowRange(0, row), near, {rgb.cols * rgb.rows / row, rgb.rows}, 0, 0, cv::INTER_AREA);
    const int left = (near.cols - rgb.cols) / 2;
    near.colRange(left, left + rgb.cols).copyTo(rgb);
}

TEST_F(Films, feetCut) {
    expectNamed(changed([](cv::Mat rgb) { cutBelow(rgb, 0.72); }), "feet");
}

TEST_F(Films, handsNeverSeenFromNear) {
    Film film = a_;
    std::erase_if(film, [](const Shown& s) { return s.kind == FrameKind::StaticCloseup; });
    expectNamed(film, "hands");
}

TEST_F(Films, hemHidden) {
    expectNamed(changed([](cv::Mat rgb) { cutBelow(rgb, 0.57); }), "hem");
}

TEST_F(Films, noMotionPart) {
    Film film = a_;
    std::erase_if(film, [](const Shown& s) { return s.kind == FrameKind::Dynamic; });
    expectNamed(film, "moves");
}

TEST_F(Films, theWrongPersonInView) {
    Film film = a_;
    std::erase_if(film, [](const Shown& s) { return s.kind == FrameKind::Dynamic; });
    for (const Shown& s : c_)
        if (s.kind == FrameKind::Dynamic) film.push_back(s);
    expectNamed(film, "person");
}

}  // namespace
}  // namespace dpl::test
