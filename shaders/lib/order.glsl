// SPDX-License-Identifier: Apache-2.0
// Floats as unsigned integers that sort alike: lets integer atomics take an order-independent, hence deterministic, min and max.
uint dplOrderedBits(float x) {
    uint bits = floatBitsToUint(x);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}
float dplFromOrderedBits(uint ordered) {
    return uintBitsToFloat((ordered & 0x80000000u) != 0u ? ordered & 0x7FFFFFFFu : ~ordered);
}
