// SPDX-License-Identifier: Apache-2.0
package org.doppel

import java.util.concurrent.atomic.AtomicLong

/** A handle of native code with its end. Closing it twice does nothing. The number of a closed one is 0, which the library refuses. */
internal class Handle(number: Long, private val end: (Long) -> Unit) {
    private val value = AtomicLong(number)
    val number: Long get() = value.get()

    /** The number, which this object no longer ends. 0 if it was taken or closed before. */
    fun take(): Long = value.getAndSet(0)

    fun close() {
        val number = take()
        if (number != 0L) end(number)
    }
}
