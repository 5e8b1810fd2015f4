// SPDX-License-Identifier: Apache-2.0
package org.doppel

/**
 * How much graphics memory avatars may take: an eighth of the phone's, because apps share it with the GPU; on a warning, little more than
 * what is loaded. The limit holds for the next loads; what is loaded stays until it is closed.
 */
object MemoryPolicy {
    private const val MIB = 1L shl 20

    /** totalBytes: ActivityManager.MemoryInfo.totalMem. */
    fun usualLimit(totalBytes: Long): Long = totalBytes / 8

    /** level: of ComponentCallbacks2.onTrimMemory. From Android 14 on, only TRIM_MEMORY_UI_HIDDEN and _BACKGROUND come. */
    fun limitFor(level: Int, residentBytes: Long, usualLimit: Long): Long {
        val more = when {
            level >= BACKGROUND -> 16 * MIB
            level >= UI_HIDDEN -> return usualLimit
            level >= RUNNING_CRITICAL -> 16 * MIB
            level >= RUNNING_LOW -> 64 * MIB
            else -> return usualLimit
        }
        return minOf(usualLimit, residentBytes + more)
    }

    // The numbers of ComponentCallbacks2, so that this file needs no Android.
    private const val RUNNING_LOW = 10
    private const val RUNNING_CRITICAL = 15
    private const val UI_HIDDEN = 20
    private const val BACKGROUND = 40
}
