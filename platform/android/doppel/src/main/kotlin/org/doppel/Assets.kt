// SPDX-License-Identifier: Apache-2.0
package org.doppel

import android.content.res.AssetManager
import java.io.FileInputStream
import java.io.IOException
import java.nio.ByteBuffer
import java.nio.channels.FileChannel

/**
 * An asset of the APK as memory that the system pages in: nothing is copied. The APK must store it uncompressed
 * (`androidResources { noCompress += "glb" }`), else this throws IOException with that hint.
 */
fun AssetManager.map(name: String): ByteBuffer {
    val descriptor = try {
        openFd(name)
    } catch (error: IOException) {
        throw IOException("the asset $name is missing or compressed; add its extension to noCompress in build.gradle.kts", error)
    }
    descriptor.use { asset ->
        FileInputStream(asset.fileDescriptor).channel.use { channel ->
            return channel.map(FileChannel.MapMode.READ_ONLY, asset.startOffset, asset.length)
        }
    }
}
