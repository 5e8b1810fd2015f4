// SPDX-License-Identifier: Apache-2.0
package org.doppel

import java.io.Closeable

/**
 * Draws avatars into a window by Vulkan. Its [context] loads them, and lives as long as this object. [AvatarView] drives it; a program
 * with a SurfaceView or TextureView of its own may do so too. Any thread; calls wait for one another, so after [setWindow] nothing draws
 * into the earlier window.
 */
class ViewRenderer private constructor(number: Long) : Closeable {
    private val handle = Handle(number, Native::destroyView)

    /** Closed by this object. */
    val context = DoppelContext(Native.viewContext(number)) {}

    /** What the validation layer said; empty without it. */
    val complaints: List<String> get() = Native.viewComplaints(handle.number).toList()

    /** surface: an android.view.Surface; null: no window any more. Size of its pixels. */
    fun setWindow(surface: Any?, widthPx: Int, heightPx: Int) = Native.setWindow(handle.number, surface, widthPx, heightPx)

    /**
     * Draws and shows a frame. [background]: red, green and blue, 0 to 1. [shadows]: with the contact shadows of the first four
     * avatars over the background. Throws if the avatars could not be drawn; the next frame may.
     */
    fun draw(avatars: List<Avatar>, camera: Camera, background: FloatArray = BLACK, shadows: Boolean = false): Outcome {
        require(background.size == 3) { "a background has 3 numbers, not ${background.size}" }
        val drawn = Native.drawView(
            handle.number, DoppelContext.numbersOf(avatars), camera.numbers(), camera.sceneDepth,
            background[0], background[1], background[2], shadows
        )
        return Outcome.values()[drawn]
    }

    override fun close() {
        handle.close()
        context.close()
    }

    companion object {
        private val BLACK = floatArrayOf(0f, 0f, 0f)

        /**
         * cacheFolder: as for [DoppelContext.create]. validation: with the Vulkan validation layer, if the APK has it.
         * Throws UNSUPPORTED where there is no Vulkan 1.1.
         */
        @JvmStatic
        @JvmOverloads
        fun create(fill: Fill = Fill.AUTO, cacheFolder: String? = null, validation: Boolean = false) =
            ViewRenderer(Native.createView(fill.ordinal, cacheFolder, validation))
    }
}
