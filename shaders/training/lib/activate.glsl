// SPDX-License-Identifier: Apache-2.0
// Limits of a row and the linear values that follow from it (TrainableSplats::activate of the trainer). The includer declares `splats`, `sh`
// and `rows`.
#include "reconstruction/training/trainer/activate.inl"

void activateSplat(uint i, float floorM) {
    uint row = i * frame.rowFloats;
    vec2 uv = nearestOnTriangle(vec2(rows[row], rows[row + 1u]));
    vec2 logScale = clamp(vec2(rows[row + 3u], rows[row + 4u]), kTrainMinLogScale, kTrainMaxLogScale);
    float logit = clamp(rows[row + 5u], -kTrainMaxLogit, kTrainMaxLogit);
    rows[row] = uv.x;
    rows[row + 1u] = uv.y;
    rows[row + 3u] = logScale.x;
    rows[row + 4u] = logScale.y;
    rows[row + 5u] = logit;
    vec2 scale = sqrt(exp(2.0 * logScale) + floorM * floorM);
    splats[i].u = uv.x;
    splats[i].v = uv.y;
    splats[i].phi = rows[row + 2u];
    splats[i].opacity = 1.0 / (1.0 + exp(-logit));
    splats[i].scale1M = scale.x;
    splats[i].scale2M = scale.y;
    for (uint k = 0u; k < frame.shFloats; ++k) sh[i * frame.shFloats + k] = rows[row + 6u + k];
}
