// SPDX-License-Identifier: Apache-2.0
// Sum over the 256 lanes of a workgroup, always in the same order.
shared float sumsOfLanes[256];

/** All lanes must call it. The result is right in lane 0. */
float sumOfGroup(float value) {
    uint lane = gl_LocalInvocationIndex;
    barrier();
    sumsOfLanes[lane] = value;
    barrier();
    for (uint reach = 128u; reach > 0u; reach >>= 1u) {
        if (lane < reach) sumsOfLanes[lane] += sumsOfLanes[lane + reach];
        barrier();
    }
    return sumsOfLanes[0];
}
