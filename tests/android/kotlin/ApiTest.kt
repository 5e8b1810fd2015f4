// SPDX-License-Identifier: Apache-2.0
package org.doppel

import org.doppel.Checks.expect
import org.doppel.Checks.expectError
import java.nio.ByteBuffer
import java.nio.file.Path
import java.util.Arrays
import kotlin.math.abs
import kotlin.system.exitProcess

// The Kotlin API on a desktop JVM: pictures, closed objects, and the life of a view: loads, clips, windows, warnings.

private const val WIDTH = Checks.WIDTH
private const val HEIGHT = Checks.HEIGHT
private const val FRAME_NS = 16_666_667L

private fun cCamera() = Camera(WIDTH, HEIGHT, 120f, 120f, 48f, 64f, floatArrayOf(1f, 0f, 0f, 0f, 0f, -1f, 0f, 1.2f, 0f, 0f, -1f, 2f))

private class Recorder : AvatarStage.Listener {
    val progress = ArrayList<Float>()
    var loaded: Avatar? = null
    var error: DoppelException? = null
    override fun onProgress(progress: Float) {
        this.progress.add(progress)
    }

    override fun onLoaded(avatar: Avatar) {
        loaded = avatar
    }

    override fun onError(error: DoppelException) {
        this.error = error
    }
}

private class ApiTest(private val work: Path) {
    private val file: ByteBuffer = Checks.mapped(work.resolve("avatar.glb"))

    fun frameEqualsTheCApi(renderer: Renderer, expected: String) {
        DoppelContext.create(renderer, 1, Fill.QUADS).use { context ->
            context.loadAvatar(file).use { avatar ->
                avatar.setPose(avatar.clips[0], 0.5)
                val pixels = ByteBuffer.allocateDirect(WIDTH * HEIGHT * 4)
                context.render(listOf(avatar), cCamera(), pixels)
                val drawn = ByteArray(pixels.capacity())
                pixels.get(drawn)
                expect(Checks.redPixels(drawn) > 500, "a frame from Kotlin is not empty: ${context.rendererName}")
                expect(Arrays.equals(drawn, Checks.read(work.resolve(expected))), "and has the bytes of the C API's")
            }
        }
    }

    fun avatarIsDescribed() {
        DoppelContext.create(Renderer.SOFTWARE, 1).use { context ->
            context.loadAvatar(file).use { avatar ->
                expect(avatar.info.name == "tiny" && avatar.info.splatCount == 128 && avatar.info.jointCount == 2, "info")
                expect(avatar.joints.map { it.humanoidBone } == listOf("hips", "leftUpperArm") && avatar.joints[1].parent == 0, "joints")
                expect(avatar.clips.map { it.name } == listOf("turn") && avatar.clips[0].durationS == 1.0, "clips")
                avatar.setPose(floatArrayOf(0f, 1f, 0f, 0f, 0f, 0f, 0f, 1f), floatArrayOf(0f, 0f, 2f))
                expect(avatar.pose().rotations[1] == 1f && avatar.pose().root[2] == 2f, "a pose comes back")
                expect(abs(avatar.jointPositions()[2] - 2f) < 1e-6f, "joints stand where the root puts them")
                val half = floatArrayOf(0.5f, 0f, 0f, 0f, 0f, 0.5f, 0f, 0f, 0f, 0f, 0.5f, 7f)
                avatar.transform = half
                expect(avatar.transform.contentEquals(half), "a transform comes back")
                expect(abs(avatar.jointPositions()[2] - 8f) < 1e-6f, "and the joints stand where it puts them")
                val shadow = avatar.contactShadow()
                expect(shadow.alpha.size == 4096 && shadow.darkest == 0 && abs(shadow.corner[1]) < 1e-6f, "feet in the air cast no shadow")
                val turned = kotlin.math.sqrt(0.5f)
                // The square lies at a height of 1, and of half in the world.
                avatar.setPose(floatArrayOf(turned, 0f, 0f, turned, 0f, 0f, 0f, 1f))
                expect(avatar.contactShadow(0.5f).darkest > 200, "what lies on the floor does")
            }
        }
    }

    fun splatsAndVerticesAreWritten() {
        DoppelContext.create(Renderer.SOFTWARE, 1).use { context ->
            context.loadAvatar(file).use { avatar ->
                expect(avatar.splatCount() == 128, "splats are counted")
                val layout = listOf(BufferElement(SplatProperty.POSITION, 0, 32), BufferElement(SplatProperty.COLOUR, 12, 32))
                val buffer = java.nio.ByteBuffer.allocateDirect(128 * 32).order(java.nio.ByteOrder.nativeOrder())
                for (i in 0 until 128 * 8) buffer.putFloat(4 * i, -7f)
                val written = avatar.writeSplats(layout, buffer, SplatOptions(eye = floatArrayOf(0f, 1f, 5f)))
                expect(written.count == 128 && written.saturated == 0L, "all of them are written")
                val splats = (0 until 128).map { i -> FloatArray(8) { buffer.getFloat(32 * i + 4 * it) } }
                expect(splats.all { abs(it[0]) < 0.55f && abs(it[2]) < 1e-5f }, "they lie in the square")
                expect(splats.all { it[3] > it[4] + 0.3f }, "and are red")
                expect(splats.all { it[6] == -7f && it[7] == -7f }, "bytes between the elements stay")
                val mesh = java.nio.ByteBuffer.allocateDirect(24 * avatar.info.vertexCount).order(java.nio.ByteOrder.nativeOrder())
                val normals = 12L * avatar.info.vertexCount
                val both = listOf(BufferElement(VertexProperty.POSITION), BufferElement(VertexProperty.NORMAL, normals))
                val vertices = avatar.writeMesh(both, mesh)
                expect(vertices.count == avatar.info.vertexCount && mesh.getFloat(normals.toInt() + 8) == 1f, "the square looks at +Z")
                expectError(DoppelException.INVALID_ARGUMENT, "direct ByteBuffer", "a buffer of the heap") {
                    avatar.writeSplats(layout, java.nio.ByteBuffer.allocate(8192))
                }
                expectError(DoppelException.INVALID_ARGUMENT, "", "a short buffer") {
                    avatar.writeSplats(layout, java.nio.ByteBuffer.allocateDirect(64))
                }
                expectError(DoppelException.INVALID_ARGUMENT, "not negative", "a negative offset") {
                    avatar.writeSplats(listOf(BufferElement(SplatProperty.POSITION, -4)), buffer)
                }
            }
        }
    }

    fun layersRaysAndPlayers() {
        DoppelContext.create(Renderer.SOFTWARE, 1).use { context ->
            context.loadAvatar(file).use { avatar ->
                expect(avatar.layers.map { it.role } == listOf("body") && !avatar.isHidden(avatar.layers[0]), "layers are told")
                expectError(DoppelException.UNSUPPORTED, "is the body", "the body") { avatar.hide(avatar.layers[0]) }
                val pick = Avatar.pick(listOf(avatar), floatArrayOf(0.1f, 1f, 5f), floatArrayOf(0f, 0f, -2f))
                expect(pick != null && pick.avatar === avatar && abs(pick.distanceM - 5f) < 1e-5f && pick.normal[2] == 1f, "a ray meets it")
                expect(Avatar.pick(listOf(avatar), floatArrayOf(0.1f, 1f, 5f), floatArrayOf(0f, 0f, 1f)) == null, "but not behind it")
                val clip = avatar.clips[0]
                val player = Player()
                expect(player.layers(0).isEmpty(), "nothing plays")
                player.play(avatar, clip, 1_000_000_000L)
                player.play(avatar, clip, 2_000_000_000L, Playback(speed = 2.0, fadeS = 1.0, fromS = 0.25))
                val half = player.layers(2_500_000_000L)
                expect(half.map { it.weight } == listOf(0.5f, 0.5f), "two clips cross-fade")
                expect(abs(half[0].timeS - 1.25) < 1e-9 && abs(half[1].timeS - 1.5) < 1e-9, "each at its own time")
                avatar.setPose(half, 2_500_000_000L)
                player.pause(2_500_000_000L)
                expect(player.layers(9_000_000_000L).map { it.timeS } == half.map { it.timeS } && player.isPaused, "a pause stops both")
                player.resume(9_000_000_000L)
                expect(player.layers(10_000_000_000L).map { it.weight } == listOf(1f), "then one is left")
                player.setSpeed(0.0, 10_000_000_000L)
                expect(abs(player.layers(11_000_000_000L)[0].timeS - 3.25) < 1e-9, "and stands")
                expectError(DoppelException.INVALID_ARGUMENT, "nothing plays beneath", "a stop of the body") { player.stop(0) }
                expectError(DoppelException.INVALID_ARGUMENT, "must be finite", "a fade into the past") {
                    player.play(avatar, clip, 0, Playback(fadeS = -1.0))
                }
                val arm = Player(1)
                arm.play(avatar, clip, 0, Playback(fadeS = 0.0))
                arm.stop(1_000_000_000L, 1.0)
                expect(arm.layers(1_500_000_000L).map { it.weight } == listOf(0.5f), "an arm fades out")
                expect(arm.layers(2_000_000_000L).isEmpty(), "to nothing")
            }
        }
    }

    fun aTrackerPosesAnAvatar() {
        val person = Checks.mapped(work.resolve("person.glb"))
        DoppelContext.create(Renderer.SOFTWARE, 1).use { context ->
            context.loadAvatar(person).use { avatar ->
                val names = TrackFormat.VRM.jointNames
                val joints = avatar.joints
                val rotations = FloatArray(4 * names.size)
                val positions = FloatArray(3 * names.size)
                val confidence = FloatArray(names.size)
                for ((at, name) in names.withIndex()) {
                    val own = joints.find { it.humanoidBone == name } ?: continue
                    own.restPosition.copyInto(positions, 3 * at)
                    rotations[4 * at + 3] = 1f
                    confidence[at] = 1f
                }
                val head = names.indexOf("head") // it nods by 0.2 rad
                rotations[4 * head] = kotlin.math.sin(0.1f)
                rotations[4 * head + 3] = kotlin.math.cos(0.1f)
                val tracker = avatar.createTracker(TrackFormat.VRM, BodyTracker.RAW)
                expect(tracker.pose(0).state == TrackerState.WAITING, "a tracker waits for frames")
                for (frame in 1L..60L) tracker.track(frame * FRAME_NS, rotations, positions, confidence)
                val status = (1L..60L).map { tracker.pose(it * FRAME_NS) }.last()
                expect(status.state == TrackerState.TRACKING && status.framesTaken == 60, "and follows them: ${status.drivenJoints} joints")
                val nod = avatar.pose().rotations[4 * avatar.findJoint("head")]
                expect(abs(nod - kotlin.math.sin(0.1f)) < 1e-3f, "the avatar nods: $nod")
                expect(avatar.poseTrust().distances.size == joints.size,
                    "it knows how far that is from training: ${avatar.poseTrust().away}")
                avatar.holdPose(4f)
                avatar.setPose(avatar.pose().rotations, null, FRAME_NS)
                val remembered = avatar.motionState
                avatar.settle()
                avatar.motionState = remembered
                expect(avatar.motionState.contentEquals(remembered), "what clothes remember can be saved")
                avatar.setClothStiffness(3f)
                expectError(DoppelException.INVALID_ARGUMENT, "1 is as learned", "a stiffness below 0") { avatar.setClothStiffness(-1f) }
                avatar.setClothStiffness(1f)
                avatar.setFaceMotion(5_000_000_000, seed = 3)
                expectError(DoppelException.INVALID_ARGUMENT, "blinks", "lids that close twice") { avatar.setFaceMotion(0, blinks = 2f) }
                expectError(DoppelException.INVALID_ARGUMENT, "33 joints", "a frame of the wrong size") {
                    avatar.createTracker(TrackFormat.MEDIAPIPE_POSE).use { it.track(0, null, positions) }
                }
                tracker.close()
                tracker.close()
                expectError(DoppelException.INVALID_ARGUMENT, "not a live tracker", "a closed tracker") { tracker.pose(0) }
            }
        }
    }

    fun theFaceStaysBesideThePose() {
        DoppelContext.create(Renderer.SOFTWARE, 1).use { context ->
            context.loadAvatar(Checks.mapped(work.resolve("person.glb"))).use { avatar ->
                val drawn = avatar.expressions.filter { it.isDrawn }.map { it.name }
                expect(avatar.expressions.size == 52 && drawn.size == 3 && drawn[0] == "eyeBlinkLeft", "expressions: $drawn")
                val weights = FloatArray(52)
                weights[0] = 0.75f
                avatar.expression = weights
                avatar.setPose(avatar.clips[0], 0.5)
                expect(avatar.expression.contentEquals(weights), "a face comes back, whatever the pose")
                avatar.setExpression(mapOf("_neutral" to 1f, "blink" to 0.5f))
                expect(avatar.expression[0] == 0.5f && avatar.expression.sum() == 1f, "VRM's blink is of both eyes")
                avatar.setExpression(arrayOf("JawOpen"), floatArrayOf(0.25f))
                expect(avatar.expression.sum() == 0.25f, "a stream of Live Link")
                expectError(DoppelException.INVALID_ARGUMENT, "is not a number", "a weight that is none") {
                    avatar.setExpression(mapOf("jawOpen" to Float.NaN))
                }
                expect(avatar.expression.sum() == 0.25f, "after it the face stays")
                avatar.setExpression(emptyMap())
                expect(avatar.expression.all { it == 0f }, "no names show nothing")
            }
        }
    }

    fun clipsAreMixedAndAHeadTurns() {
        DoppelContext.create(Renderer.SOFTWARE, 1).use { context ->
            context.loadAvatar(Checks.mapped(work.resolve("person.glb"))).use { avatar ->
                val clip = avatar.clips[0]
                avatar.setPose(clip, 0.5)
                val plain = avatar.pose()
                val layer = ClipLayer(clip, 2.5)
                avatar.setPose(listOf(layer), FRAME_NS)
                expect(avatar.pose().rotations.contentEquals(plain.rotations), "one layer is its clip")
                avatar.setPose(listOf(ClipLayer(clip, 0.25), ClipLayer(clip, 0.75), ClipLayer(clip, 0.1, 0.5f, 1)), FRAME_NS)
                expect(abs(avatar.pose().root[1] - plain.root[1]) < 1e-5f, "two times mix to their mean")
                val before = ClipLayer(clip, 2.5)
                before.shiftM = floatArrayOf(5f, 7f)
                avatar.join(before, layer)
                expect(abs(layer.shiftM[0] - 5f) < 1e-5f && abs(layer.shiftM[1] - 7f) < 1e-5f, "a layer goes on where another stands")
                val head = avatar.findJoint("head")
                val straight = avatar.pose().rotations[4 * head + 1]
                avatar.lookAt(floatArrayOf(3f, 1.6f, 1f))
                expect(avatar.pose().rotations[4 * head + 1] != straight, "the head turns")
                expectError(DoppelException.INVALID_ARGUMENT, "sum to 0", "layers without a weight") {
                    avatar.setPose(listOf(ClipLayer(clip, 0.0, 0f)), FRAME_NS)
                }
            }
        }
    }

    fun twoViewsWithDepth() {
        DoppelContext.create(Renderer.SOFTWARE, 1).use { context ->
            context.loadAvatar(file).use { avatar ->
                val wall = Checks.floats(WIDTH * HEIGHT)
                for (i in 0 until WIDTH * HEIGHT) wall.put(i, 1f)
                val c = cCamera()
                val behind = Camera(WIDTH, HEIGHT, c.fx, c.fy, c.cx, c.cy, c.viewFromWorld, wall)
                val pixels = List(2) { ByteBuffer.allocateDirect(WIDTH * HEIGHT * 4) }
                val depths = List(2) { Checks.floats(WIDTH * HEIGHT) }
                context.render(listOf(avatar), listOf(c, behind), pixels, depths)
                val drawn = pixels.map { buffer -> ByteArray(buffer.capacity()).also { buffer.get(it) } }
                expect(Checks.redPixels(drawn[0]) > 500 && drawn[1].all { it == 0.toByte() },
                    "a wall hides the avatar from the second view")
                val middle = HEIGHT / 2 * WIDTH + WIDTH / 2
                expect(abs(depths[0].get(middle) - 2f) < 0.01f && depths[1].get(middle) == 0f,
                    "and depth says so: ${depths[0].get(middle)} m")
                expectError(DoppelException.INVALID_ARGUMENT, "as many buffers", "two views into one image") {
                    context.render(listOf(avatar), listOf(c, c), pixels.take(1))
                }
            }
        }
    }

    fun closedObjectsAreErrors() {
        val context = DoppelContext.create(Renderer.SOFTWARE, 1)
        val avatar = context.loadAvatar(file)
        avatar.close()
        avatar.close()
        val invalid = DoppelException.INVALID_ARGUMENT
        expectError(invalid, "not a live avatar", "a closed avatar is asked") { avatar.info }
        expectError(invalid, "not a live avatar", "a closed avatar is posed") { avatar.setPose(FloatArray(8)) }
        expectError(invalid, "", "a closed avatar is drawn") {
            context.render(listOf(avatar), cCamera(), ByteBuffer.allocateDirect(WIDTH * HEIGHT * 4))
        }
        val load = context.startLoad(file)
        load.close()
        expectError(invalid, "not a live load", "a cancelled load is finished") { load.finish() }
        context.close()
        expectError(invalid, "", "a closed context loads") { context.loadAvatar(file) }
        expectError(invalid, "", "a closed context is named") { context.rendererName }
    }

    fun orbitLooksAtTheAvatar() {
        val orbit = OrbitCamera()
        orbit.targetY = 1.2f
        orbit.distanceM = 2f
        val front = orbit.camera(WIDTH, HEIGHT).viewFromWorld
        expect(Arrays.equals(front.map { it + 0f }.toFloatArray(), cCamera().viewFromWorld),
            "from the front it is the camera of the C program")
        orbit.yawRad = 0.7f
        orbit.pitchRad = 0.3f
        val view = orbit.camera(WIDTH, HEIGHT).viewFromWorld
        var worst = 0f
        for (a in 0..2) for (b in 0..2) {
            val dot = (0..2).sumByDouble { (view[4 * a + it] * view[4 * b + it]).toDouble() }.toFloat()
            worst = maxOf(worst, abs(dot - if (a == b) 1f else 0f))
        }
        val determinant = view[0] * (view[5] * view[10] - view[6] * view[9]) - view[1] * (view[4] * view[10] - view[6] * view[8]) +
            view[2] * (view[4] * view[9] - view[5] * view[8])
        expect(worst < 1e-6f && determinant > 0, "turned, its axes are a rotation: $worst, $determinant")
        val target = (0..2).map { view[4 * it + 1] * 1.2f + view[4 * it + 3] }
        expect(abs(target[0]) < 1e-6f && abs(target[1]) < 1e-6f && abs(target[2] - 2f) < 1e-6f, "and the target stays ahead: $target")
        orbit.pitchRad = 9f
        orbit.distanceM = -1f
        expect(orbit.pitchRad < 1.6f && orbit.distanceM > 0f, "angles and distances stay within limits")
    }

    fun memoryPolicyKeepsWhatIsLoaded() {
        val usual = MemoryPolicy.usualLimit(8L shl 30)
        val mib = 1L shl 20
        expect(usual == 1L shl 30, "an eighth of the memory")
        expect(MemoryPolicy.limitFor(5, 100 * mib, usual) == usual &&
            MemoryPolicy.limitFor(20, 100 * mib, usual) == usual, "no warning, no change")
        expect(MemoryPolicy.limitFor(10, 100 * mib, usual) == 164 * mib, "memory is low")
        expect(MemoryPolicy.limitFor(15, 100 * mib, usual) == 116 * mib &&
            MemoryPolicy.limitFor(80, 100 * mib, usual) == 116 * mib, "memory is short")
        expect(MemoryPolicy.limitFor(15, usual, usual) == usual, "never more than usual")
    }

    // ---- a view

    private fun withStage(test: (AvatarStage, Recorder, ViewRenderer) -> Unit) {
        val renderer = ViewRenderer.create(Fill.QUADS, null, java.lang.Boolean.getBoolean("org.doppel.validation"))
        val stage = AvatarStage(renderer)
        val told = Recorder()
        stage.listener = told
        stage.background = floatArrayOf(0f, 0f, 0.2f)
        test(stage, told, renderer)
        val complaints = renderer.complaints
        complaints.forEach { println(it) }
        expect(complaints.isEmpty(), "the validation layer has nothing to say")
        stage.close()
        afterClose()
        afterClose = {}
    }

    private var afterClose: () -> Unit = {}

    private fun draw(stage: AvatarStage, frames: Int): Boolean {
        var more = true
        for (i in 1..frames) {
            more = stage.draw(i * FRAME_NS)
            Thread.sleep(2)
        }
        return more
    }

    private fun drawUntilLoaded(stage: AvatarStage, told: Recorder): Boolean {
        Checks.waitUntil {
            draw(stage, 1)
            told.loaded != null || told.error != null
        }
        return told.loaded != null
    }

    private fun expectGone(window: FakeWindow, what: String) {
        expect(window.users() == 0L && window.surfaces() == 0L && window.swapchains() == 0L && window.wrong() == 0L,
            "$what: nothing is left")
        window.close()
    }

    fun viewLoadsAndPlays() = withStage { stage, told, _ ->
        expect(!stage.draw(0), "without a window, frames stop")
        val window = FakeWindow(WIDTH, HEIGHT)
        stage.setWindow(window, WIDTH, HEIGHT)
        stage.show(file)
        expect(drawUntilLoaded(stage, told), "a view loads while it draws: ${window.shownCount()} frames, progress ${told.progress}")
        expect(told.progress == told.progress.sorted() && told.progress.last() == 1f, "progress rises to 1")
        draw(stage, 3)
        expect(Checks.redPixels(window.shown()) > 500, "and shows the avatar")
        val standing = window.shown()
        stage.draw(40 * FRAME_NS)
        expect(!Arrays.equals(window.shown(), standing), "its clip plays by the time of the frame")
        stage.play(null)
        stage.draw(50 * FRAME_NS)
        val still = window.shown()
        stage.draw(60 * FRAME_NS)
        expect(Arrays.equals(window.shown(), still), "and stops")
        stage.orbit.drag(0.2f, 0f)
        stage.draw(70 * FRAME_NS)
        expect(!Arrays.equals(window.shown(), still), "a drag turns it")
        stage.orbit.yawRad = 0f
        stage.avatar?.setPose(floatArrayOf(0f, 0f, 0f, 1f, 0f, 0f, 0f, 1f))
        stage.setDetail(12f, 6.0)
        stage.trimMemory(15, 1L shl 30)
        expect(stage.draw(80 * FRAME_NS) && Checks.redPixels(window.shown()) > 300, "level of detail and a memory warning leave it there")
        stage.setWindow(null, 0, 0)
        expectGone(window, "the window of a view")
    }

    fun viewFollowsATracker() = withStage { stage, told, _ ->
        val window = FakeWindow(WIDTH, HEIGHT)
        stage.setWindow(window, WIDTH, HEIGHT)
        stage.show(Checks.mapped(work.resolve("person.glb")))
        expect(drawUntilLoaded(stage, told), "a person is loaded")
        val avatar = told.loaded ?: return@withStage
        stage.play(null)
        avatar.createTracker(TrackFormat.OPENXR_HANDS, BodyTracker.RAW).use { tracker ->
            stage.follow(tracker)
            stage.draw(FRAME_NS)
            val positions = FloatArray(3 * 53)
            val rotations = FloatArray(4 * 53)
            val confidence = FloatArray(53)
            positions[1] = 1.6f
            rotations[0] = kotlin.math.sin(0.25f) // the head looks up by 0.5 rad
            rotations[3] = kotlin.math.cos(0.25f)
            confidence[0] = 1f
            for (frame in 2L..60L) {
                tracker.track(frame * FRAME_NS, rotations, positions, confidence)
                stage.draw(frame * FRAME_NS)
            }
            val nod = avatar.pose().rotations[4 * avatar.findJoint("head")]
            expect(abs(nod) > 0.1f, "the avatar of a view looks up as its tracker says: $nod")
            stage.follow(null)
        }
        expect(stage.draw(61 * FRAME_NS) && told.error == null, "and goes on without it")
        stage.setWindow(null, 0, 0)
        expectGone(window, "the window of a view that was driven")
    }

    fun viewInTheBackgroundWhileLoading() = withStage { stage, told, _ ->
        val first = FakeWindow(WIDTH, HEIGHT)
        stage.setWindow(first, WIDTH, HEIGHT)
        stage.show(file)
        draw(stage, 1)
        stage.setWindow(null, 0, 0)
        expectGone(first, "a window that left a load behind")
        expect(!draw(stage, 5) && stage.isLoading, "in the background the load waits")
        val second = FakeWindow(WIDTH, HEIGHT)
        stage.setWindow(second, WIDTH, HEIGHT)
        expect(drawUntilLoaded(stage, told), "and goes on in the next window")
        stage.show(file)
        stage.show(file)
        afterClose = { expectGone(second, "a view that was closed while two loads, one of them cancelled, went on") }
    }

    fun viewShowsErrorsAndGoesOn() = withStage { stage, told, _ ->
        val window = FakeWindow(WIDTH, HEIGHT)
        stage.setWindow(window, WIDTH, HEIGHT)
        stage.show(Checks.direct(ByteArray(1000)))
        drawUntilLoaded(stage, told)
        expect(told.error?.code == DoppelException.UNSUPPORTED, "a file of another kind is told: ${told.error?.message}")
        expect(stage.draw(0), "and frames go on")
        window.set("nextAcquire", FakeWindow.SURFACE_LOST)
        expect(stage.draw(1) && stage.draw(2), "a surface that is lost in mid-frame does not stop frames")
        window.set("nextSubmit", FakeWindow.DEVICE_LOST)
        expect(stage.draw(3) && stage.draw(4), "nor does a lost device")
        told.error = null
        window.set("format", FakeWindow.RGB565)
        stage.setWindow(null, 0, 0)
        stage.setWindow(window, WIDTH, HEIGHT)
        expect(!stage.draw(5) && told.error?.code == DoppelException.UNSUPPORTED, "a window of 16 bits stops them: ${told.error?.message}")
        expect(!stage.draw(6), "until the next window")
        window.set("format", FakeWindow.RGBA8)
        stage.setWindow(window, WIDTH, HEIGHT)
        expect(stage.draw(7), "which shows pictures again")
        stage.setWindow(null, 0, 0)
        expectGone(window, "a window with errors")
    }

    /** A thread draws as the frames of a view do, while another takes and gives windows as the main thread does. */
    fun windowsComeAndGoWhileAThreadDraws() = withStage { stage, told, _ ->
        var running = true
        val frames = Thread {
            var time = 0L
            while (running) {
                stage.draw(time)
                time += FRAME_NS
            }
        }
        frames.start()
        var left = 0L
        for (i in 0 until 30) {
            val window = FakeWindow(WIDTH, HEIGHT)
            stage.setWindow(window, WIDTH, HEIGHT)
            if (i == 0) stage.show(file)
            Thread.sleep(5)
            stage.setWindow(null, 0, 0)
            left += window.users() + window.surfaces() + window.swapchains() + window.wrong()
            window.close()
        }
        running = false
        frames.join()
        expect(left == 0L && told.error == null, "30 windows come and go under a thread that draws: ${told.error?.message}")
    }
}

fun main(arguments: Array<String>) {
    val work = Checks.work(arguments)
    val test = ApiTest(work)
    println("libdoppel ${DoppelContext.version}")
    test.frameEqualsTheCApi(Renderer.SOFTWARE, "software.rgba")
    test.frameEqualsTheCApi(Renderer.VULKAN, "vulkan.rgba")
    test.avatarIsDescribed()
    test.splatsAndVerticesAreWritten()
    test.layersRaysAndPlayers()
    test.aTrackerPosesAnAvatar()
    test.theFaceStaysBesideThePose()
    test.clipsAreMixedAndAHeadTurns()
    test.twoViewsWithDepth()
    test.closedObjectsAreErrors()
    test.orbitLooksAtTheAvatar()
    test.memoryPolicyKeepsWhatIsLoaded()
    test.viewLoadsAndPlays()
    test.viewFollowsATracker()
    test.viewInTheBackgroundWhileLoading()
    test.viewShowsErrorsAndGoesOn()
    test.windowsComeAndGoWhileAThreadDraws()
    exitProcess(Checks.exitCode())
}
