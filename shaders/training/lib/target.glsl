// SPDX-License-Identifier: Apache-2.0
// A pixel of the target (PictureTarget of the trainer). The includer declares `targets`.
struct TargetPixel {
    vec3 colour;  // premultiplied by `shown`
    vec3 behind;  // what the pixel shows where the drawing is transparent
    float mask, cloth, shown, unsure;
};

TargetPixel targetAt(uint pixel) {
    vec4 colour = unpackUnorm4x8(targets[kTrainPictureWords * pixel]), parts = unpackUnorm4x8(targets[kTrainPictureWords * pixel + 1u]);
    TargetPixel t;
    t.colour = colour.rgb;
    t.mask = colour.w;
    t.cloth = parts.x;
    t.shown = frame.hasShown != 0u ? parts.y : t.mask;
    t.unsure = frame.hasUnsure != 0u ? parts.z : 0.0;
    t.behind = frame.background.rgb;
    if (t.unsure > 0.0)
        t.behind = unpackUnorm4x8(targets[kTrainPictureWords * pixel + 2u]).rgb + (1.0 - t.unsure) * frame.background.rgb;
    return t;
}
