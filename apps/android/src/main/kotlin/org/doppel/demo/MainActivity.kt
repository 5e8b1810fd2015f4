// SPDX-License-Identifier: Apache-2.0
package org.doppel.demo

import android.app.Activity
import android.content.Intent
import android.net.Uri
import android.os.Bundle
import android.view.View
import android.widget.Button
import android.widget.ProgressBar
import android.widget.TextView
import org.doppel.Avatar
import org.doppel.AvatarStage
import org.doppel.AvatarView
import org.doppel.Clip
import org.doppel.DoppelException
import org.doppel.map
import java.io.FileInputStream
import java.io.IOException
import java.nio.ByteBuffer
import java.nio.channels.FileChannel

/** Shows the avatar of the APK, or a file that the user opens. */
class MainActivity : Activity(), AvatarStage.Listener {
    private lateinit var view: AvatarView
    private lateinit var message: TextView
    private lateinit var progress: ProgressBar
    private var clips = emptyList<Clip>()
    private var clip = 0
    private var detail = Detail.ALL

    /** What the third button switches through: everything, level of detail by distance, a frame budget on top. */
    private enum class Detail(val text: Int, val splatsPerPixel: Float, val budgetMs: Double) {
        ALL(R.string.detail_all, 0f, 0.0),
        DISTANCE(R.string.detail_distance, 12f, 0.0),
        BUDGET(R.string.detail_budget, 12f, 6.0)
    }

    override fun onCreate(savedInstanceState: Bundle?) {
        super.onCreate(savedInstanceState)
        setContentView(R.layout.main)
        view = findViewById(R.id.avatar)
        message = findViewById(R.id.message)
        progress = findViewById(R.id.progress)
        view.listener = this
        findViewById<Button>(R.id.open).setOnClickListener { chooseFile() }
        findViewById<Button>(R.id.clip).setOnClickListener { nextClip() }
        findViewById<Button>(R.id.detail).setOnClickListener { nextDetail(it as Button) }
        view.startError?.let { onError(it) }
        try {
            load(assets.map("avatar.glb"))
        } catch (error: IOException) {
            say("${error.message}, or open a file.")
        }
    }

    override fun onResume() {
        super.onResume()
        view.resume()
    }

    override fun onPause() {
        view.pause()
        super.onPause()
    }

    override fun onDestroy() {
        view.release()
        super.onDestroy()
    }

    private fun load(file: ByteBuffer) {
        progress.visibility = View.VISIBLE
        say("")
        view.stage?.show(file)
    }

    private fun chooseFile() {
        val choose = Intent(Intent.ACTION_OPEN_DOCUMENT)
        choose.addCategory(Intent.CATEGORY_OPENABLE)
        choose.type = "*/*"
        startActivityForResult(choose, CHOOSE)
    }

    override fun onActivityResult(requestCode: Int, resultCode: Int, data: Intent?) {
        val file: Uri = data?.data ?: return
        if (requestCode != CHOOSE || resultCode != RESULT_OK) return
        try {
            // Mapped like an asset. Documents of the network are no files, and fail here.
            val descriptor = contentResolver.openFileDescriptor(file, "r") ?: throw IOException("the file is gone")
            descriptor.use { opened ->
                FileInputStream(opened.fileDescriptor).channel.use { load(it.map(FileChannel.MapMode.READ_ONLY, 0, it.size())) }
            }
        } catch (error: IOException) {
            say("This file cannot be read: ${error.message}")
        }
    }

    private fun nextClip() {
        if (clips.isEmpty()) return say("This avatar has no clips.")
        clip = (clip + 1) % clips.size
        view.stage?.play(clips[clip])
        say(clips[clip].name)
    }

    private fun nextDetail(button: Button) {
        detail = Detail.values()[(detail.ordinal + 1) % Detail.values().size]
        button.setText(detail.text)
        view.stage?.setDetail(detail.splatsPerPixel, detail.budgetMs)
    }

    private fun say(text: String) {
        message.text = text
    }

    // ---- the view tells

    override fun onProgress(progress: Float) {
        this.progress.progress = (100 * progress).toInt()
    }

    override fun onLoaded(avatar: Avatar) {
        progress.visibility = View.GONE
        clips = avatar.clips
        clip = 0
        say("${avatar.info.name}: ${avatar.info.splatCount} splats")
    }

    override fun onError(error: DoppelException) {
        progress.visibility = View.GONE
        say(error.message ?: "")
    }

    private companion object {
        const val CHOOSE = 1
    }
}
