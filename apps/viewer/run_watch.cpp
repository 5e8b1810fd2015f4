// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/run_watch.h"

#include <cctype>
#include <cmath>
#include <cstdio>

#include "reconstruction/base/time_words.h"

namespace dpl {
namespace {

/** With a capital and a full stop. */
std::string asSentence(std::string text) {
    text[0] = char(std::toupper(uint8_t(text[0])));
    return text + ".";
}

}  // namespace

void RunWatch::hear(const RunLook& look, double nowS, double unixS) {
    kind_ = look.kind;
    problem_ = look.sentence;
    if (look.kind != RunLook::Kind::Told) return;
    const RunProgress& p = look.progress;
    if (!heard_) {
        changedS_ = nowS;
        silentAfterS_ = std::abs(unixS - p.unixS) > kOldWordS ? kFirstLookS : kSilentS;
    } else if (p.beat != progress_.beat || p.startedUnixS != progress_.startedUnixS) {
        changedS_ = nowS, silentAfterS_ = kSilentS;
    }
    heard_ = true;
    progress_ = p;
}

RunWatch::Life RunWatch::life(double nowS) const {
    if (kind_ != RunLook::Kind::Told && kind_ != RunLook::Kind::Damaged) return Life::Unknown;
    if (!heard_) return Life::Unknown;
    switch (progress_.state) {
        case RunProgress::State::Done:
            return Life::Done;
        case RunProgress::State::Stopped:
            return Life::Stopped;
        case RunProgress::State::Failed:
            return Life::Failed;
        case RunProgress::State::Running:
            break;
    }
    if (stoppedUnixS_ == progress_.startedUnixS) return Life::Stopped;
    return silent(nowS) ? Life::Silent : Life::Running;
}

std::string RunWatch::sentence(double nowS) const {
    switch (life(nowS)) {
        case Life::Running: {
            std::string text = progress_.words.empty() ? "beginning" : progress_.words;
            if (progress_.place > 0) text += formatText(", part {} of {}", progress_.place, progress_.places);
            return asSentence(text);
        }
        case Life::Silent:
            return formatText("Not heard of for {}. If the run was killed, the same command goes on with it.",
                              nowS - changedS_ < 90 ? formatText("{} seconds", int(nowS - changedS_)) : wordsOfTime(nowS - changedS_));
        case Life::Done:
            return formatText("Done after {}.", wordsOfTime(progress_.seconds));
        case Life::Stopped:
            return "Stopped. The same command goes on with it.";
        case Life::Failed:
            return "Failed: " + progress_.sentence;
        case Life::Unknown:
            break;
    }
    return problem_;
}

std::string RunWatch::wordsOfFit() const {
    if (progress_.curve.empty()) return {};
    char text[80];
    std::snprintf(text, sizeof text, "%.1f dB at step %.0f of %.0f", progress_.curve.back().db, progress_.curve.back().step,
                  progress_.steps);
    return text;
}

}  // namespace dpl
