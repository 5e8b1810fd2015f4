// SPDX-License-Identifier: Apache-2.0
// Composes a renderer's picture layer into the caller's pixels. Splats are blended in display-referred values, as they were trained, into a
// layer over transparent black. The layer is then composed once, here, for both renderers (docs/adr/0008-depth-and-targets.md):
//
//   DPL_FORMAT_RGBA8        over, in display-referred values
//   DPL_FORMAT_RGBA8_SRGB   un-premultiply, decode sRGB, premultiply, over the decoded target, encode: as a *_SRGB attachment blends
//   DPL_FORMAT_RGBA16F      un-premultiply, decode sRGB, premultiply, over, in linear light
//
// Alpha is linear in all formats. 8-bit results are the nearest code; f16 results are the nearest half of a sum in float.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sdk/include/doppel/doppel.h"

namespace dpl::api {

struct Composition {
    DplImageFormat format = DPL_FORMAT_RGBA8;
    bool over = false;      // over the target's premultiplied pixels; else over transparent black
    bool straight = false;  // write colour divided by alpha; not together with `over`
};

constexpr size_t pixelBytes(DplImageFormat format) {
    return format == DPL_FORMAT_RGBA16F ? 8 : 4;
}

/** layer: `pixels` × premultiplied RGBA8, display-referred. target: pixels · pixelBytes(format) bytes, any alignment. With `over`, pixels
 * where the layer has alpha 0 keep their bytes, and pixels where it has alpha 255 become the layer. Allocates nothing. */
void composeRow(const uint8_t* layer, size_t pixels, const Composition& how, uint8_t* target);

}  // namespace dpl::api
