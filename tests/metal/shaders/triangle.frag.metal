// SPDX-License-Identifier: Apache-2.0
// For tests of the software device: writes the value, interpolated and of the first vertex. Values with a negative alpha are discarded.
#include <metal_stdlib>
#include <simd/simd.h>

using namespace metal;

struct main0_out
{
    float4 value [[color(0)]];
    float4 kept [[color(1)]];
};

struct main0_in
{
    float4 value [[user(locn0)]];
    float4 kept [[user(locn1), flat]];
};

fragment main0_out main0(main0_in in [[stage_in]])
{
    main0_out out = {};
    if (in.kept.w < 0.0)
    {
        discard_fragment();
    }
    out.value = in.value;
    out.kept = in.kept;
    return out;
}
