// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage_words.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace dpl {

std::string_view wordsOfStage(std::string_view name) {
    constexpr std::pair<std::string_view, std::string_view> kWords[] = {
        {"import", "reading the film"},      {"observe", "finding the person"}, {"cameras", "finding the camera"},
        {"closeups", "placing close-ups"},   {"ingest", "checking pictures"},   {"body-fit", "fitting the body"},
        {"surface", "shaping the body"},     {"body-map", "mapping the body"},  {"garments", "cutting out clothes"},
        {"register", "following the moves"}, {"co-optimise", "painting"},       {"evidence", "trying parts"},
        {"assemble", "putting together"},    {"package", "writing the avatar"}, {"pose-fit", "posing for scores"},
        {"report", "writing the report"},
    };
    for (const auto& [stage, words] : kWords)
        if (stage == name) return words;
    return name;
}

namespace {

constexpr std::string_view kInOrder[kStagesOfAll] = {"ingest",      "body-fit", "surface", "body-map", "garments", "register",
                                                     "co-optimise", "evidence", "package", "pose-fit", "report"};

}  // namespace

size_t placeOfStage(std::string_view name) {
    return size_t(std::find(std::begin(kInOrder), std::end(kInOrder), name) - std::begin(kInOrder) + 1) % (kStagesOfAll + 1);
}

std::string_view stageAt(size_t place) {
    return kInOrder[place - 1];
}

}  // namespace dpl
