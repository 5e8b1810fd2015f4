// SPDX-License-Identifier: Apache-2.0
// Progress for people: one line a stage, a bar with the time left, and the flag that Ctrl-C sets.
#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <string_view>

namespace dpl {

/** Draws on stderr: a bar rewritten in place on a terminal, a line every ten seconds otherwise, nothing when quiet. */
class Progress {
public:
    enum class Style { Auto, Quiet };
    explicit Progress(Style style = Style::Auto);

    void beginStage(std::string_view name);
    /** fraction in [0,1]; `detail` is short ("step 300 of 2000, 23.1 dB"). Cheap enough to call at every step. */
    void update(double fraction, std::string_view detail = {});
    void endStage(std::string_view summary);
    /** A line of its own, for verdicts and warnings. */
    void note(std::string_view line);

    /** True once the user asked to stop (SIGINT or SIGTERM after installSignalHandlers). */
    bool cancelled() const;
    const std::atomic<bool>& cancelFlag() const;

private:
    using Clock = std::chrono::steady_clock;
    void clearLine();

    Style style_;
    bool terminal_ = false;
    bool lineOpen_ = false;
    std::string stage_;
    Clock::time_point stageStart_{}, lastDrawn_{};
};

/** The first SIGINT or SIGTERM asks every stage to stop at its next checkpoint; the second ends the process at once. */
void installSignalHandlers();

}  // namespace dpl
