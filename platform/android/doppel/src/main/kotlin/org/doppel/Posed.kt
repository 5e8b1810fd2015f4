// SPDX-License-Identifier: Apache-2.0
// Posed splats and vertices in memory of the app, for engines that draw them themselves. Experimental, as in C.
package org.doppel

import java.nio.ByteBuffer

/** What a splat has; numbers, units and frames are those of DplSplatProperty. HARMONICS: spherical harmonics. */
enum class SplatProperty { POSITION, ROTATION, SCALE, COVARIANCE, OPACITY, COLOUR, HARMONICS, ROTATION_WXYZ }

/** What a vertex has; see DplVertexProperty. */
enum class VertexProperty { POSITION, NORMAL }

/**
 * Where one property lies in a buffer, bytes; see DplBufferElement. [strideBytes]: from one splat or vertex to the next; 0: without gaps.
 * [half]: numbers of 2 bytes, where those beyond 65504 become 65504.
 */
class BufferElement<Property : Enum<Property>> @JvmOverloads constructor(
    val property: Property,
    val offsetBytes: Long = 0,
    val strideBytes: Long = 0,
    val half: Boolean = false
)

/** Which splats are written, and for whom; see DplSplatOptions. [eye]: metres, world; null: splats show both sides. */
class SplatOptions @JvmOverloads constructor(val splatBudget: Int = 0, val eye: FloatArray? = null, val shDegree: Int = 0)

/** What was written: splats or vertices, and numbers that were too large for a half. */
class Written internal constructor(numbers: LongArray) {
    val count = numbers[0].toInt()
    val saturated = numbers[1]
}

private fun <Property : Enum<Property>> numbersOf(layout: List<BufferElement<Property>>) = layout.flatMap {
    listOf(it.property.ordinal.toLong(), if (it.half) 1L else 0L, it.offsetBytes, it.strideBytes)
}.toLongArray()

/** How many splats [writeSplats] writes. */
@JvmOverloads
fun Avatar.splatCount(options: SplatOptions = SplatOptions()) =
    Written(Native.writeSplats(number, null, null, options.splatBudget, options.eye, options.shDegree)).count

/**
 * Writes the splats of the current pose into a direct buffer, from its start, in the byte order of the machine. UNSUPPORTED: the context
 * draws on a GPU, which keeps them. See dplWriteSplats.
 */
@JvmOverloads
fun Avatar.writeSplats(layout: List<BufferElement<SplatProperty>>, buffer: ByteBuffer, options: SplatOptions = SplatOptions()) =
    Written(Native.writeSplats(number, numbersOf(layout), buffer, options.splatBudget, options.eye, options.shDegree))

/** Writes the vertices of the current pose into a direct buffer, whatever draws the avatar. See dplWriteMesh. */
fun Avatar.writeMesh(layout: List<BufferElement<VertexProperty>>, buffer: ByteBuffer) =
    Written(Native.writeMesh(number, numbersOf(layout), buffer))
