// SPDX-License-Identifier: Apache-2.0
// Maps floats to unsigned integers of the same order. Integer atomics then give a min and max that do not depend on the order of lanes.
uint dplOrderedBits(float x) {
    uint bits = floatBitsToUint(x);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}
float dplFromOrderedBits(uint ordered) {
    return uintBitsToFloat((ordered & 0x80000000u) != 0u ? ordered & 0x7FFFFFFFu : ~ordered);
}
