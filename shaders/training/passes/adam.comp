// SPDX-License-Identifier: Apache-2.0
// Updates the rows of the splats that a picture showed, as AdamRows and TrainableSplats::activate() of the trainer do: terms on the
// parameters themselves, Adam with a bias correction of each row's own, limits, and the linear values that the next step draws.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/lib/train.glsl"
layout(local_size_x = 128) in;  // kTrainGroup

layout(std430, binding = 1) buffer SplatBlock { TrainSplat splats[]; };
layout(std430, binding = 2) writeonly buffer ShBlock { float sh[]; };
layout(std430, binding = 3) buffer RowBlock { float rows[]; };
layout(std430, binding = 4) readonly buffer GradientBlock { float gradients[]; };
layout(std430, binding = 5) readonly buffer ShownBlock { float shown[]; };
layout(std430, binding = 6) buffer FirstBlock { float firsts[]; };
layout(std430, binding = 7) buffer SecondBlock { float seconds[]; };
layout(std430, binding = 8) buffer StepBlock { uint steps[]; };
layout(std430, binding = 9) buffer DensitySumBlock { float densitySums[]; };
layout(std430, binding = 10) buffer SeenBlock { uint seen[]; };
layout(std430, binding = 11) readonly buffer ConstantBlock { TrainTriangleConstants constants[]; };
layout(std430, binding = 12) readonly buffer RateBlock { float rates[]; };              // of each column
layout(std430, binding = 13) readonly buffer CorrectionBlock { vec2 corrections[]; };   // of both moments, by the number of steps

#include "shaders/training/lib/activate.glsl"

bool isFinite(float x) { return abs(x) < 3.0e38; }

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= frame.splatCount || frame.updates == 0u || shown[i] < 0.0) return;
    TrainSplat s = splats[i];
    TrainTriangleConstants t = constants[s.triangle];
    if (t.learns == 0u) return;
    uint row = i * frame.rowFloats;

    // Terms on the size (addSplatRegularisers).
    vec2 scale = vec2(s.scale1M, s.scale2M), slope = max(vec2(0.0), scale * scale - t.floorM * t.floorM) / (scale * scale), term = vec2(0.0);
    if (scale.x > kTrainMaxSizeRatio * t.referenceM) term.x += frame.sizeTerm * scale.x / t.referenceM * slope.x;
    if (scale.y > kTrainMaxSizeRatio * t.referenceM) term.y += frame.sizeTerm * scale.y / t.referenceM * slope.y;
    float logRatio = log(scale.x / scale.y);
    if (abs(logRatio) > kTrainLogAnisotropy) term += frame.anisotropyTerm * sign(logRatio) * vec2(slope.x, -slope.y);

    float squares = 0.0;
    for (uint k = 0u; k < frame.rowFloats; ++k) {
        float g = gradients[row + k] + (k == 3u ? term.x : k == 4u ? term.y : 0.0);
        squares += g * g;
    }
    bool sound = isFinite(squares);
    float screen = shown[i] * frame.halfHeight;
    if (sound && frame.countsDensity != 0u && isFinite(screen)) {
        densitySums[i] += screen;
        seen[i] += 1u;
    }
    uint step_ = min(steps[i] + 1u, kTrainLastCorrection);
    steps[i] += 1u;
    vec2 correction = corrections[step_];
    for (uint k = 0u; k < frame.rowFloats; ++k) {
        float g = sound ? gradients[row + k] + (k == 3u ? term.x : k == 4u ? term.y : 0.0) : 0.0;
        float m = kTrainBeta1 * firsts[row + k] + (1.0 - kTrainBeta1) * g, v = kTrainBeta2 * seconds[row + k] + (1.0 - kTrainBeta2) * (g * g);
        firsts[row + k] = m;
        seconds[row + k] = v;
        rows[row + k] -= rates[k] * (m * correction.x / (sqrt(v * correction.y) + 1e-15));
    }
    activateSplat(i, t.floorM);
}
