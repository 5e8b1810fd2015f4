// SPDX-License-Identifier: Apache-2.0
// From the layer that a renderer leaves to the caller's pixels. Avatars are blended in a layer that is display-referred, as they were
// trained; it meets the caller's target once, here, for both renderers:
//
//   DPL_FORMAT_RGBA8        layer ─► over                                                                              (display values as
//   they are) DPL_FORMAT_RGBA8_SRGB   layer ─► un-premultiply ─► decode sRGB ─► premultiply ─► over what is decoded ─► encode    (what a
//   *_SRGB attachment does) DPL_FORMAT_RGBA16F      layer ─► un-premultiply ─► decode sRGB ─► premultiply ─► over (linear light)
//
// Alpha is linear everywhere. 8-bit results are the nearest code, f16 ones the nearest half of a sum in float.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sdk/include/doppel/doppel.h"

namespace dpl::api {

struct Composition {
    DplImageFormat format = DPL_FORMAT_RGBA8;
    bool over = false;      // what the target holds, premultiplied; else over transparent black
    bool straight = false;  // colour divided by alpha; not together with over
};

constexpr size_t pixelBytes(DplImageFormat format) {
    return format == DPL_FORMAT_RGBA16F ? 8 : 4;
}

/** layer: `pixels` × premultiplied RGBA8, display-referred. target: pixels · pixelBytes(format) bytes, any alignment. Where the layer has
 * alpha 0 a target that is drawn over keeps its bytes; where it has 255 the target becomes the layer. Allocates nothing. */
void composeRow(const uint8_t* layer, size_t pixels, const Composition& how, uint8_t* target);

}  // namespace dpl::api
