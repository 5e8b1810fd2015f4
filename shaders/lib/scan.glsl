// SPDX-License-Identifier: Apache-2.0
// Exclusive prefix sum over one workgroup through shared memory, for any subgroup width. The includer defines DPL_SCAN_LANES, the
// workgroup size. All lanes must call it.
shared uint dplScanSums[DPL_SCAN_LANES];

uint dplExclusiveScan(uint lane, uint value, out uint total) {
    dplScanSums[lane] = value;
    barrier();
    for (uint reach = 1u; reach < DPL_SCAN_LANES; reach <<= 1u) {
        uint sum = dplScanSums[lane];
        if (lane >= reach) sum += dplScanSums[lane - reach];
        barrier();
        dplScanSums[lane] = sum;
        barrier();
    }
    uint before = dplScanSums[lane] - value;
    total = dplScanSums[DPL_SCAN_LANES - 1u];
    barrier();
    return before;
}
