// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/progress_line.h"

#include "sdk/core/numbers.h"

namespace dpl {
namespace {

std::string_view trimmed(std::string_view text) {
    const size_t first = text.find_first_not_of(' ');
    return first == text.npos ? std::string_view() : text.substr(first, text.find_last_not_of(' ') - first + 1);
}

}  // namespace

std::optional<ProgressLine> parseProgressLine(std::string_view line) {
    constexpr size_t kCells = 24;
    const size_t bar = line.find('[');
    if (bar == line.npos || bar + kCells + 1 >= line.size() || line[bar + kCells + 1] != ']') return std::nullopt;
    if (line.substr(bar + 1, kCells).find_first_not_of("#.") != line.npos) return std::nullopt;
    std::string_view rest = trimmed(line.substr(bar + kCells + 2));
    const size_t percent = rest.find('%');
    double value = 0;
    if (percent == rest.npos || !readNumber(trimmed(rest.substr(0, percent)), value) || value < 0 || value > 100) return std::nullopt;
    ProgressLine read;
    read.stage = trimmed(line.substr(0, bar));
    read.share = value / 100;
    rest = trimmed(rest.substr(percent + 1));
    constexpr std::string_view kOfStage = " left", kOfRun = " left in all";
    size_t left = rest.find(kOfRun);
    if (left != rest.npos)
        left += kOfRun.size();
    else if (!rest.empty() && rest[0] >= '0' && rest[0] <= '9' && (left = rest.find(kOfStage)) != rest.npos)
        left += kOfStage.size();
    if (left != rest.npos) {
        read.left = rest.substr(0, left);
        rest = trimmed(rest.substr(left));
    }
    read.detail = rest;
    return read;
}

}  // namespace dpl
