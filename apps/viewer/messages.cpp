// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/messages.h"

#include <algorithm>

namespace dpl {

void Messages::add(Line line) {
    note(line.text, line.error);
    if (lines_.size() == kMost) lines_.erase(lines_.begin());
    lines_.push_back(std::move(line));
}

void Messages::error(const std::string& text) {
    const bool shown = std::any_of(lines_.begin(), lines_.end(), [&](const Line& line) { return line.error && line.text == text; });
    if (!shown) add({text, true, 0});
}

void Messages::info(const std::string& text, double nowS) {
    add({text, false, nowS + kSecondsShown});
}

void Messages::note(const std::string& text, bool error) {
    if (log_.size() == kMostKept) log_.pop_front();
    log_.push_back({text, error, nowS_});
}

void Messages::dismiss(size_t line) {
    if (line < lines_.size()) lines_.erase(lines_.begin() + std::ptrdiff_t(line));
}

void Messages::tick(double nowS) {
    nowS_ = nowS;
    std::erase_if(lines_, [&](const Line& line) { return !line.error && line.untilS <= nowS; });
}

}  // namespace dpl
