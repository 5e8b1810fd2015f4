// SPDX-License-Identifier: Apache-2.0
package org.doppel

import android.app.ActivityManager
import android.content.ComponentCallbacks2
import android.content.Context
import android.content.res.Configuration
import android.os.Handler
import android.os.HandlerThread
import android.os.Looper
import android.util.AttributeSet
import android.view.Choreographer
import android.view.MotionEvent
import android.view.ScaleGestureDetector
import android.view.SurfaceHolder
import android.view.SurfaceView

/**
 * A view that shows an avatar. Put it into a layout, and give [stage] a file. It draws once for each frame of the display, on a thread of
 * its own, while it has a window and [pause] was not called. Drags turn the avatar, and two fingers zoom.
 *
 * An activity calls [pause] and [resume], and [release] at its end. Errors come to [listener], on the main thread.
 */
class AvatarView @JvmOverloads constructor(context: Context, attributes: AttributeSet? = null) :
    SurfaceView(context, attributes), SurfaceHolder.Callback, ComponentCallbacks2 {

    /** Null where this phone has no Vulkan 1.1; [startError] says why. */
    val stage: AvatarStage?
    val startError: DoppelException?
    var listener: AvatarStage.Listener = object : AvatarStage.Listener {}

    private val thread = HandlerThread("doppel frames")
    private val frames: Handler
    private val main = Handler(Looper.getMainLooper())
    private val usualLimit: Long
    private var wanted = true // touched on the thread of the frames only
    private var scheduled = false
    private var released = false
    private var lastX = 0f
    private var lastY = 0f

    init {
        thread.start()
        frames = Handler(thread.looper)
        val memory = ActivityManager.MemoryInfo()
        (context.getSystemService(Context.ACTIVITY_SERVICE) as ActivityManager).getMemoryInfo(memory)
        usualLimit = MemoryPolicy.usualLimit(memory.totalMem)
        var made: AvatarStage? = null
        var error: DoppelException? = null
        try {
            val renderer = ViewRenderer.create(Fill.AUTO, context.cacheDir.path)
            renderer.context.setMemoryLimit(usualLimit)
            made = AvatarStage(renderer)
            made.listener = OnMainThread()
        } catch (caught: DoppelException) {
            error = caught
        }
        stage = made
        startError = error
        holder.addCallback(this)
        context.applicationContext.registerComponentCallbacks(this)
    }

    private inner class OnMainThread : AvatarStage.Listener {
        override fun onProgress(progress: Float) {
            main.post { listener.onProgress(progress) }
        }

        override fun onLoaded(avatar: Avatar) {
            main.post { listener.onLoaded(avatar) }
        }

        override fun onError(error: DoppelException) {
            main.post { listener.onError(error) }
        }
    }

    // ---- frames: Choreographer calls for each frame of the display, on the thread whose Looper asked

    private val onFrame = object : Choreographer.FrameCallback {
        override fun doFrame(frameTimeNanos: Long) {
            scheduled = false
            if (wanted && stage?.draw(frameTimeNanos) == true) schedule()
        }
    }

    private fun schedule() {
        if (scheduled || !wanted) return
        scheduled = true
        Choreographer.getInstance().postFrameCallback(onFrame)
    }

    fun pause() {
        frames.post { wanted = false }
    }

    fun resume() {
        frames.post {
            wanted = true
            schedule()
        }
    }

    /** Ends the thread and frees everything. The view shows nothing afterwards. */
    fun release() {
        if (released) return
        released = true
        holder.removeCallback(this)
        context.applicationContext.unregisterComponentCallbacks(this)
        frames.post { wanted = false }
        thread.quitSafely()
        thread.join()
        stage?.close()
    }

    // ---- the window. surfaceDestroyed must not return while a frame uses it: setWindow waits for that frame

    override fun surfaceCreated(holder: SurfaceHolder) {}

    override fun surfaceChanged(holder: SurfaceHolder, format: Int, width: Int, height: Int) {
        try {
            stage?.setWindow(holder.surface, width, height)
            frames.post { schedule() }
        } catch (error: DoppelException) {
            listener.onError(error)
        }
    }

    override fun surfaceDestroyed(holder: SurfaceHolder) {
        stage?.setWindow(null, 0, 0)
    }

    // ---- memory

    override fun onTrimMemory(level: Int) {
        stage?.trimMemory(level, usualLimit)
    }

    override fun onLowMemory() = onTrimMemory(ComponentCallbacks2.TRIM_MEMORY_COMPLETE)

    override fun onConfigurationChanged(newConfig: Configuration) {}

    // ---- touch

    private val pinch = ScaleGestureDetector(
        context,
        object : ScaleGestureDetector.SimpleOnScaleGestureListener() {
            override fun onScale(detector: ScaleGestureDetector): Boolean {
                stage?.orbit?.zoom(detector.scaleFactor)
                return true
            }
        }
    )

    override fun onTouchEvent(event: MotionEvent): Boolean {
        pinch.onTouchEvent(event)
        if (event.actionMasked == MotionEvent.ACTION_MOVE && event.pointerCount == 1 && !pinch.isInProgress && height > 0)
            stage?.orbit?.drag((event.x - lastX) / height, (event.y - lastY) / height)
        lastX = event.x
        lastY = event.y
        return true
    }
}
