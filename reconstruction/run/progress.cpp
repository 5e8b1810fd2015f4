// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "reconstruction/base/time_words.h"
#include "reconstruction/run/run_news.h"
#include "reconstruction/run/stage_words.h"
#include "sdk/core/numbers.h"
#include "sdk/core/result.h"

namespace dpl {
namespace {

std::atomic<bool> cancelRequested{false}, hurryRequested{false};

/** Seconds between two lines of update() where there is no terminal: 10, or what a program that shows them has asked for. */
double logEveryS() {
    constexpr double kUsual = 10, kLeast = 0.1;
    const char* wish = std::getenv("DOPPEL_PROGRESS_SECONDS");
    double seconds = 0;
    return wish && readNumber(wish, seconds) && seconds >= kLeast ? seconds : kUsual;
}

extern "C" void onSignal(int signalNumber) {
    if (!cancelRequested.exchange(true)) return;
    if (hurryRequested.exchange(true)) {
        std::signal(signalNumber, SIG_DFL);
        std::raise(signalNumber);
    }
}

/** Columns of the terminal at stderr. */
size_t terminalColumns() {
    winsize size{};
    constexpr size_t kUsual = 80;
    return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : kUsual;
}

std::string duration(double seconds) {
    const long whole = std::lround(seconds);
    return whole < 90 ? formatText("{} s", whole) : formatText("{} min {} s", whole / 60, whole % 60);
}

}  // namespace

Progress::Progress(Style style) : style_(style), terminal_(::isatty(STDERR_FILENO) != 0) {}

void Progress::clearLine() {
    if (lineOpen_ && terminal_) std::fputs("\r\033[K", stderr);
    lineOpen_ = false;
}

void Progress::beginStage(std::string_view name) {
    stage_ = style_ == Style::Verbose ? name : wordsOfStage(name);
    stageStart_ = lastDrawn_ = Clock::now();
    time_.begin(name, 0);
    if (news_) news_->stage(name);
    if (style_ == Style::Quiet || !terminal_) return;
    std::fprintf(stderr, "  %-19s ...", stage_.c_str());
    lineOpen_ = true;
}

void Progress::update(double fraction, std::string_view detail) {
    const Clock::time_point now = Clock::now();
    const double elapsed = std::chrono::duration<double>(now - stageStart_).count();
    time_.hear(fraction, elapsed);
    if (news_) news_->doing(fraction, detail);
    if (style_ == Style::Quiet) return;
    const double sinceDrawn = std::chrono::duration<double>(now - lastDrawn_).count();
    static const double kLogEveryS = logEveryS();
    if (sinceDrawn < (terminal_ ? 0.2 : kLogEveryS)) return;
    lastDrawn_ = now;
    const RunNews::Left left = news_ ? news_->left() : RunNews::Left{time_.ofStage(elapsed), std::nullopt};
    clearLine();
    const std::string line = progressLine(stage_, fraction, left.stageS, left.runS, detail, terminal_ ? terminalColumns() : 0);
    std::fprintf(stderr, "%s%s", line.c_str(), terminal_ ? "" : "\n");
    std::fflush(stderr);
    lineOpen_ = terminal_;
}

void Progress::endStage(std::string_view summary) {
    clearLine();
    if (style_ == Style::Quiet) return;
    const double elapsed = std::chrono::duration<double>(Clock::now() - stageStart_).count();
    std::fprintf(stderr, "  %-19s %s  (%s)\n", stage_.c_str(), std::string(summary).c_str(), duration(elapsed).c_str());
}

void Progress::skipStage(double tookS) {
    if (news_) news_->tookBefore(tookS);
    endStage("up to date");
}

void Progress::note(std::string_view line) {
    clearLine();
    if (style_ != Style::Quiet) std::fprintf(stderr, "  %.*s\n", int(line.size()), line.data());
}

void Progress::detail(std::string_view line) {
    if (style_ == Style::Verbose) note(line);
}

bool Progress::cancelled() {
    return cancelRequested;
}
bool Progress::hurried() {
    return hurryRequested;
}
const std::atomic<bool>& Progress::cancelFlag() {
    return cancelRequested;
}

std::string progressLine(std::string_view stage, double fraction, std::optional<double> stageLeftS, std::optional<double> runLeftS,
                         std::string_view detail, size_t columns) {
    constexpr size_t kCells = 24, kWide = 110;  // with fewer columns there is room for one time
    const bool narrow = columns > 0 && columns < kWide;
    fraction = std::clamp(fraction, 0.0, 1.0);
    std::string left;
    if (stageLeftS && !(narrow && runLeftS)) left = duration(*stageLeftS) + " left";
    if (runLeftS) left += (left.empty() ? "" : ", ") + wordsOfRunLeft(*runLeftS);
    std::string bar(narrow ? kCells / 2 : kCells, '.');
    std::fill_n(bar.begin(), size_t(fraction * double(bar.size())), '#');
    char head[80];
    std::snprintf(head, sizeof head, "  %-19.30s [%s] %3.0f %%  ", std::string(stage).c_str(), bar.c_str(), fraction * 100);
    std::string line = formatText("{}{}  {}", head, left, detail);
    if (columns > 0 && line.size() >= columns) line.resize(columns - 1);
    return line;
}

void installSignalHandlers() {
    std::signal(SIGINT, onSignal);
    std::signal(SIGTERM, onSignal);
    if (std::signal(SIGHUP, onSignal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // nohup
}

}  // namespace dpl
