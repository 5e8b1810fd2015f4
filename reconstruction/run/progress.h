// SPDX-License-Identifier: Apache-2.0
// Progress on the terminal (one line a stage, a bar with the time left), and the flag that Ctrl-C sets.
#pragma once

#include <atomic>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "reconstruction/run/time_left.h"
#include "sdk/core/task.h"

namespace dpl {

class RunNews;

/** Writes to stderr: on a terminal a bar that is rewritten in place, otherwise a line every ten seconds; nothing when quiet. */
class Progress {
public:
    enum class Style { Usual, Quiet, Verbose };
    explicit Progress(Style style = Style::Usual);

    /** Shows wordsOfStage(name), and the name itself if the style is Verbose. */
    void beginStage(std::string_view name);
    /** fraction in [0,1]; `detail` is short ("step 300 of 2000, 23.1 dB"). Cheap enough for every step. */
    void update(double fraction, std::string_view detail = {});
    void endStage(std::string_view summary);
    /** The same for a stage that is up to date, and took so long in an earlier run. */
    void skipStage(double tookS);
    /** Writes a separate line, for verdicts and warnings. */
    void note(std::string_view line);
    /** Writes a separate line if the style is Verbose. */
    void detail(std::string_view line);

    /** Who else hears of stages and updates; null: nobody. */
    RunNews* news() const { return news_; }

    /** True after the first SIGINT, SIGTERM or SIGHUP, if installSignalHandlers() was called. */
    static bool cancelled();
    /** True after the second one. */
    static bool hurried();
    static const std::atomic<bool>& cancelFlag();

private:
    friend class ToldNews;
    using Clock = std::chrono::steady_clock;
    void clearLine();

    Style style_;
    RunNews* news_ = nullptr;
    bool terminal_ = false;
    bool lineOpen_ = false;
    std::string stage_;
    Clock::time_point stageStart_{}, lastDrawn_{};
    TimeLeft time_;  // of the stage, since stageStart_; asked where nobody else hears
};

/** A Progress tells it to `news` too until the scope ends. */
class ToldNews {
public:
    ToldNews(Progress& progress, RunNews& news) : progress_(progress) { progress_.news_ = &news; }
    ~ToldNews() { progress_.news_ = nullptr; }
    ToldNews(const ToldNews&) = delete;
    ToldNews& operator=(const ToldNews&) = delete;

private:
    Progress& progress_;
};

/** Work that a Progress shows and the first signal cancels. */
class ShownTask : public Task {
public:
    explicit ShownTask(Progress& progress) : progress_(progress) {}
    bool cancelled() const override { return Task::cancelled() || Progress::cancelled(); }
    void hear(double share, std::string_view doing) override { progress_.update(share, doing); }

private:
    Progress& progress_;
};

/** One line of progress. columns: of the terminal, to which it is cut; 0: no terminal. Seconds left: nothing if not known. */
std::string progressLine(std::string_view stage, double fraction, std::optional<double> stageLeftS, std::optional<double> runLeftS,
                         std::string_view detail, size_t columns);

/** The first SIGINT, SIGTERM or SIGHUP asks every stage to stop at its next checkpoint; the second asks the program to wait for none
 *  (apps/doppel/interruption.h); the third ends the process at once. A SIGHUP that is ignored, as under nohup, stays ignored. */
void installSignalHandlers();

}  // namespace dpl
