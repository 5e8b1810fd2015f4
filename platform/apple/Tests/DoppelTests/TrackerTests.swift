// SPDX-License-Identifier: Apache-2.0
import Doppel
import XCTest

/// The wrapper of body trackers. What trackers do is tested beside them.
final class TrackerTests: XCTestCase {
    func testJointNamesOfARKit() {
        let names = BodyTracker.Format.arkitBody.jointNames
        XCTAssertEqual(names.count, 91)
        XCTAssertEqual(Array(names.prefix(2)), ["root", "hips_joint"])
        XCTAssertEqual(BodyTracker.Format.mediaPipePose.jointNames.count, 33)
    }

    func testAnAvatarWithoutLimbsCannotBeDriven() throws {
        let avatar = try DoppelContext(renderer: .software).loadAvatar(TestAvatar.bytes)
        XCTAssertThrowsError(try BodyTracker(driving: avatar, format: .vrm)) { error in
            XCTAssertEqual((error as? DoppelError)?.code, .unsupported)
            XCTAssertTrue("\(error)".contains("left_shoulder"), "\(error)")
        }
    }
}
