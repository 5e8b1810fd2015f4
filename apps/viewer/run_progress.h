// SPDX-License-Identifier: Apache-2.0
// progress.json of a run (docs/formats/progress.md), checked.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

struct RunProgress {
    enum class State : uint8_t { Running, Done, Stopped, Failed };
    struct Point {
        double step = 0, db = 0;
    };

    State state = State::Running;
    std::string sentence;                     // why it stopped or failed, or ""
    double startedUnixS = 0, unixS = 0;       // when the run began, and when it wrote this
    double beat = 0;                          // grows while the run lives
    double seconds = 0;                       // since it began
    std::string words, detail;                // what it does, for people: "painting", "step 300 of 2000, 23.1 dB"
    double share = 0;                         // of that, 0 to 1
    uint32_t place = 0, places = 0;           // "7 of 11"; place 0: before the first
    std::optional<double> secondsLeft;        // of that
    std::optional<double> runSecondsLeft;     // of the whole run
    double steps = 0;                         // of the training
    std::vector<Point> curve;                 // how well it fits its pictures, dB
    std::string heldBackFrame;                // name of the held-back picture; empty: none is shown
    std::string heldBackPicture;              // path from the run's folder
    std::string avatar;                       // the avatar so far; path from the run's folder; empty: none
    double avatarStep = 0, avatarChange = 0;  // change: another number for another avatar

    static constexpr size_t kMostBytes = size_t(1) << 20, kMostPoints = 4096, kMostText = 2000;
};

/** where: the file's path, for errors. CorruptData: damaged; Version: of a newer Doppel. Numbers come out finite and within their bounds;
 *  texts are cut at kMostText bytes. Paths are as written: whoever opens them must check that they stay inside the folder. */
Result<RunProgress> parseRunProgress(std::string_view text, const std::string& where);

/** How long the whole run still takes, as far as it says so; before, how many parts come behind the one at hand, or that it is the last.
 *  "" before the first part. */
std::string wordsOfTheRest(const RunProgress& progress);

}  // namespace dpl
