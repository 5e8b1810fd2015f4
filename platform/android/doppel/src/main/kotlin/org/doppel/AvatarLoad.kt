// SPDX-License-Identifier: Apache-2.0
package org.doppel

import java.io.Closeable

/** DplLoadState. */
enum class LoadState { WAITING, DECODING, UPLOADING, READY, FAILED }

class LoadStatus internal constructor(val state: LoadState, val progress: Float) {
    val isDone: Boolean get() = state >= LoadState.READY
}

/**
 * A load in the background. Ask for its [status] once a frame; when it is done, [finish] gives the avatar or throws the error of the load.
 * [close] cancels it. In a context of a view the upload is part of the frames: while none is drawn, the load waits.
 */
class AvatarLoad internal constructor(number: Long) : Closeable {
    private val handle = Handle(number, Native::cancelLoad)

    val status: LoadStatus
        get() {
            val numbers = FloatArray(2)
            Native.loadStatus(handle.number, numbers)
            return LoadStatus(LoadState.values()[numbers[0].toInt()], numbers[1])
        }

    /** Ends the load. Waits if it is not done. */
    fun finish(): Avatar = Avatar(Native.finishLoad(handle.take()))

    /** Cancels the load, unless it was finished. */
    override fun close() = handle.close()
}
