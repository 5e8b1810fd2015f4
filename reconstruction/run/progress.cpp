// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "reconstruction/run/run_news.h"
#include "reconstruction/run/stage_words.h"
#include "sdk/core/numbers.h"
#include "sdk/core/result.h"

namespace dpl {
namespace {

std::atomic<bool> cancelRequested{false};

/** Seconds between two lines of update() where there is no terminal: 10, or what a program that shows them has asked for. */
double logEveryS() {
    constexpr double kUsual = 10, kLeast = 0.1;
    const char* wish = std::getenv("DOPPEL_PROGRESS_SECONDS");
    double seconds = 0;
    return wish && readNumber(wish, seconds) && seconds >= kLeast ? seconds : kUsual;
}

extern "C" void onSignal(int signalNumber) {
    if (cancelRequested.exchange(true)) {
        std::signal(signalNumber, SIG_DFL);
        std::raise(signalNumber);
    }
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
    if (news_) news_->stage(name);
    if (style_ == Style::Quiet || !terminal_) return;
    std::fprintf(stderr, "  %-19s ...", stage_.c_str());
    lineOpen_ = true;
}

void Progress::update(double fraction, std::string_view detail) {
    if (news_) news_->doing(fraction, detail);
    if (style_ == Style::Quiet) return;
    const Clock::time_point now = Clock::now();
    const double sinceDrawn = std::chrono::duration<double>(now - lastDrawn_).count();
    static const double kLogEveryS = logEveryS();
    if (sinceDrawn < (terminal_ ? 0.2 : kLogEveryS)) return;
    lastDrawn_ = now;
    fraction = std::clamp(fraction, 0.0, 1.0);
    const double elapsed = std::chrono::duration<double>(now - stageStart_).count();
    const std::string left = fraction > 0.01 ? duration(elapsed * (1 - fraction) / fraction) + " left" : "";
    constexpr int kCells = 24;
    std::string bar(kCells, '.');
    std::fill_n(bar.begin(), int(fraction * kCells), '#');
    clearLine();
    std::fprintf(stderr, "  %-19s [%s] %3.0f %%  %s  %.*s%s", stage_.c_str(), bar.c_str(), fraction * 100, left.c_str(), int(detail.size()),
                 detail.data(), terminal_ ? "" : "\n");
    std::fflush(stderr);
    lineOpen_ = terminal_;
}

void Progress::endStage(std::string_view summary) {
    clearLine();
    if (style_ == Style::Quiet) return;
    const double elapsed = std::chrono::duration<double>(Clock::now() - stageStart_).count();
    std::fprintf(stderr, "  %-19s %s  (%s)\n", stage_.c_str(), std::string(summary).c_str(), duration(elapsed).c_str());
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
const std::atomic<bool>& Progress::cancelFlag() {
    return cancelRequested;
}

void installSignalHandlers() {
    std::signal(SIGINT, onSignal);
    std::signal(SIGTERM, onSignal);
    if (std::signal(SIGHUP, onSignal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // nohup
}

}  // namespace dpl
