// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/base/time_words.h"

#include <cmath>

#include "sdk/core/result.h"

namespace dpl {
namespace {

constexpr double kShortS = 45;  // less is not worth a number

std::string minutesOrHours(double seconds) {
    const auto minutes = long(std::lround(seconds / 60));
    if (minutes == 1) return "1 minute";
    if (minutes < 90) return formatText("{} minutes", minutes);
    if (minutes < 48 * 60) return formatText("{} h {} min", minutes / 60, minutes % 60);
    return formatText("{} days", std::lround(seconds / 86400));
}

}  // namespace

std::string wordsOfTime(double seconds) {
    return seconds < kShortS ? "less than a minute" : minutesOrHours(seconds);
}

std::string wordsOfTimeLeft(double seconds) {
    return (seconds < kShortS ? "" : "about ") + wordsOfTime(seconds) + " left";
}

std::string wordsOfRunLeft(double seconds) {
    return wordsOfTimeLeft(seconds) + " in all";
}

}  // namespace dpl
