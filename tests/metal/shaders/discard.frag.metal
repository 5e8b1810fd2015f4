// SPDX-License-Identifier: Apache-2.0
// For tests of the software device: discards every fragment, then reads an element of a buffer.
#include <metal_stdlib>
#include <simd/simd.h>

using namespace metal;

struct NumberBlock
{
    float4 fours[1];
};

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

fragment main0_out main0(main0_in in [[stage_in]], const device NumberBlock& numbers [[buffer(0)]])
{
    main0_out out = {};
    discard_fragment();
    out.value = numbers.fours[uint(in.kept.x)];
    out.kept = in.kept;
    return out;
}
