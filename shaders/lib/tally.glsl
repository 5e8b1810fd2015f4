// SPDX-License-Identifier: Apache-2.0
// Counts that the lanes of a workgroup add up in shared memory. The includer defines DPL_LISTS, the most counts.
shared uint dplTally[DPL_LISTS];

/** Sets the first `lists` counts to zero. All lanes must call it. */
void dplClearTally(uint lists) {
    for (uint list = gl_LocalInvocationIndex; list < lists; list += kRunGroup) dplTally[list] = 0u;
    barrier();
}
