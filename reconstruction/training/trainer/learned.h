// SPDX-License-Identifier: Apache-2.0
// The learned state of a training run, and the list of its fields. Saving, loading and checking a checkpoint share that list.
#pragma once

#include "reconstruction/training/trainer/co_optimise.h"

namespace dpl {

/** The learned state of the surface and its splats, with the optimisers' moments. */
struct LearnedLayer {
    TrainableSplats splats;
    AdamRows adam;
    DensityStatistics statistics;
    std::vector<Vec3f> u;  // V parameters of LargeSteps; empty when geometry is not learned
    AdamUniform adamOffsets;
    std::vector<Vec3f> restGradientSum;  // since the last LargeSteps update
    uint32_t restGradientCount = 0;
    PoseCorrectiveData correctives;  // only `nodes` are learned
    AdamRows adamNodes;              // a row a node
};

/** The learned state of one frame. */
struct LearnedFrame {
    Pose pose;
    AdamVector adamPose;
};

/** Loss sums over the steps since the last point of the curve. */
struct LossSums {
    double loss = 0, l1 = 0, ssim = 0, mask = 0, squaredError = 0, squaredCount = 0;
    uint32_t steps = 0;
};

struct Learned {
    uint32_t step = 0;
    LearnedLayer layer;
    std::vector<LearnedFrame> frames;  // one a training frame
    std::vector<CurvePoint> curve;
    LossSums sums;
};

/** Visits every stored field of `learned`, in the order of the checkpoint file, with the required length of each array:
 *      visit.value(name, field)                   a number or a vector of numbers
 *      visit.array(name, field, count)            exactly `count` entries
 *      visit.arrayOrEmpty(name, field, count)     `count` entries, or none before the first step
 *      visit.arrayOfAnySize(name, field)
 *  `shape` is a prepared state of the same run at any step. It gives the sizes that never change. Sizes of splat arrays follow from the
 *  fields visited before them. Stops at the first error. */
template <class LearnedOrConst, class Visit>
Status visitLearned(LearnedOrConst& learned, const Learned& shape, Visit& visit) {
    auto& layer = learned.layer;
    DPL_RETURN_IF_ERROR(visit.value("step", learned.step));
    DPL_RETURN_IF_ERROR(visit.value("SH degree", layer.splats.shDegree));
    if (layer.splats.shDegree > kMaxShDegree) return fail(Code::CorruptData, "SH degree {}", layer.splats.shDegree);
    DPL_RETURN_IF_ERROR(visit.arrayOfAnySize("triangles", layer.splats.triangle));
    const size_t splats = layer.splats.triangle.size(), rowFloats = splats * TrainableSplats::strideFor(layer.splats.shDegree);
    DPL_RETURN_IF_ERROR(visit.array("flags", layer.splats.flags, splats));
    DPL_RETURN_IF_ERROR(visit.array("rows", layer.splats.rows, rowFloats));
    DPL_RETURN_IF_ERROR(visit.array("size floors", layer.splats.sizeFloorM, shape.layer.splats.sizeFloorM.size()));
    DPL_RETURN_IF_ERROR(visit.array("splats' first moments", layer.adam.first, rowFloats));
    DPL_RETURN_IF_ERROR(visit.array("splats' second moments", layer.adam.second, rowFloats));
    DPL_RETURN_IF_ERROR(visit.array("splats' steps", layer.adam.steps, splats));
    DPL_RETURN_IF_ERROR(visit.array("screen gradients", layer.statistics.gradientSum, splats));
    DPL_RETURN_IF_ERROR(visit.array("frames that saw a splat", layer.statistics.seen, splats));

    DPL_RETURN_IF_ERROR(visit.array("offset parameters", layer.u, shape.layer.u.size()));
    DPL_RETURN_IF_ERROR(visit.arrayOrEmpty("offsets' first moments", layer.adamOffsets.first, shape.layer.u.size()));
    DPL_RETURN_IF_ERROR(visit.arrayOrEmpty("offsets' second moments", layer.adamOffsets.second, shape.layer.u.size()));
    DPL_RETURN_IF_ERROR(visit.value("offsets' steps", layer.adamOffsets.steps));
    DPL_RETURN_IF_ERROR(visit.array("rest gradients", layer.restGradientSum, shape.layer.restGradientSum.size()));
    DPL_RETURN_IF_ERROR(visit.value("rest gradients' count", layer.restGradientCount));

    DPL_RETURN_IF_ERROR(visit.array("corrective nodes", layer.correctives.nodes, shape.layer.correctives.nodes.size()));
    DPL_RETURN_IF_ERROR(visit.array("nodes' first moments", layer.adamNodes.first, shape.layer.adamNodes.first.size()));
    DPL_RETURN_IF_ERROR(visit.array("nodes' second moments", layer.adamNodes.second, shape.layer.adamNodes.second.size()));
    DPL_RETURN_IF_ERROR(visit.array("nodes' steps", layer.adamNodes.steps, shape.layer.adamNodes.steps.size()));

    for (size_t f = 0; f < learned.frames.size(); ++f) {
        auto& frame = learned.frames[f];
        const size_t joints = shape.frames.front().pose.localRotations.size();
        const size_t poseNumbers = shape.frames[f].adamPose.first.size();
        DPL_RETURN_IF_ERROR(visit.array("pose", frame.pose.localRotations, joints));
        DPL_RETURN_IF_ERROR(visit.value("root translation", frame.pose.rootTranslation));
        DPL_RETURN_IF_ERROR(visit.array("pose's first moments", frame.adamPose.first, poseNumbers));
        DPL_RETURN_IF_ERROR(visit.array("pose's second moments", frame.adamPose.second, poseNumbers));
        DPL_RETURN_IF_ERROR(visit.value("pose's steps", frame.adamPose.steps));
    }

    DPL_RETURN_IF_ERROR(visit.arrayOfAnySize("curve", learned.curve));
    DPL_RETURN_IF_ERROR(visit.value("sum of losses", learned.sums.loss));
    DPL_RETURN_IF_ERROR(visit.value("sum of L1", learned.sums.l1));
    DPL_RETURN_IF_ERROR(visit.value("sum of SSIM", learned.sums.ssim));
    DPL_RETURN_IF_ERROR(visit.value("sum of mask losses", learned.sums.mask));
    DPL_RETURN_IF_ERROR(visit.value("sum of squared errors", learned.sums.squaredError));
    DPL_RETURN_IF_ERROR(visit.value("squared errors", learned.sums.squaredCount));
    return visit.value("summed steps", learned.sums.steps);
}

}  // namespace dpl
