// SPDX-License-Identifier: Apache-2.0
package org.doppel

/**
 * How [Player.play] plays a clip. [speed]: of the clip's own time; below 0: backwards. [fadeS]: seconds within which it takes over from
 * what played before; 0: at once. [fromS]: where it starts. [loop]: otherwise it holds its last pose. [travel]: recorded walks go on from
 * where the person stands, in each round and from clip to clip.
 */
class Playback @JvmOverloads constructor(
    val speed: Double = 1.0,
    val fadeS: Double = 0.3,
    val fromS: Double = 0.0,
    val loop: Boolean = true,
    val travel: Boolean = false
)

/**
 * Play, pause, speed, loops and cross-fades of clips of one avatar, as layers for [Avatar.setPose]. Times are nanoseconds of any one clock;
 * the layers follow from the calls and from the time that is asked for, so every picture rate gives the same motion. A player of a part of
 * the body, such as a waving arm ([joint]: that joint and all below it), plays over that of the whole body (0): append its layers. One
 * thread at a time.
 */
class Player @JvmOverloads constructor(private val joint: Int = 0) {
    /** A clip that plays, or silence that fades in. Times are those of the player's clock, which stands still in a pause. */
    private class Voice(
        val layer: ClipLayer?,
        val startS: Double,
        val fadeS: Double,
        var fromS: Double,
        var sinceS: Double,
        var speed: Double
    ) {
        fun timeS(clock: Double) = fromS + (clock - sinceS) * speed
        fun share(clock: Double): Double {
            val t = if (fadeS > 0) (clock - startS) / fadeS else 1.0
            return if (t >= 1) 1.0 else if (t <= 0) 0.0 else t * t * (3 - 2 * t)
        }
    }

    private val voices = ArrayList<Voice>()
    private var clockS = 0.0 // at sinceNs
    private var sinceNs = 0L

    var isPaused = false
        private set

    /** Cross-fades to a clip of [avatar]. An error changes nothing. */
    @JvmOverloads
    fun play(avatar: Avatar, clip: Clip, nowNs: Long, how: Playback = Playback()) {
        if (!finite(how.speed) || !finite(how.fromS) || !finite(how.fadeS) || how.fadeS < 0)
            throw wrong("speed, fromS and fadeS of a clip must be finite, and fadeS not below 0")
        setPaused(isPaused, nowNs)
        val layer = ClipLayer(clip, how.fromS, 1f, joint, how.loop, how.travel)
        val last = voices.lastOrNull()
        val playing = last?.layer
        if (how.travel && joint == 0 && last != null && playing != null) avatar.join(at(playing, last.timeS(clockS), 1f), layer)
        voices.add(Voice(layer, clockS, how.fadeS, how.fromS, clockS, how.speed))
    }

    /** Fades out within [fadeS], of a part of the body: what plays beneath is left. The whole body always plays something. */
    @JvmOverloads
    fun stop(nowNs: Long, fadeS: Double = 0.3) {
        if (joint == 0) throw wrong("nothing plays beneath the whole body: pause it, or play another clip")
        if (!finite(fadeS) || fadeS < 0) throw wrong("fadeS must be finite and not below 0")
        if (voices.isNotEmpty()) voices.add(Voice(null, clock(nowNs), fadeS, 0.0, 0.0, 0.0))
    }

    /** Clips and fades stand still until [resume], also those that are played meanwhile. */
    fun pause(nowNs: Long) = setPaused(true, nowNs)

    fun resume(nowNs: Long) = setPaused(false, nowNs)

    /** Of the clip that was played last, from now on. */
    fun setSpeed(speed: Double, nowNs: Long) {
        if (!finite(speed)) throw wrong("the speed must be finite")
        val last = voices.lastOrNull() ?: return
        last.fromS = last.timeS(clock(nowNs))
        last.sinceS = clock(nowNs)
        last.speed = speed
    }

    /** What plays at [nowNs]; empty: nothing. What has faded out is forgotten, so a time before that gives no longer what it gave. */
    fun layers(nowNs: Long): List<ClipLayer> {
        val clock = clock(nowNs)
        val made = ArrayList<ClipLayer>()
        var left = 1.0 // of the weight, for what played before
        var i = voices.size - 1
        while (i >= 0 && left > 0 && made.size < MOST_LAYERS) {
            val voice = voices[i]
            val share = if (i == 0 && joint == 0) 1.0 else voice.share(clock)
            if (share == 1.0) {
                voices.subList(0, i).clear()
                i = 0
            }
            if (voice.layer != null && left * share > 0) made.add(at(voice.layer, voice.timeS(clock), (left * share).toFloat()))
            left *= 1 - share
            --i
        }
        return made
    }

    private fun at(layer: ClipLayer, timeS: Double, weight: Float): ClipLayer {
        val made = ClipLayer(layer.clip, timeS, weight, layer.joint, layer.loop, layer.travel)
        made.headingRad = layer.headingRad
        made.shiftM = layer.shiftM.copyOf()
        return made
    }

    private fun clock(nowNs: Long) = clockS + if (isPaused) 0.0 else (nowNs - sinceNs) * 1e-9

    private fun setPaused(paused: Boolean, nowNs: Long) {
        clockS = if (voices.isEmpty()) 0.0 else clock(nowNs)
        sinceNs = nowNs
        isPaused = paused
    }

    private fun finite(x: Double) = !x.isNaN() && !x.isInfinite()

    private fun wrong(why: String) = DoppelException(DoppelException.INVALID_ARGUMENT, why)

    private companion object {
        const val MOST_LAYERS = 64 // DPL_MAX_CLIP_LAYERS
    }
}
