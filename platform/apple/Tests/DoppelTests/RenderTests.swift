// SPDX-License-Identifier: Apache-2.0
import CDoppel
@testable import Doppel
import XCTest

/// Drawing by the CPU renderer, and what it says of an avatar. DOPPEL_TEST_AVATAR names the file of make_tiny_avatar: a red square of 1 m
/// at z = 0 around (0, 1, 0), two joints, and a clip "turn" of 1 s that raises the root by 0.5 m.
final class RenderTests: XCTestCase {
    private let front = RigidPose(position: SIMD3(0, 1, 3))

    func testPixelsAndDepthEqualThoseOfTheCInterface() throws {
        let context = try DoppelContext(renderer: .software, threadCount: 2)
        let avatar = try context.loadAvatar(TestAvatar.bytes)
        let camera = try Camera(pose: front, fovYRad: 0.8, widthPx: 96, heightPx: 64)
        let picture = try Picture(widthPx: 96, heightPx: 64, withDepth: true)
        try context.render([avatar], from: [camera], into: [picture])

        var raw = DplCamera()
        raw.structSize = UInt32(MemoryLayout<DplCamera>.size)
        raw.widthPx = 96
        raw.heightPx = 64
        raw.fx = 32 / tan(Float(0.4))
        raw.fy = raw.fx
        raw.cx = 48
        raw.cy = 32
        raw.viewFromWorld = (1, 0, 0, 0, 0, -1, 0, 1, 0, 0, -1, 3)
        var pixels = [UInt8](repeating: 7, count: 96 * 64 * 4)
        var depth = [Float](repeating: 7, count: 96 * 64)
        let result = pixels.withUnsafeMutableBufferPointer { p in
            depth.withUnsafeMutableBufferPointer { d in
                var image = DplImage()
                image.structSize = UInt32(MemoryLayout<DplImage>.size)
                image.rgba = p.baseAddress
                image.rgbaBytes = p.count
                image.depthM = d.baseAddress
                image.depthCount = d.count
                return dplRender(context.raw, avatar.raw, &raw, 1, &image)
            }
        }
        XCTAssertEqual(result, DPL_OK)
        // The camera of four angles is computed in double precision; a last bit of fx may differ, and with it a pixel by one level.
        let most = zip(picture.rgba, pixels).map { abs(Int($0) - Int($1)) }.max()!
        XCTAssertLessThanOrEqual(most, 1)
        XCTAssertEqual(picture[48, 32].w, 255)
        XCTAssertGreaterThan(picture[48, 32].x, 200)
        XCTAssertEqual(picture[2, 2], SIMD4(0, 0, 0, 0))
        XCTAssertEqual(picture.depthM[32 * 96 + 48], 3, accuracy: 1e-3)
        XCTAssertEqual(picture.depthM[32 * 96 + 48], depth[32 * 96 + 48], accuracy: 1e-5)
        XCTAssertGreaterThan(try avatar.frameStats().splatsDrawn, 100)
    }

    func testBothEyesSeeTheAvatarFromTheirPlaces() throws {
        let context = try DoppelContext(renderer: .software)
        let avatar = try context.loadAvatar(TestAvatar.bytes)
        let cameras = try [Float(-0.2), 0.2].map { x in
            try Camera(pose: RigidPose(position: SIMD3(x, 1, 3)), fovYRad: 0.8, widthPx: 64, heightPx: 64)
        }
        let eyes = try cameras.map { try Picture(widthPx: $0.widthPx, heightPx: $0.heightPx) }
        try context.render([avatar], from: cameras, into: eyes)
        func centre(_ picture: Picture) -> Float {
            var sum: Float = 0, weight: Float = 0
            for x in 0..<64 {
                sum += Float(x) * Float(picture[x, 32].w)
                weight += Float(picture[x, 32].w)
            }
            return sum / weight
        }
        // 0.4 m at 3 m through 32 / tan(0.4) pixels: 10.1 pixels, seen to a fifth of a pixel.
        XCTAssertEqual(centre(eyes[0]) - centre(eyes[1]), 0.4 / 3 * 32 / tan(Float(0.4)), accuracy: 0.2)
    }

    func testInfoJointsAndClips() throws {
        let context = try DoppelContext(renderer: .software)
        let avatar = try context.loadAvatar(TestAvatar.bytes)
        let info = try avatar.info()
        XCTAssertEqual([info.jointCount, info.clipCount, info.splatCount, info.fileSplatCount], [2, 1, 128, 128])
        XCTAssertTrue(info.axesStated)
        XCTAssertEqual(info.name, "tiny")
        XCTAssertEqual(info.restMax.y, 1.5, accuracy: 0.01)
        XCTAssertEqual(try avatar.findJoint("leftUpperArm"), 1)
        XCTAssertEqual(
            try avatar.joint(1),
            Avatar.Joint(name: "left_shoulder", humanoidBone: "leftUpperArm", parent: 0, restPosition: SIMD3(0, 1.25, 0)))
        XCTAssertNil(try avatar.joint(0).parent)
        XCTAssertEqual(try avatar.clip(0), Avatar.Clip(name: "turn", durationS: 1))
        XCTAssertThrowsError(try avatar.clip(-1)) { XCTAssertEqual(($0 as? DoppelError)?.code, .notFound) }
    }

    func testPosesComeBackAndClipsPlay() throws {
        let context = try DoppelContext(renderer: .software)
        let avatar = try context.loadAvatar(TestAvatar.bytes)
        let half = Float(0.5).squareRoot()
        let pose = Avatar.Pose(rotations: [SIMD4(0, half, 0, half), SIMD4(0, 0, 0, 1)], root: SIMD3(1, 2, 3))
        try avatar.setPose(pose)
        XCTAssertEqual(try avatar.pose().root, SIMD3(1, 2, 3))
        XCTAssertEqual(try avatar.pose().rotations[0].y, half, accuracy: 1e-6)
        XCTAssertEqual(try avatar.jointPositions()[0].y, 3, accuracy: 1e-5)
        try avatar.setTransform(RigidPose(yawRad: .pi / 2, position: SIMD3(0, 5, 0)), scale: 2)
        XCTAssertEqual(try avatar.transform()[2], 2, accuracy: 1e-5)
        XCTAssertEqual(try avatar.transform()[7], 5)
        XCTAssertEqual(try avatar.jointPositions()[0].y, 11, accuracy: 1e-5)
        XCTAssertEqual(try avatar.jointPositions()[0].x, 6, accuracy: 1e-5)
        XCTAssertThrowsError(try avatar.setTransform(RigidPose(), scale: 0)) {
            XCTAssertEqual(($0 as? DoppelError)?.code, .invalidArgument)
        }
        let shadow = try avatar.contactShadow(floorM: 10)
        XCTAssertEqual(shadow.alpha.count, 64 * 64)
        XCTAssertEqual(shadow.corner.y, 10, accuracy: 1e-5)
        XCTAssertEqual(try avatar.contactShadow().darkest, 0)
        XCTAssertThrowsError(try avatar.contactShadow(floorM: .nan)) {
            XCTAssertEqual(($0 as? DoppelError)?.code, .invalidArgument)
        }
        XCTAssertEqual(try avatar.layer(0).role, "body")
        XCTAssertThrowsError(try avatar.hide(layer: 0)) { XCTAssertEqual(($0 as? DoppelError)?.code, .unsupported) }
        try avatar.setTransform(RigidPose())
        try avatar.setPose(Avatar.Pose(rotations: [SIMD4(0, 0, 0, 1), SIMD4(0, 0, 0, 1)]))
        let pick = try Avatar.pick([avatar], origin: SIMD3(0.1, 1, 5), direction: SIMD3(0, 0, -2))
        XCTAssertEqual(pick?.distanceM ?? 0, 5, accuracy: 1e-5)
        XCTAssertEqual(pick?.normal.z ?? 0, 1, accuracy: 1e-5)
        XCTAssertNil(try Avatar.pick([avatar], origin: SIMD3(0.1, 1, 5), direction: SIMD3(0, 0, 1)))
        try avatar.setPose(pose, timeNs: 1_000_000_000)
        let remembered = try avatar.motionState()
        try avatar.settle()
        try avatar.setMotionState(remembered)
        XCTAssertEqual(try avatar.motionState(), remembered)
        try avatar.setClothStiffness(3)
        XCTAssertThrowsError(try avatar.setClothStiffness(-1)) { XCTAssertEqual(($0 as? DoppelError)?.code, .invalidArgument) }
        try avatar.setClothStiffness(1)
        try avatar.setFaceMotion(FaceMotion(seed: 3), timeNs: 5_000_000_000)
        XCTAssertThrowsError(try avatar.setFaceMotion(FaceMotion(seed: 3, blinks: 2), timeNs: 0)) {
            XCTAssertEqual(($0 as? DoppelError)?.code, .invalidArgument)
        }
        try avatar.setPose(clip: 0, timeS: 0.5)
        XCTAssertEqual(try avatar.pose().root.y, 0.25, accuracy: 1e-4)
        try avatar.setPose(clip: 0, timeS: 9, loop: false)
        XCTAssertEqual(try avatar.pose().root.y, 0.5, accuracy: 1e-4)
    }

    func testTheFaceStaysBesideThePose() throws {
        let context = try DoppelContext(renderer: .software)
        let avatar = try context.loadAvatar(TestAvatar.bytes)
        let all = try avatar.expressions()
        XCTAssertEqual(all.count, 52)
        XCTAssertEqual(all[0], Avatar.Expression(name: "eyeBlinkLeft", isDrawn: false), "this avatar holds none")
        let jaw = try Avatar.findExpression("jawOpen")
        XCTAssertEqual(all[jaw].name, "jawOpen")
        var weights = [Float](repeating: 0, count: 52)
        weights[jaw] = 0.5
        try avatar.setExpression(weights)
        try avatar.setPose(clip: 0, timeS: 0.5)
        XCTAssertEqual(try avatar.expression(), weights)
        try avatar.setExpression(["_neutral": 1, "eyeBlinkLeft": 2, "JawOpen": 0.25])
        XCTAssertEqual(try avatar.expression()[0], 1, "held in 0 to 1")
        XCTAssertEqual(try avatar.expression()[jaw], 0.25)
        let before = try avatar.expression()
        func refuses(_ sentence: String, _ set: () throws -> Void) {
            XCTAssertThrowsError(try set()) {
                XCTAssertEqual(($0 as? DoppelError)?.code, .invalidArgument)
                XCTAssertTrue("\($0)".contains(sentence), "\($0)")
            }
        }
        refuses("there are 52") { try avatar.setExpression([1, 0]) }
        refuses("'jawOpen' is not a number") { try avatar.setExpression(["jawOpen": .nan]) }
        refuses("did you mean 'jawOpen'") { try avatar.setExpression(["jawOpne": 1]) }
        refuses("1 names and 2 weights") { try avatar.setExpression(names: ["jawOpen"], weights: [1, 1]) }
        XCTAssertThrowsError(try Avatar.findExpression("smirk")) { XCTAssertEqual(($0 as? DoppelError)?.code, .notFound) }
        XCTAssertEqual(try avatar.expression(), before)
        try avatar.setExpression([:])
        XCTAssertEqual(try avatar.expression(), [Float](repeating: 0, count: 52))
    }

    func testSplatsAndVerticesAreWrittenInTheLayoutOfTheApp() throws {
        let context = try DoppelContext(renderer: .software)
        let avatar = try context.loadAvatar(TestAvatar.bytes)
        try avatar.setTransform(RigidPose(position: SIMD3(3, 0, 0)))
        let front = SplatOptions(eye: SIMD3(3, 1, 5)), behind = SplatOptions(eye: SIMD3(3, 1, -5))
        XCTAssertEqual(try avatar.splatCount(), 128)
        let layout: [BufferElement<SplatProperty>] = [
            BufferElement(.position, strideBytes: 32), BufferElement(.colour, offsetBytes: 12, strideBytes: 32),
            BufferElement(.opacity, offsetBytes: 24, strideBytes: 32),
        ]
        func numbers(_ options: SplatOptions) throws -> [Float] {
            var out = [Float](repeating: -7, count: 128 * 8)
            let written = try out.withUnsafeMutableBytes { try avatar.writeSplats(layout, into: $0, options) }
            XCTAssertEqual(written.count, 128)
            XCTAssertEqual(written.saturated, 0)
            return out
        }
        let seen = try numbers(front)
        for i in 0..<128 {
            XCTAssertEqual(seen[8 * i], 3, accuracy: 0.5)
            XCTAssertEqual(seen[8 * i + 2], 0, accuracy: 1e-5)
            XCTAssertGreaterThan(seen[8 * i + 3], seen[8 * i + 4] + 0.3, "it is red")
            XCTAssertEqual(seen[8 * i + 7], -7, "bytes between the elements stay")
        }
        let opacity = stride(from: 6, to: 1024, by: 8)
        XCTAssertGreaterThan(opacity.reduce(0) { $0 + seen[$1] }, 10)
        let backs = try numbers(behind)
        XCTAssertLessThan(opacity.reduce(0) { $0 + backs[$1] }, opacity.reduce(0) { $0 + seen[$1] } + 1e-3)

        let vertexCount = try avatar.info().vertexCount
        var vertices = [Float](repeating: 0, count: 6 * vertexCount)
        let mesh = [BufferElement<VertexProperty>(.position), BufferElement(.normal, offsetBytes: 12 * vertexCount)]
        XCTAssertEqual(try vertices.withUnsafeMutableBytes { try avatar.writeMesh(mesh, into: $0) }.count, vertexCount)
        XCTAssertEqual(vertices[0], 3, accuracy: 0.51)
        XCTAssertEqual(vertices[3 * vertexCount + 2], 1, accuracy: 1e-5, "the square looks at +Z")

        let refused: [[BufferElement<SplatProperty>]] = [
            [BufferElement(.position, offsetBytes: -4)], [BufferElement(.position, strideBytes: 8)],
            [BufferElement(.harmonics, offsetBytes: 1 << 40)],
        ]
        for wrong in refused {
            XCTAssertThrowsError(try vertices.withUnsafeMutableBytes { try avatar.writeSplats(wrong, into: $0) }) {
                XCTAssertEqual(($0 as? DoppelError)?.code, .invalidArgument)
            }
        }
    }

    func testAPlayerFadesPausesAndForgets() throws {
        let context = try DoppelContext(renderer: .software)
        let avatar = try context.loadAvatar(TestAvatar.bytes)
        var player = Player()
        XCTAssertTrue(player.layers(nowNs: 0).isEmpty)
        try player.play(0, of: avatar, nowNs: 1_000_000_000)
        try player.play(0, of: avatar, nowNs: 2_000_000_000, Playback(speed: 2, fadeS: 1, fromS: 0.25))
        let half = player.layers(nowNs: 2_500_000_000)
        XCTAssertEqual(half.map(\.weight), [0.5, 0.5])
        XCTAssertEqual(half[0].timeS, 1.25, accuracy: 1e-9)
        XCTAssertEqual(half[1].timeS, 1.5, accuracy: 1e-9)
        try avatar.setPose(layers: half, timeNs: 2_500_000_000)
        player.pause(nowNs: 2_500_000_000)
        XCTAssertEqual(player.layers(nowNs: 9_000_000_000), half)
        player.resume(nowNs: 9_000_000_000)
        XCTAssertEqual(player.layers(nowNs: 10_000_000_000).map(\.weight), [1])
        try player.setSpeed(0, nowNs: 10_000_000_000)
        XCTAssertEqual(player.layers(nowNs: 11_000_000_000)[0].timeS, 3.25, accuracy: 1e-9)
        XCTAssertThrowsError(try player.stop(nowNs: 0)) { XCTAssertEqual(($0 as? DoppelError)?.code, .invalidArgument) }
        XCTAssertThrowsError(try player.play(7, of: avatar, nowNs: 0)) { XCTAssertEqual(($0 as? DoppelError)?.code, .notFound) }
        XCTAssertThrowsError(try player.play(0, of: avatar, nowNs: 0, Playback(fadeS: -1)))
        var arm = Player(joint: 1)
        try arm.play(0, of: avatar, nowNs: 0, Playback(fadeS: 0))
        try arm.stop(nowNs: 1_000_000_000, fadeS: 1)
        XCTAssertEqual(arm.layers(nowNs: 1_500_000_000).map(\.weight), [0.5])
        XCTAssertTrue(arm.layers(nowNs: 2_000_000_000).isEmpty)
    }

    func testClipsAreMixedJoinedAndRefused() throws {
        let context = try DoppelContext(renderer: .software)
        let avatar = try context.loadAvatar(TestAvatar.bytes)
        try avatar.setPose(clip: 0, timeS: 0.5)
        let plain = try avatar.pose()
        var layer = Avatar.ClipLayer(clip: 0, timeS: 2.5)
        try avatar.setPose(layers: [layer], timeNs: 1_000_000_000)
        XCTAssertEqual(try avatar.pose(), plain)
        let early = Avatar.ClipLayer(clip: 0, timeS: 0.25), late = Avatar.ClipLayer(clip: 0, timeS: 0.75)
        try avatar.setPose(layers: [early, late], timeNs: 1_000_000_000)
        XCTAssertEqual(try avatar.pose().root.y, 0.25, accuracy: 1e-5)
        var before = layer
        before.shiftM = SIMD2(5, 7)
        try avatar.join(before, &layer)
        XCTAssertEqual(layer.shiftM.x, 5, accuracy: 1e-5)
        XCTAssertEqual(layer.shiftM.y, 7, accuracy: 1e-5)
        XCTAssertThrowsError(try avatar.setPose(layers: [Avatar.ClipLayer(clip: 3, timeS: 0)], timeNs: 0)) {
            XCTAssertEqual(($0 as? DoppelError)?.code, .notFound)
        }
        XCTAssertThrowsError(try avatar.setPose(layers: [], timeNs: 0)) { XCTAssertEqual(($0 as? DoppelError)?.code, .invalidArgument) }
        XCTAssertThrowsError(try avatar.look(at: SIMD3(0, 1, 2))) { XCTAssertEqual(($0 as? DoppelError)?.code, .unsupported) }
    }

    func testMistakesThrowTheLibrarysSentence() throws {
        let context = try DoppelContext(renderer: .software)
        XCTAssertThrowsError(try context.loadAvatar([1, 2, 3])) { error in
            XCTAssertEqual((error as? DoppelError)?.code, .corruptData)
            XCTAssertTrue("\(error)".contains("3 left"), "\(error)")
        }
        let avatar = try context.loadAvatar(TestAvatar.bytes)
        XCTAssertThrowsError(try context.loadAvatar(Array(TestAvatar.bytes.dropLast(100)))) {
            XCTAssertEqual(($0 as? DoppelError)?.code, .corruptData)
        }
        XCTAssertThrowsError(try avatar.setPose(Avatar.Pose(rotations: [SIMD4(0, 0, 0, 1)]))) {
            XCTAssertEqual(($0 as? DoppelError)?.code, .invalidArgument)
        }
        XCTAssertThrowsError(try avatar.setPose(Avatar.Pose(rotations: [SIMD4(0, 0, 0, 0), SIMD4(0, 0, 0, 1)]))) {
            XCTAssertTrue("\($0)".contains("pelvis"), "\($0)")
        }
        XCTAssertThrowsError(try avatar.findJoint("tail")) { XCTAssertTrue("\($0)".contains("left_shoulder"), "\($0)") }
        XCTAssertThrowsError(try avatar.setPose(clip: 5, timeS: 0)) { XCTAssertEqual(($0 as? DoppelError)?.code, .notFound) }
        XCTAssertThrowsError(try DoppelContext(threadCount: -1)) { XCTAssertEqual(($0 as? DoppelError)?.code, .invalidArgument) }
        XCTAssertThrowsError(try context.setFrameBudget(milliseconds: .nan))
        XCTAssertThrowsError(try Picture(widthPx: 0, heightPx: 4))
        XCTAssertThrowsError(try Picture(widthPx: 1 << 20, heightPx: 4))
        let camera = try Camera(pose: front, fovYRad: 0.8, widthPx: 32, heightPx: 32)
        XCTAssertThrowsError(try context.render([avatar], from: [camera], into: [try Picture(widthPx: 16, heightPx: 32)])) {
            XCTAssertTrue("\($0)".contains("16 x 32"), "\($0)")
        }
        XCTAssertThrowsError(try context.render([avatar], from: [camera], into: []))
    }

    func testTwoTasksDrawWithContextsOfTheirOwn() async throws {
        let camera = try Camera(pose: front, fovYRad: 0.8, widthPx: 48, heightPx: 48)
        let sums = try await withThrowingTaskGroup(of: Int.self) { group in
            for _ in 0..<2 {
                group.addTask {
                    let context = try DoppelContext(renderer: .software, threadCount: 1)
                    let avatar = try context.loadAvatar(TestAvatar.bytes)
                    let picture = try Picture(widthPx: 48, heightPx: 48)
                    for _ in 0..<5 { try context.render([avatar], from: [camera], into: [picture]) }
                    return picture.rgba.reduce(0) { $0 + Int($1) }
                }
            }
            return try await group.reduce(into: []) { $0.append($1) }
        }
        XCTAssertEqual(sums[0], sums[1])
        XCTAssertGreaterThan(sums[0], 10_000)
    }

    func testAnAvatarOutlivesTheNameOfItsContext() throws {
        var context: DoppelContext? = try DoppelContext(renderer: .software)
        let avatar = try context!.loadAvatar(TestAvatar.bytes)
        context = nil
        let picture = try Picture(widthPx: 32, heightPx: 32)
        try avatar.context.render([avatar], from: [try Camera(pose: front, fovYRad: 0.8, widthPx: 32, heightPx: 32)], into: [picture])
        XCTAssertEqual(picture[16, 16].w, 255)
    }
}

enum TestAvatar {
    static let path = ProcessInfo.processInfo.environment["DOPPEL_TEST_AVATAR"] ?? "DOPPEL_TEST_AVATAR is not set"
    static let bytes = [UInt8]((try? Data(contentsOf: URL(fileURLWithPath: path))) ?? Data())
}
