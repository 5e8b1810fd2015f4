// SPDX-License-Identifier: Apache-2.0
// The stage body-map: how the still training pictures show the fitted surface, and what to film again. Reads no picture of a held-out
// frame.
#pragma once

#include "reconstruction/run/frame_table.h"
#include "reconstruction/run/graph.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

struct MappedBody {
    std::string advice;                          // what to film again, lines of text
    nlohmann::ordered_json figures;              // {film_again: [{shot, sentence, gain}], places: [...]}
    std::vector<std::vector<uint8_t>> pictures;  // PNG: size of a pixel, number of pictures, blur
    CaptureMapData capture;                      // for the avatar's file
};

/** Key and sentence of each shot to film again, the most helpful first. */
std::vector<std::pair<std::string, std::string>> shotsOf(const MappedBody& mapped);

template <>
struct StageOf<MappedBody> {
    static constexpr StageName kName{"body-map", 4};
    static constexpr const char* kPriors[] = {"input/cameras", "input/capture", "subject/surface"};
    static Status inputs(StageInputs& in);
    static Status make(StageInputs& in, StageContext& context);
    static Result<MappedBody> read(StageInputs& in, const std::filesystem::path& folder);
};

}  // namespace dpl
