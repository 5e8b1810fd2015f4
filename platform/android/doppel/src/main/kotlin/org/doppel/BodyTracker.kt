// SPDX-License-Identifier: Apache-2.0
package org.doppel

import java.io.Closeable

/** Whose joints a tracker takes: their number, order and axes are those of the platform (DplTrackFormat). */
enum class TrackFormat {
    VRM,
    UNITY,
    ARKIT_BODY,
    FB_BODY,
    OPENXR_HANDS,
    MEDIAPIPE_POSE;

    /** In the platform's words, in the order in which frames have them. */
    val jointNames: List<String> get() = Native.trackJointNames(ordinal).toList()
}

/** DplTrackerState. */
enum class TrackerState { WAITING, TRACKING, LOST }

class TrackerStatus internal constructor(counts: LongArray, measures: FloatArray) {
    val state = TrackerState.values()[counts[0].toInt().coerceIn(0, TrackerState.values().size - 1)]

    /** Joints of the avatar that follow the tracker now. */
    val drivenJoints = counts[1].toInt()
    val framesTaken = counts[2].toInt()

    /** Late, swapped or of another skeleton. */
    val framesDropped = counts[3].toInt()

    /** Of the stream: frames a second, and the random part of a joint's rotation. 0: not known yet. */
    val rateHz = measures[0]
    val noiseDeg = measures[1]

    /** By which the filter lags, and by how much this pose was extrapolated, seconds. */
    val delayS = measures[2]
    val predictedS = measures[3]
}

/**
 * Turns what a platform tells of a person into poses of one avatar: [track] whenever there is news, [pose] for each picture. The rules,
 * such as what gaps and broken streams do, are those of dplCreateTracker in doppel.h. Any thread; [track] waits for no drawing.
 */
class BodyTracker internal constructor(number: Long) : Closeable {
    private val handle = Handle(number, Native::destroyTracker)

    /**
     * A frame. positions: three numbers for each joint of the format, metres, in one space with y up. rotations: x, y, z, w of each joint;
     * null for MEDIAPIPE_POSE. confidence: 0 to 1 for each joint, below 0.5: not tracked; null: all are. A joint with a number that is not
     * finite counts as not tracked. Throws CORRUPT_DATA if left and right are swapped or the skeleton is another's: that frame is dropped.
     */
    fun track(timeNs: Long, rotations: FloatArray?, positions: FloatArray, confidence: FloatArray? = null) =
        Native.trackFrame(handle.number, timeNs, rotations, positions, confidence)

    /** Poses the avatar for a picture that is shown at displayTimeNs, on the clock of the frames. */
    fun pose(displayTimeNs: Long): TrackerStatus {
        val counts = LongArray(4)
        val measures = FloatArray(4)
        Native.setPoseFromTracker(handle.number, displayTimeNs, counts, measures)
        return TrackerStatus(counts, measures)
    }

    /** Before or after the avatar. */
    override fun close() = handle.close()

    companion object {
        /** Flags of [Avatar.createTracker], combined by or: DplTrackerFlag. */
        const val RAW = 1
        const val KEEP_PLACE = 2
        const val IN_PLACE = 4
        const val OVER_POSE = 8
    }
}
