// SPDX-License-Identifier: Apache-2.0
import Doppel
import DoppelUI
import XCTest

/// The parts of views that are plain arithmetic and state.
final class ViewTests: XCTestCase {
    func testAPoseTimesItsInverseIsNoPose() {
        let a = RigidPose(yawRad: 0.7, position: SIMD3(1, 2, 3)) * RigidPose(rotation: SIMD4(0.6, 0, 0, 0.8), position: SIMD3(-2, 0, 1))
        let none = a * a.inverse
        for i in 0..<3 { XCTAssertEqual(none.position[i], 0, accuracy: 1e-6) }
        XCTAssertEqual(abs(none.rotation.w), 1, accuracy: 1e-6)
        // +Z turns towards +X.
        let turned = RigidPose(yawRad: .pi / 2) * RigidPose(position: SIMD3(0, 0, 1))
        XCTAssertEqual(turned.position.x, 1, accuracy: 1e-6)
    }

    func testAnOrbitLooksAtItsTargetFromEverywhere() throws {
        for azimuth in stride(from: Float(-3), through: 3, by: 0.5) {
            for elevation in [Float(-1.4), -0.3, 0, 0.8, 1.4] {
                var orbit = Orbit(target: SIMD3(0.3, 1, -0.2), distanceM: 2)
                orbit.azimuthRad = azimuth
                orbit.elevationRad = elevation
                let camera = try Camera(pose: orbit.eye, fovYRad: 0.8, widthPx: 640, heightPx: 480)
                let m = camera.raw.viewFromWorld
                let rows = [SIMD4(m.0, m.1, m.2, m.3), SIMD4(m.4, m.5, m.6, m.7), SIMD4(m.8, m.9, m.10, m.11)]
                let seen = rows.map { ($0 * SIMD4(orbit.target, 1)).sum() }
                XCTAssertEqual(seen[0], 0, accuracy: 1e-5)
                XCTAssertEqual(seen[1], 0, accuracy: 1e-5)
                XCTAssertEqual(seen[2], 2, accuracy: 1e-5)
                XCTAssertGreaterThan(-rows[1].y, 0, "up stays up")
                XCTAssertEqual(orbit.eye.position.y, 1 + 2 * sin(elevation), accuracy: 1e-5)
            }
        }
    }

    func testFingersCannotTurnAnOrbitOverOrThroughTheAvatar() {
        var orbit = Orbit(target: .zero, distanceM: 2)
        orbit.drag(x: 0.25, y: 100)
        XCTAssertEqual(orbit.elevationRad, 1.48)
        XCTAssertEqual(orbit.azimuthRad, -.pi / 4, accuracy: 1e-6)
        orbit.zoom(by: 1e9)
        XCTAssertEqual(orbit.distanceM, 0.2)
        orbit.zoom(by: .nan)
        orbit.zoom(by: -1)
        XCTAssertEqual(orbit.distanceM, 0.2)
    }

    func testAProjectionTellsCameraAndDepth() throws {
        // Reversed, infinite far plane at 0.1 m, 60 degrees, canted: principal point off the centre.
        let f = Float(1) / tan(.pi / 6)
        let projection: [Float] = [f, 0, 0, 0, 0, f, 0, 0, 0.2, -0.1, 0, -1, 0, 0, 0.1, 0]
        let seen = try Camera.from(projection: projection, pose: RigidPose(), widthPx: 200, heightPx: 200)
        XCTAssertEqual(seen.depth.scale, 0, accuracy: 1e-6)
        XCTAssertEqual(seen.depth.offset, 0.1, accuracy: 1e-6)
        XCTAssertEqual(seen.camera.raw.fx, 100 * f, accuracy: 1e-3)
        XCTAssertEqual(seen.camera.raw.cx, 80, accuracy: 1e-3)
        XCTAssertThrowsError(try Camera.from(projection: [1, 2], pose: RigidPose(), widthPx: 2, heightPx: 2))
        XCTAssertThrowsError(try Camera(pose: RigidPose(position: SIMD3(.nan, 0, 0)), fovYRad: 1, widthPx: 2, heightPx: 2))
    }

    func testSlotsAreUsedInTurnAndAFullRingLeavesFramesOut() {
        let slots = FrameSlots()
        XCTAssertEqual([slots.take(), slots.take(), slots.take()], [0, 1, 2])
        XCTAssertNil(slots.take())
        slots.giveBack(1)
        XCTAssertNil(slots.take(), "slot 0 is next in turn")
        slots.giveBack(0)
        XCTAssertEqual([slots.take(), slots.take()], [0, 1])
        XCTAssertNil(slots.take(waitS: 0.01))
        DispatchQueue.global().asyncAfter(deadline: .now() + 0.05) { slots.giveBack(2) }
        XCTAssertEqual(slots.take(waitS: 600), 2, "waits for the slot in turn")
    }

    func testOneLostFrameIsLeftOutAndTheSecondRebuilds() {
        var loss = DeviceLoss()
        XCTAssertEqual(loss.failed(), .leaveFrameOut)
        loss.drew()
        XCTAssertEqual(loss.failed(), .leaveFrameOut)
        XCTAssertEqual(loss.failed(), .rebuild)
        loss.rebuildFailed(nowS: 10)
        XCTAssertFalse(loss.mayDraw(nowS: 10.9))
        XCTAssertTrue(loss.mayDraw(nowS: 11))
        XCTAssertEqual(loss.failed(), .rebuild)
        loss.drew()
        XCTAssertEqual(loss.failed(), .leaveFrameOut)
    }

    func testMemoryLimitsFollowTheSystem() {
        XCTAssertEqual(MemoryRule.limit(residentBytes: 100 << 20, availableBytes: 400 << 20), 300 << 20)
        XCTAssertEqual(MemoryRule.limit(residentBytes: 0, availableBytes: 1), 64 << 20)
        XCTAssertEqual(MemoryRule.limit(residentBytes: 1, availableBytes: 0), 0)
        XCTAssertEqual(MemoryRule.limit(residentBytes: .max, availableBytes: 1 << 30), .max)
        XCTAssertEqual(MemoryRule.limitAfterWarning(residentBytes: 200 << 20), 200 << 20)
    }
}
