// SPDX-License-Identifier: Apache-2.0
// The stage body-fit: one shape, one still pose, one pose for each moving frame, fingers where the scan shows them.
#pragma once

#include "reconstruction/run/frame_table.h"
#include "reconstruction/run/graph.h"
#include "reconstruction/subject/body/fit_body.h"
#include "reconstruction/subject/hands/fit_fingers.h"

namespace dpl {

/** A body before any fit. */
struct ChosenBody {
    BodyModel body;
    std::string hash;      // of its file bytes without expressions: no fit reads these
    std::string faceHash;  // with them
};

template <>
struct StageOf<ChosenBody> {
    static constexpr StageName kName{"body", 1};
    static Status inputs(StageInputs& in);
    static Result<ChosenBody> compute(StageInputs& in);
};

struct FittedBody {
    BodyModel shaped;                       // the chosen body at the fitted shape, with its shoulders at rest as in the still pose
    BodyFit fit;                            // poses: of `shaped`
    PoseColumn<PoseSource::BodyFit> poses;  // those of `fit`
    std::vector<HandFit> hands;             // empty: the scan has no keypoints of hands
    std::vector<std::shared_ptr<const PosePrecision>> fingers;  // of each frame, how well its fingers are known; empty: as above
};

template <>
struct StageOf<FittedBody> {
    static constexpr StageName kName{"body-fit", 17};
    static constexpr const char* kPriors[] = {"input/cameras", "input/capture", "subject/body", "subject/hands"};
    static Status inputs(StageInputs& in);
    static Status make(StageInputs& in, StageContext& context);
    static Result<FittedBody> read(StageInputs& in, const std::filesystem::path& folder);
};

/** The result of fit.json as later stages use it. */
FittedBody fittedBody(const BodyModel& body, BodyFit fit);

/** Cameras of the frame table's rows, in metres. */
struct MetricCameras {
    std::vector<Camerad> cameras;
};

template <>
struct StageOf<MetricCameras> {
    static constexpr StageName kName{"metric-cameras", 1};
    static Status inputs(StageInputs& in);
    static Result<MetricCameras> compute(StageInputs& in);
};

}  // namespace dpl
