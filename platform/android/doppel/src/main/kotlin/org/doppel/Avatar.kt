// SPDX-License-Identifier: Apache-2.0
package org.doppel

import java.io.Closeable
import java.nio.ByteBuffer

/** What an avatar is. Lengths are metres. */
class AvatarInfo internal constructor(val name: String, counts: LongArray, bounds: FloatArray) {
    val jointCount = counts[0].toInt()
    val splatCount = counts[1].toInt()
    val vertexCount = counts[2].toInt()
    val triangleCount = counts[3].toInt()
    val layerCount = counts[4].toInt()
    val shDegree = counts[6].toInt()

    /** What the file holds; more than was loaded if memory was short. */
    val fileSplatCount = counts[7].toInt()
    val fileShDegree = counts[8].toInt()

    /** False: general splats of a file that does not say which way is up. */
    val axesStated = counts[9] != 0L
    val restMin = bounds.copyOfRange(0, 3)
    val restMax = bounds.copyOfRange(3, 6)
}

class Joint internal constructor(val name: String, val humanoidBone: String, val parent: Int, val restPosition: FloatArray)

/** What a face can show, by ARKit's name. [isDrawn]: the avatar holds it; otherwise its weight changes nothing. */
class Expression internal constructor(val name: String, val isDrawn: Boolean)

class Clip internal constructor(val index: Int, val name: String, val durationS: Double)

/** What the last finished frame drew and cost. */
class FrameStats internal constructor(counts: LongArray, times: DoubleArray) {
    val splatsDrawn = counts[0].toInt()
    val splatsAllowed = counts[1].toInt()

    /** Graphics memory of everything the context holds, and of this avatar alone. */
    val residentBytes = counts[2]
    val avatarBytes = counts[3]
    val budgetState = BudgetState.values()[counts[4].toInt().coerceIn(0, BudgetState.values().size - 1)]
    val framesOver = counts[5].toInt()
    val gpuMs = times[0]
    val frameMs = times[1]
    val detailShare = times[2]
}

/** DplBudgetState. */
enum class BudgetState { OFF, UNTIMED, FREE, LIMITED, UNREACHABLE }

/**
 * A person, or a set of general splats, which have no joints and no clips. Close it when it is needed no more. Any thread. A call after
 * [close] throws [DoppelException] with INVALID_ARGUMENT, as every other mistake does.
 */
class Avatar internal constructor(number: Long) : Closeable {
    private val handle = Handle(number, Native::destroyAvatar)
    internal val number: Long get() = handle.number

    val info: AvatarInfo
        get() {
            val counts = LongArray(10)
            val bounds = FloatArray(6)
            Native.avatarInfo(number, counts, bounds)
            return AvatarInfo(Native.avatarName(number), counts, bounds)
        }

    val joints: List<Joint>
        get() {
            val names = Native.jointNames(number)
            val tree = Native.jointTree(number)
            return List(names.size / 2) { j ->
                Joint(names[2 * j], names[2 * j + 1], tree[4 * j].toInt(), tree.copyOfRange(4 * j + 1, 4 * j + 4))
            }
        }

    val clips: List<Clip>
        get() {
            val counts = LongArray(10)
            Native.avatarInfo(number, counts, null)
            return List(counts[5].toInt()) { Clip(it, Native.clipName(number, it), Native.clipDuration(number, it)) }
        }

    val layers: List<Layer>
        get() {
            val names = Native.layerNames(number)
            return List(names.size / 2) { Layer(it, names[2 * it], names[2 * it + 1]) }
        }

    fun isHidden(layer: Layer): Boolean = Native.isLayerHidden(number, layer.index)

    /**
     * Hides a layer, or shows it again. UNSUPPORTED, with a sentence: no splats lie below it, as below most clothes of a scan. See
     * dplHideLayer.
     */
    @JvmOverloads
    fun hide(layer: Layer, hidden: Boolean = true) = Native.hideLayer(number, layer.index, hidden)

    /** By name, or by VRM humanoid bone. */
    fun findJoint(name: String): Int = Native.findJoint(number, name)

    /**
     * Where it stands in the world, until it is changed: a rotation, one scale and a translation as a 3 x 4 matrix, row by row. Twelve
     * numbers; see dplSetTransform.
     */
    var transform: FloatArray
        get() = FloatArray(12).also { Native.getTransform(number, it) }
        set(worldFromAvatar) = Native.setTransform(number, worldFromAvatar)

    /** rotations: x, y, z, w of each joint, local; identity at every joint is the rest pose. root: metres, or null for zero. */
    fun setPose(rotations: FloatArray, root: FloatArray? = null) = Native.setPose(number, rotations, root)

    /** The same for a picture that is shown at [timeNs], nanoseconds of any one clock: clothes then remember. */
    fun setPose(rotations: FloatArray, root: FloatArray?, timeNs: Long) = Native.setPoseAtTime(number, rotations, root, timeNs)

    /** Clothes forget: they are those of the current pose alone. */
    fun settle() = Native.settle(number)

    /** What the clothes remember in the current pose, and its time; it can be set for an avatar of the same file. */
    var motionState: ByteArray
        get() = Native.motionState(number)
        set(state) = Native.setMotionState(number, state)

    /** How stiff the clothes are, until changed: 0 to 100, 1 as learned; stiffer ones swing and lag less. See dplSetClothStiffness. */
    fun setClothStiffness(stiffness: Float) = Native.setClothStiffness(number, stiffness)

    /** All 52 expressions, in ARKit's order. */
    val expressions: List<Expression>
        get() = Native.expressionNames(number).mapIndexed { i, name -> Expression(name, Native.isExpressionDrawn(number, i)) }

    /**
     * What the face shows, until it is changed; poses do not touch it. A weight of 0 to 1 for each of [expressions]. See dplSetExpression.
     */
    var expression: FloatArray
        get() = Native.expression(number)
        set(weights) = Native.setExpression(number, weights)

    /** The same by names of ARKit, MediaPipe, Live Link, VRM or OpenXR; all others become zero. See dplSetExpressionNamed. */
    fun setExpression(weights: Map<String, Float>) = setExpression(weights.keys.toTypedArray(), weights.values.toFloatArray())

    /** The same for a stream that gives names and weights apart. */
    fun setExpression(names: Array<String>, weights: FloatArray) = Native.setExpressionNamed(number, names, weights)

    fun pose(): Pose {
        val pose = Pose(FloatArray(4 * info.jointCount), FloatArray(3))
        Native.getPose(number, pose.rotations, pose.root)
        return pose
    }

    /** Three numbers a joint, metres of the world. */
    fun jointPositions(): FloatArray = FloatArray(3 * info.jointCount).also { Native.jointPositions(number, it) }

    /** Poses the avatar as the clip does at [timeS]. With [loop], the time wraps around; else it is clamped. */
    fun setPose(clip: Clip, timeS: Double, loop: Boolean = true) = Native.setPoseFromClip(number, clip.index, timeS, loop)

    /** Reads a motion (BVH or glTF) from a direct buffer and retargets it onto this avatar. */
    fun loadClip(motion: ByteBuffer, name: String? = null, flags: Int = 0): Clip {
        val index = Native.loadClip(number, motion, motion.position().toLong(), motion.remaining().toLong(), flags, name)
        return Clip(index, Native.clipName(number, index), Native.clipDuration(number, index))
    }

    /**
     * Mixes clips for a picture that is shown at [timeNs], nanoseconds of any one clock: cross-fades, and layers over a part of the body.
     * The rules are those of dplSetPoseFromClips.
     */
    fun setPose(layers: List<ClipLayer>, timeNs: Long) =
        Native.setPoseFromClips(number, layers.flatMap { it.numbers().asList() }.toDoubleArray(), timeNs)

    /** Moves [layer] so that it goes on from where [before] stands, for a cross-fade of two recorded walks; see dplJoinClipLayer. */
    fun join(before: ClipLayer, layer: ClipLayer) {
        val numbers = layer.numbers()
        Native.joinClipLayer(number, before.numbers(), numbers)
        layer.headingRad = numbers[5].toFloat()
        layer.shiftM = floatArrayOf(numbers[6].toFloat(), numbers[7].toFloat())
    }

    /**
     * Blinks and glances of a face, 0 to 1, and the end of a stream, for a picture at [timeNs]: for each picture. Those of other seeds
     * blink at other times. A stream that spoke last at [heardNs] and is silent for [holdS] seconds has stopped; 0: what was set stays. See
     * dplSetFaceMotion.
     */
    @JvmOverloads
    fun setFaceMotion(timeNs: Long, seed: Int = 0, blinks: Float = 1f, glances: Float = 1f, holdS: Float = 0f, heardNs: Long = 0) =
        Native.setFaceMotion(number, timeNs, seed, floatArrayOf(blinks, glances, holdS), heardNs)

    /**
     * Turns neck, head and eyes of the current pose towards a point, metres in the space of the pose. Once after each pose, before drawing.
     * Weights are 0 to 1; limits are left or right, and up or down, radians, null: the usual ones. The rules are those of dplLookAtPoint.
     */
    @JvmOverloads
    fun lookAt(target: FloatArray, headWeight: Float = 0.7f, eyeWeight: Float = 1f, headLimitRad: FloatArray? = null,
        eyeLimitRad: FloatArray? = null) =
        Native.lookAtPoint(number, target + floatArrayOf(headWeight, eyeWeight) + (headLimitRad ?: FloatArray(2)) +
            (eyeLimitRad ?: FloatArray(2)))

    /**
     * The shadow by which the feet stand on a floor. [floorM]: height of the app's floor, metres; null: where the avatar stands at rest.
     * See dplGetContactShadow.
     */
    @JvmOverloads
    fun contactShadow(floorM: Float? = null): ContactShadow {
        val place = FloatArray(10)
        return ContactShadow(Native.contactShadow(number, floorM != null, floorM ?: 0f, place), place)
    }

    /**
     * A tracker that poses this avatar. flags: such as [BodyTracker.RAW]. rest: the platform's neutral pose, as [BodyTracker.track] takes
     * frames; null where the format needs none.
     */
    @JvmOverloads
    fun createTracker(format: TrackFormat, flags: Int = 0, restRotations: FloatArray? = null, restPositions: FloatArray? = null) =
        BodyTracker(Native.createTracker(number, format.ordinal, flags, restRotations, restPositions))

    /** How far the current pose lies from the trained ones. UNSUPPORTED: the avatar has no pose correctives, so it does not know. */
    fun poseTrust(): PoseTrust {
        val trust = FloatArray(5)
        val distances = FloatArray(info.jointCount)
        Native.poseTrust(number, trust, distances)
        return PoseTrust(trust, distances)
    }

    /** Turns joints of the current pose back until none is farther than [limit] from the trained poses; 4 is usual. */
    fun holdPose(limit: Float) = Native.holdPose(number, limit)

    fun frameStats(): FrameStats {
        val counts = LongArray(6)
        val times = DoubleArray(3)
        Native.frameStats(number, counts, times)
        return FrameStats(counts, times)
    }

    override fun close() = handle.close()

    companion object {
        /**
         * What a ray meets first of some avatars; null: nothing. origin: metres, world; direction: of any length above 0. See dplPick.
         */
        @JvmStatic
        fun pick(avatars: List<Avatar>, origin: FloatArray, direction: FloatArray): Pick? {
            val indices = IntArray(3)
            val place = FloatArray(7)
            val hit = Native.pick(DoppelContext.numbersOf(avatars), origin + direction, indices, place)
            return if (hit) Pick(avatars[indices[0]], indices[1], indices[2], place) else null
        }
    }
}

/** A part of an avatar: its body, a garment, its hair. [role]: "body", "garment" or "hair". */
class Layer internal constructor(val index: Int, val name: String, val role: String)

/** DplPick. [layer] and [joint] are indices into those of [avatar]. */
class Pick internal constructor(val avatar: Avatar, val layer: Int, val joint: Int, place: FloatArray) {
    /** Metres of the world; the normal is on the side that the ray comes from. */
    val distanceM = place[0]
    val point = place.copyOfRange(1, 4)
    val normal = place.copyOfRange(4, 7)
}

/**
 * A clip within a mix; see DplClipLayer. [joint]: it moves this joint and all below it; 0: the whole body. [travel]: each round of a loop
 * starts where the round before ended. [headingRad] and [shiftM], along x and z, move the whole clip; [Avatar.join] finds them.
 */
class ClipLayer @JvmOverloads constructor(
    val clip: Clip,
    var timeS: Double,
    var weight: Float = 1f,
    val joint: Int = 0,
    val loop: Boolean = true,
    val travel: Boolean = false
) {
    var headingRad = 0f
    var shiftM = FloatArray(2)

    /** As Native takes them. */
    internal fun numbers(): DoubleArray {
        val flags = (if (loop) 1 else 0) + (if (travel) 2 else 0)
        return doubleArrayOf(clip.index.toDouble(), timeS, weight.toDouble(), joint.toDouble(), flags.toDouble(), headingRad.toDouble(),
            shiftM[0].toDouble(), shiftM[1].toDouble())
    }
}

/**
 * DplContactShadow. [alpha]: row by row, [SIDE_PX] bytes a row, 255 is black. The picture reaches from [corner] along [across], its rows,
 * and along [along], its columns; metres of the world.
 */
class ContactShadow internal constructor(val alpha: ByteArray, place: FloatArray) {
    val corner = place.copyOfRange(0, 3)
    val across = place.copyOfRange(3, 6)
    val along = place.copyOfRange(6, 9)

    /** The largest alpha; 0: nothing is near the floor. */
    val darkest = place[9].toInt()

    companion object {
        const val SIDE_PX = 64
    }
}

/** DplPoseTrust. [distances]: of each joint from its mean in training, standard deviations; -1: not known. */
class PoseTrust internal constructor(trust: FloatArray, val distances: FloatArray) {
    /** Share of the pose-dependent offsets that is drawn; below 1 the pose lies outside the trained ones. */
    val offsets = trust[0]
    val away = trust[1]
    val offModes = trust[2]
    val farthestJoint = trust[3].toInt()
    val farthestDistance = trust[4]
}

class Pose(val rotations: FloatArray, val root: FloatArray)
