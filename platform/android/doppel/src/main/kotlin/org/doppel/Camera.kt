// SPDX-License-Identifier: Apache-2.0
package org.doppel

import java.nio.FloatBuffer
import kotlin.math.cos
import kotlin.math.sin
import kotlin.math.tan

/**
 * A pinhole camera, as DplCamera: it looks along its +z axis, with x to the right and y down. [viewFromWorld] has three rows of four,
 * metres. Focal lengths and the principal point are in pixels. [sceneDepth]: what the app itself shows hides the avatar: metres along the
 * view's z for each pixel, rows from the top, 0 where nothing is; a direct FloatBuffer in native order, read from its start during the
 * call.
 */
class Camera(
    val widthPx: Int,
    val heightPx: Int,
    val fx: Float,
    val fy: Float,
    val cx: Float,
    val cy: Float,
    val viewFromWorld: FloatArray,
    val sceneDepth: FloatBuffer? = null
) {
    internal fun numbers(): FloatArray {
        require(viewFromWorld.size == 12) { "viewFromWorld has 12 numbers, not ${viewFromWorld.size}" }
        return floatArrayOf(widthPx.toFloat(), heightPx.toFloat(), fx, fy, cx, cy) + viewFromWorld
    }
}

/** A camera that circles around a point. Angles are radians, lengths metres; [fovYRad] is the vertical field of view. */
class OrbitCamera {
    var targetX = 0f
    var targetY = 1f
    var targetZ = 0f
    var distanceM = 3f
        set(value) {
            field = value.coerceIn(0.3f, 100f)
        }
    var yawRad = 0f
    var pitchRad = 0f
        set(value) {
            field = value.coerceIn(-1.5f, 1.5f)
        }
    var fovYRad = 0.6f

    /** Looks at the whole of an avatar from the front. */
    fun frame(avatar: Avatar) {
        val low = avatar.info.restMin
        val high = avatar.info.restMax
        targetX = (low[0] + high[0]) / 2
        targetY = (low[1] + high[1]) / 2
        targetZ = (low[2] + high[2]) / 2
        distanceM = 0.6f * (high[1] - low[1]) / tan(fovYRad / 2)
        yawRad = 0f
        pitchRad = 0f
    }

    /** Drag of a finger, in shares of the view's height: to the right turns the avatar to the right. */
    fun drag(x: Float, y: Float) {
        yawRad -= 3 * x
        pitchRad += 2 * y
    }

    fun zoom(factor: Float) {
        distanceM /= factor
    }

    fun camera(widthPx: Int, heightPx: Int): Camera {
        val cosYaw = cos(yawRad)
        val sinYaw = sin(yawRad)
        val cosPitch = cos(pitchRad)
        val sinPitch = sin(pitchRad)
        // Axes of the view in the world. At rest the camera stands at +z and looks along -z, because avatars face +z.
        val right = floatArrayOf(cosYaw, 0f, -sinYaw)
        val down = floatArrayOf(sinYaw * sinPitch, -cosPitch, cosYaw * sinPitch)
        val ahead = floatArrayOf(-sinYaw * cosPitch, -sinPitch, -cosYaw * cosPitch)
        val view = FloatArray(12)
        for ((row, axis) in arrayOf(right, down, ahead).withIndex()) {
            for (i in 0..2) view[4 * row + i] = axis[i]
            view[4 * row + 3] = -(axis[0] * targetX + axis[1] * targetY + axis[2] * targetZ)
        }
        view[11] += distanceM
        val focal = heightPx / (2 * tan(fovYRad / 2))
        return Camera(widthPx, heightPx, focal, focal, widthPx / 2f, heightPx / 2f, view)
    }
}
