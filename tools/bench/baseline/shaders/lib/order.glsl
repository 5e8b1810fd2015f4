// SPDX-License-Identifier: Apache-2.0
// Floats as unsigned integers that sort alike.
uint dplOrderedBits(float x) {
    uint bits = floatBitsToUint(x);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}
