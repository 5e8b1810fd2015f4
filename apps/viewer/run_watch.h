// SPDX-License-Identifier: Apache-2.0
// What is known of a watched run, and what is said of it.
#pragma once

#include "apps/viewer/run_reader.h"

namespace dpl {

class RunWatch {
public:
    /** A run that beats every two seconds counts as silent after this. */
    static constexpr double kSilentS = 30;
    /** The same for one that was silent before it was looked at: its last word is older than this. */
    static constexpr double kOldWordS = 60, kFirstLookS = 5;

    enum class Life : uint8_t { Running, Silent, Done, Stopped, Failed, Unknown };  // Unknown: it tells nothing, or is gone

    /** name: of its folder, for people. */
    explicit RunWatch(std::string name) : name_(std::move(name)) {}

    /** nowS: of any clock that never goes back; unixS: the time of day, which may be another one than that of the run's machine. */
    void hear(const RunLook& look, double nowS, double unixS);

    /** Its process has ended after a wish to stop, and may have had no time to tell. */
    void knowStopped() { stoppedUnixS_ = progress_.startedUnixS; }

    const std::string& name() const { return name_; }
    /** The last that could be read. */
    const RunProgress& progress() const { return progress_; }
    Life life(double nowS) const;
    /** One or two sentences: what the run does, or how it ended. */
    std::string sentence(double nowS) const;
    /** How closely the avatar fits its pictures: "25.3 dB at step 600 of 3000"; "" before that is known. */
    std::string wordsOfFit() const;

private:
    bool silent(double nowS) const { return nowS - changedS_ > silentAfterS_; }
    std::string name_;
    RunLook::Kind kind_ = RunLook::Kind::Gone;
    std::string problem_;  // of the last look
    RunProgress progress_;
    std::optional<double> stoppedUnixS_;  // the start of a run that is known to have ended
    bool heard_ = false;                  // progress_ is of this run
    double changedS_ = 0, silentAfterS_ = kSilentS;
};

}  // namespace dpl
