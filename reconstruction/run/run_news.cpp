// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/run_news.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "reconstruction/run/stage_words.h"
#include "sdk/core/evenly_spaced.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr size_t kMostPoints = 400;
constexpr int kWatchedQuality = 88;

double secondsSince(std::chrono::steady_clock::time_point then) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - then).count();
}

int64_t unixS() {
    return std::chrono::duration_cast<std::chrono::seconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

double rounded(double value, double perUnit) {
    return std::isfinite(value) ? std::round(value * perUnit) / perUnit : 0;
}

/** Every n-th row and column averaged, so that at most `rows` remain. */
Picture smaller(const Picture& image, uint32_t rows) {
    const uint32_t n = (image.heightPx + rows - 1) / rows;
    if (n <= 1) return image;
    Picture out{image.widthPx / n, image.heightPx / n, 3, {}};
    out.pixels.resize(size_t(out.widthPx) * out.heightPx * 3);
    for (uint32_t y = 0; y < out.heightPx; ++y)
        for (uint32_t x = 0; x < out.widthPx; ++x)
            for (uint32_t c = 0; c < 3; ++c) {
                uint32_t sum = 0;
                for (uint32_t dy = 0; dy < n; ++dy)
                    for (uint32_t dx = 0; dx < n; ++dx) sum += image.pixels[(size_t(y * n + dy) * image.widthPx + x * n + dx) * 3 + c];
                out.pixels[(size_t(y) * out.widthPx + x) * 3 + c] = uint8_t((sum + n * n / 2) / (n * n));
            }
    return out;
}

/** Removes what a run, perhaps one that was killed, left for its watchers, and the folder unless it holds something else. */
void removeShown(const fs::path& out) {
    const fs::path folder = out / RunNews::kFolder;
    std::error_code error;
    std::vector<fs::path> ours;
    for (fs::directory_iterator at(folder, error); !error && at != fs::directory_iterator(); at.increment(error)) {
        const std::string name = at->path().filename().string();
        if (name.starts_with("avatar.glb") || name.starts_with("held-back.jpg")) ours.push_back(at->path());
    }
    for (const fs::path& file : ours) fs::remove(file, error);
    fs::remove(folder, error);  // fails if it is not empty
}

/** The run of this process that tells. */
std::mutex tellsMutex;
RunNews* tells = nullptr;

ordered_json orNull(const std::optional<double>& seconds) {
    return seconds ? ordered_json(rounded(*seconds, 1)) : ordered_json();
}

}  // namespace

RunNews::RunNews(fs::path outFolder) : out_(std::move(outFolder)), startedUnixS_(unixS()) {
    removeShown(out_);
    thread_ = std::thread([this] { write(); });
    std::lock_guard lock(tellsMutex);
    tells = this;
}

RunNews::~RunNews() {
    {
        std::lock_guard lock(tellsMutex);
        if (tells == this) tells = nullptr;
    }
    {
        std::lock_guard lock(mutex_);
        if (told_.state == "running") told_.state = "failed", told_.sentence = "the run ended without a word";
        over_ = true;
    }
    changed_.notify_all();
    thread_.join();
    removeShown(out_);
}

void RunNews::stage(std::string_view name) {
    {
        std::lock_guard lock(mutex_);
        told_.stage = name;
        told_.detail.clear();
        told_.time.begin(name, sinceStartS());
        news_ = true;
    }
    changed_.notify_all();
}

void RunNews::plan(const RunSize& size) {
    std::lock_guard lock(mutex_);
    size_ = size;
    told_.time.plan(size);
}

void RunNews::tookBefore(double seconds) {
    std::lock_guard lock(mutex_);
    told_.time.tookBefore(seconds);
}

void RunNews::doing(double share, std::string_view detail) {
    std::lock_guard lock(mutex_);
    told_.time.hear(share, sinceStartS());
    told_.detail = detail;
}

RunNews::Left RunNews::left() const {
    std::lock_guard lock(mutex_);
    const double now = sinceStartS();
    return {told_.time.ofStage(now), told_.time.ofRun(now)};
}

void RunNews::curve(const std::vector<FitPoint>& points, uint32_t steps) {
    std::lock_guard lock(mutex_);
    told_.curve = evenlySpaced(points, kMostPoints);
    told_.steps = steps;
    if (!size_ || steps == size_->steps) return;
    size_->steps = steps;  // a time budget has become steps
    told_.time.plan(*size_);
}

void RunNews::heldBack(const std::string& frame, const Picture& picture) {
    const Picture shown = smaller(picture, kHeldBackPx);
    auto bytes = encodeJpeg(shown.pixels, shown.widthPx, shown.heightPx, 3, kWatchedQuality);
    if (!bytes) return;
    std::lock_guard lock(mutex_);
    heldBack_ = std::move(*bytes);
    told_.heldBackFrame = frame;
}

bool RunNews::wantsAvatar() const {
    std::lock_guard lock(mutex_);
    return !writing_ && !shown_ && Clock::now() >= nextAvatar_;
}

void RunNews::avatar(AvatarData avatar, uint32_t step, double gatherS) {
    {
        std::lock_guard lock(mutex_);
        shown_ = Shown{std::move(avatar), step, gatherS};
        told_.forWatchersS += gatherS;
    }
    changed_.notify_all();
}

void RunNews::ended(const Status& how) {
    std::lock_guard lock(mutex_);
    if (over_) return;
    told_.state = how ? "done" : how.error().code == Code::Cancelled ? "stopped" : "failed";
    told_.sentence = how ? "" : how.error().message;
}

void RunNews::sayStopped() {
    std::lock_guard lock(tellsMutex);
    if (tells) tells->stopNow();
}

void RunNews::stopNow() {
    std::unique_lock lock(mutex_);
    if (told_.state == "running") told_.state = "stopped", told_.sentence = "stopped";
    over_ = true;
    changed_.notify_all();
    if (changed_.wait_for(lock, std::chrono::duration<double>(kLastWordS), [&] { return toldLast_; })) removeShown(out_);
}

/** The thread: tells whenever a stage begins, an avatar is there, or kBeatS have passed. */
void RunNews::write() {
    std::unique_lock lock(mutex_);
    while (true) {
        changed_.wait_for(lock, std::chrono::duration<double>(kBeatS), [&] { return over_ || news_ || shown_; });
        news_ = false;
        auto shown = std::exchange(shown_, std::nullopt);
        if (over_) {  // what is shown goes now
            shown.reset();
            told_.heldBackFrame.clear(), told_.avatarChange = 0;
        }
        const std::vector<uint8_t> heldBack = std::exchange(heldBack_, {});
        writing_ = shown.has_value();
        const bool last = over_;
        lock.unlock();
        const Clock::time_point began = Clock::now();
        try {
            if (shown || !heldBack.empty()) {
                std::error_code ignored;
                fs::create_directory(out_ / kFolder, ignored);
            }
            if (!heldBack.empty()) (void)writeFileAtomically(out_ / kHeldBack, heldBack);
            if (shown) writeAvatarFile(std::move(*shown));
            writeProgress();
        } catch (const std::exception&) {  // out of memory: the run may still have enough
        }
        lock.lock();
        writing_ = false;
        told_.forWatchersS += secondsSince(began);
        toldLast_ = last;
        if (last) break;
    }
    changed_.notify_all();
}

void RunNews::writeAvatarFile(Shown shown) {
    const Clock::time_point start = Clock::now();
    sortSplats(shown.avatar);
    const auto bytes = writeAvatar(shown.avatar);
    const bool written = bytes && writeFileAtomically(out_ / kAvatar, *bytes);
    const double workS = shown.gatherS + secondsSince(start);
    std::lock_guard lock(mutex_);
    nextAvatar_ =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(std::max(kAvatarS, kShare * workS)));
    if (written) told_.avatarStep = shown.step, ++told_.avatarChange;
}

void RunNews::writeProgress() {
    Told told;
    {
        std::lock_guard lock(mutex_);
        told = told_;
    }
    ordered_json file = {{"format", "doppel-progress"},
                         {"version", 1},
                         {"state", told.state},
                         {"sentence", told.sentence},
                         {"started_unix_s", startedUnixS_},
                         {"unix_s", unixS()},
                         {"beat", ++beat_},
                         {"seconds", rounded(secondsSince(start_), 10)},
                         {"for_watchers_s", rounded(told.forWatchersS, 1e3)},
                         {"stage", told.stage},
                         {"words", wordsOfStage(told.stage)},
                         {"place", placeOfStage(told.stage)},
                         {"places", kStagesOfAll},
                         {"detail", told.detail},
                         {"share", rounded(told.time.share(), 1e4)}};
    const bool runs = told.state == "running";
    const double now = sinceStartS();
    file["seconds_left"] = orNull(runs ? told.time.ofStage(now) : std::nullopt);
    file["run_seconds_left"] = orNull(runs ? told.time.ofRun(now) : std::nullopt);
    file["steps"] = told.steps;
    ordered_json curve = ordered_json::array();
    for (const FitPoint& point : told.curve) curve.push_back({point.step, rounded(point.psnrDb, 100), rounded(point.loss, 1e4)});
    file["curve"] = std::move(curve);
    file["held_back"] = told.heldBackFrame.empty() ? ordered_json() : ordered_json{{"frame", told.heldBackFrame}, {"picture", kHeldBack}};
    file["avatar"] =
        told.avatarChange == 0 ? ordered_json() : ordered_json{{"file", kAvatar}, {"step", told.avatarStep}, {"change", told.avatarChange}};
    (void)writeFileAtomically(out_ / kProgress, file.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n");
}

}  // namespace dpl
