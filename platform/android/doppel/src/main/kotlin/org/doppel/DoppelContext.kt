// SPDX-License-Identifier: Apache-2.0
package org.doppel

import java.io.Closeable
import java.nio.ByteBuffer
import java.nio.FloatBuffer

/** DplRenderer. */
enum class Renderer { AUTO, SOFTWARE, VULKAN }

/** DplFill. */
enum class Fill { AUTO, QUADS, TILES }

/**
 * Loads avatars, and draws them into memory. [ViewRenderer] draws them into a window. Any thread; calls wait for one another.
 */
open class DoppelContext internal constructor(number: Long, end: (Long) -> Unit) : Closeable {
    private val handle = Handle(number, end)
    internal val number: Long get() = handle.number

    /** For people: "software (4 threads)". */
    val rendererName: String get() = Native.rendererName(number)

    /** Loads an avatar from the bytes between position and limit of a direct buffer, and waits. See [AvatarLoad.start] for not waiting. */
    fun loadAvatar(file: ByteBuffer): Avatar = Avatar(Native.loadAvatar(number, file, file.position().toLong(), file.remaining().toLong()))

    /** Starts to load. The buffer must not change, and must be direct; it is kept until it has been read. */
    fun startLoad(file: ByteBuffer): AvatarLoad =
        AvatarLoad(Native.startLoad(number, file, file.position().toLong(), file.remaining().toLong()))

    /** How many splats a pixel keeps; 0: all. 12 is hard to tell from all. splatBudget: most splats of a frame; 0: no limit. */
    fun setDetail(splatsPerPixel: Float, splatBudget: Int = 0) = Native.setDetail(number, splatsPerPixel, splatBudget)

    /** How long a frame may take on the GPU, milliseconds; 0: no budget. Frames that take longer are drawn with fewer splats. */
    fun setFrameBudget(milliseconds: Double) = Native.setFrameBudget(number, milliseconds)

    /** Most bytes of graphics memory, from the next load on; 0: no limit. Avatars that exceed it are loaded with less detail. */
    fun setMemoryLimit(bytes: Long) = Native.setMemoryLimit(number, bytes)

    /** Draws into memory and waits: RGBA, four bytes a pixel, premultiplied, top row first. The buffer is direct. */
    fun render(avatars: List<Avatar>, camera: Camera, rgba: ByteBuffer) = render(avatars, listOf(camera), listOf(rgba))

    /**
     * The same for one or two views of one size, such as both eyes', which are drawn at once; and their depth: metres along each view's z,
     * 0 where nothing is drawn, into direct FloatBuffers in native order. All buffers are written from their start.
     */
    @JvmOverloads
    fun render(avatars: List<Avatar>, cameras: List<Camera>, rgba: List<ByteBuffer>, depth: List<FloatBuffer>? = null) =
        Native.render(
            number, numbersOf(avatars), cameras.fold(FloatArray(0)) { all, camera -> all + camera.numbers() },
            Array(cameras.size) { cameras[it].sceneDepth }, rgba.toTypedArray(), depth?.toTypedArray()
        )

    /** Closes avatars' graphics too: they can still be asked and posed, but not drawn, and must still be closed. */
    override fun close() = handle.close()

    companion object {
        /** threads: of the CPU; 0: one for each core. cacheFolder: where the choice of a fill is kept, such as Context.getCacheDir. */
        @JvmStatic
        @JvmOverloads
        fun create(renderer: Renderer = Renderer.AUTO, threads: Int = 0, fill: Fill = Fill.AUTO, cacheFolder: String? = null) =
            DoppelContext(Native.createContext(renderer.ordinal, threads, fill.ordinal, cacheFolder), Native::destroyContext)

        /** Version of the native library: major, minor and patch. */
        @JvmStatic
        val version: String
            get() = Native.version().let { "${it shr 16}.${it shr 8 and 0xff}.${it and 0xff}" }

        internal fun numbersOf(avatars: List<Avatar>) = LongArray(avatars.size) { avatars[it].number }
    }
}
