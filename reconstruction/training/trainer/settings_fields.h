// SPDX-License-Identifier: Apache-2.0
// The fields of the training settings. A checkpoint's fingerprint and a stage's key are made from these lists.
//
// Each function calls visit(name, value) for every field. The structured binding names all fields, so the code does not compile when a
// struct has a field that its list lacks.
#pragma once

#include "reconstruction/training/trainer/co_optimise.h"
#include "reconstruction/training/trainer/polish.h"

namespace dpl {

template <class Visit>
void visitFields(const LossWeights& weights, Visit&& visit) {
    const auto& [l1, ssim, mask, cloth] = weights;
    visit("l1", l1), visit("ssim", ssim), visit("mask", mask), visit("cloth", cloth);
}

template <class Visit>
void visitFields(const RegulariserWeights& weights, Visit&& visit) {
    const auto& [scaleHinge, anisotropy, edgeRatio, laplacian, collision] = weights;
    visit("scaleHinge", scaleHinge), visit("anisotropy", anisotropy), visit("edgeRatio", edgeRatio);
    visit("laplacian", laplacian), visit("collision", collision);
}

template <class Visit>
void visitFields(const InitSettings& settings, Visit&& visit) {
    const auto& [splatCount, shDegree, clothLabels, openLabels] = settings;
    visit("splatCount", splatCount), visit("shDegree", shDegree);
    visit("clothLabels", clothLabels), visit("openLabels", openLabels);
}

template <class Visit>
void visitFields(const CoOptimiseSettings& settings, Visit&& visit) {
    const auto& [seed, steps, init, maxSplats, loss, earlyMaskFactor, regularise, closeupStepScale, learnSplats, learnGeometry, learnPoses,
                 learnCorrectives, learnMotion, learnLight, densify, learnPlacement, fullResolutionOnly, rateUv, endUv, ratePhi,
                 rateLogScale, endLogScale, rateOpacity, endOpacity, rateDc, rateRest, endColour, rateOffsets, endOffsets, rateRotation,
                 rateTranslation, endPose, rateNodeOffset, rateNodeLight, endNodes, nodeDecay, smoothingLengthM, geometryEvery,
                 densityEvents, levelStarts] = settings;
    visit("seed", seed), visit("steps", steps), visit("init", init), visit("maxSplats", maxSplats);
    visit("loss", loss), visit("earlyMaskFactor", earlyMaskFactor), visit("regularise", regularise);
    visit("closeupStepScale", closeupStepScale);
    visit("learnSplats", learnSplats), visit("learnGeometry", learnGeometry), visit("learnPoses", learnPoses);
    visit("learnCorrectives", learnCorrectives), visit("learnMotion", learnMotion), visit("learnLight", learnLight);
    visit("densify", densify);
    visit("learnPlacement", learnPlacement), visit("fullResolutionOnly", fullResolutionOnly);
    visit("rateUv", rateUv), visit("endUv", endUv), visit("ratePhi", ratePhi);
    visit("rateLogScale", rateLogScale), visit("endLogScale", endLogScale);
    visit("rateOpacity", rateOpacity), visit("endOpacity", endOpacity);
    visit("rateDc", rateDc), visit("rateRest", rateRest), visit("endColour", endColour);
    visit("rateOffsets", rateOffsets), visit("endOffsets", endOffsets);
    visit("rateRotation", rateRotation), visit("rateTranslation", rateTranslation), visit("endPose", endPose);
    visit("rateNodeOffset", rateNodeOffset), visit("rateNodeLight", rateNodeLight), visit("endNodes", endNodes);
    visit("nodeDecay", nodeDecay), visit("smoothingLengthM", smoothingLengthM);
    visit("geometryEvery", geometryEvery), visit("densityEvents", densityEvents), visit("levelStarts", levelStarts);
}

template <class Visit>
void visitFields(const PoseFitSettings& settings, Visit&& visit) {
    const auto& [iterations, seed, rateRotation, rateTranslation, end, pictureTrust, depthTrust, loss] = settings;
    visit("iterations", iterations), visit("seed", seed), visit("rateRotation", rateRotation), visit("rateTranslation", rateTranslation);
    visit("end", end), visit("pictureTrust", pictureTrust), visit("depthTrust", depthTrust), visit("loss", loss);
}

}  // namespace dpl
