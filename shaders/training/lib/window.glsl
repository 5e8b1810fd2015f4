// SPDX-License-Identifier: Apache-2.0
// SSIM's window of 11 × 11 pixels, σ = 1.5, as two passes of 11 taps (docs/reference/metrics.md). Pixels outside the picture count as zero.
const int kWindowReach = 5;
const float kTap[11] = float[11](0.00102838008, 0.00759875814, 0.0360007721, 0.10936069, 0.213005538, 0.266011725, 0.213005538, 0.10936069,
                                 0.0360007721, 0.00759875814, 0.00102838008);
