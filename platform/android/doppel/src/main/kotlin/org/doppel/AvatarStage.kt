// SPDX-License-Identifier: Apache-2.0
package org.doppel

import java.io.Closeable
import java.nio.ByteBuffer

/**
 * What a view shows and how it goes on from frame to frame: avatars, a load, a clip, a camera. It knows no Android, so tests drive it on a
 * desktop; [AvatarView] gives it windows and frames. One lock guards it, so any thread may call.
 */
class AvatarStage(private val renderer: ViewRenderer) : Closeable {
    interface Listener {
        /** 0 to 1, whenever it has changed. */
        fun onProgress(progress: Float) {}

        fun onLoaded(avatar: Avatar) {}

        /** A load or a frame failed; the message is a sentence for people. */
        fun onError(error: DoppelException) {}
    }

    val orbit = OrbitCamera()
    var background = floatArrayOf(0.1f, 0.11f, 0.13f)

    /** Whether the avatar's contact shadow is drawn over the background. */
    @Volatile
    var shadows = true
    @Volatile
    var listener: Listener = object : Listener {}

    private val lock = Any()
    private var load: AvatarLoad? = null
    private var progress = -1f
    private var shown: Avatar? = null
    private var clip: Clip? = null
    private var tracker: BodyTracker? = null
    private var clipStartNs = 0L
    private var widthPx = 0
    private var heightPx = 0
    private var broken = false

    /** The avatar that is shown, or null. The stage closes it. */
    val avatar: Avatar? get() = synchronized(lock) { shown }
    val isLoading: Boolean get() = synchronized(lock) { load != null }

    /** Loads a file, in place of the avatar that is shown and of a load that goes on. See [DoppelContext.startLoad] for the buffer. */
    fun show(file: ByteBuffer) = synchronized(lock) {
        load?.close()
        load = null
        progress = -1f
        load = renderer.context.startLoad(file)
    }

    fun play(clip: Clip?) = synchronized(lock) {
        this.clip = clip
        clipStartNs = 0
    }

    /**
     * The avatar follows a tracker of its own, over the clip if the tracker has [BodyTracker.OVER_POSE]. Its frames must be told on
     * Choreographer's clock, System.nanoTime. Null: no more. The caller closes the tracker, after this.
     */
    fun follow(tracker: BodyTracker?) = synchronized(lock) { this.tracker = tracker }

    /** See [DoppelContext.setDetail] and [DoppelContext.setFrameBudget]. */
    fun setDetail(splatsPerPixel: Float, budgetMs: Double) {
        renderer.context.setDetail(splatsPerPixel)
        renderer.context.setFrameBudget(budgetMs)
    }

    /** surface: an android.view.Surface; null: none. When this returns, no frame uses the earlier one. */
    fun setWindow(surface: Any?, widthPx: Int, heightPx: Int) {
        synchronized(lock) {
            this.widthPx = widthPx
            this.heightPx = heightPx
            broken = false
        }
        renderer.setWindow(surface, widthPx, heightPx)
    }

    /** A memory warning; see [MemoryPolicy]. */
    fun trimMemory(level: Int, usualLimit: Long) = synchronized(lock) {
        val resident = shown?.frameStats()?.residentBytes ?: 0
        renderer.context.setMemoryLimit(MemoryPolicy.limitFor(level, resident, usualLimit))
    }

    /** Draws the frame that is shown at frameTimeNs, on Choreographer's clock. False: no further frame makes sense until setWindow. */
    fun draw(frameTimeNs: Long): Boolean = synchronized(lock) {
        if (broken || widthPx == 0 || heightPx == 0) return false
        step()
        val avatar = shown
        try {
            pose(avatar, frameTimeNs)
            renderer.draw(listOfNotNull(avatar), orbit.camera(widthPx, heightPx), background, shadows)
        } catch (error: DoppelException) {
            broken = true // a frame that fails would fail 60 times a second
            listener.onError(error)
        }
        return !broken
    }

    private fun step() {
        val current = load ?: return
        val status = current.status
        if (status.progress != progress) {
            progress = status.progress
            listener.onProgress(progress)
        }
        if (!status.isDone) return
        load = null
        try {
            val loaded = current.finish()
            shown?.close()
            shown = loaded
            tracker = null // it poses the earlier avatar
            play(loaded.clips.firstOrNull())
            orbit.frame(loaded)
            listener.onLoaded(loaded)
        } catch (error: DoppelException) {
            listener.onError(error)
        }
    }

    private fun pose(avatar: Avatar?, frameTimeNs: Long) {
        val playingClip = clip
        if (avatar != null && playingClip != null) {
            if (clipStartNs == 0L) clipStartNs = frameTimeNs
            avatar.setPose(playingClip, (frameTimeNs - clipStartNs) * 1e-9)
        }
        if (avatar != null) tracker?.pose(frameTimeNs)
    }

    override fun close() {
        synchronized(lock) {
            load?.close()
            shown?.close()
            load = null
            shown = null
            widthPx = 0
        }
        renderer.close()
    }
}
