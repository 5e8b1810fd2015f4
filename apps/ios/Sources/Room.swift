// SPDX-License-Identifier: Apache-2.0
import ARKit
import Doppel
import DoppelUI
import Foundation
import simd

/// ARKit: where the phone is, where the floor is, and how the person moves whom the camera sees.
@MainActor
final class Room {
    let session = ARSession()
    private(set) var drive: BodyDrive?
    private let news = News()
    /// Where the avatar stands. Known once `camera` has given one.
    private(set) var roomFromAvatar = RigidPose()
    private var isPlaced = false

    init() { session.delegate = news }

    /// Starts or ends tracking. Throws `.unsupported` where the device cannot do it.
    func start(_ mode: Studio.Mode, driving avatar: Avatar?) throws(DoppelError) {
        drive = nil
        news.drive = nil
        isPlaced = false
        session.pause()
        switch mode {
        case .studio:
            return
        case .room:
            guard ARWorldTrackingConfiguration.isSupported else { throw DoppelError(.unsupported, "this device cannot track the room") }
            let configuration = ARWorldTrackingConfiguration()
            configuration.planeDetection = [.horizontal]
            session.run(configuration, options: [.resetTracking, .removeExistingAnchors])
        case .drive:
            guard ARBodyTrackingConfiguration.isSupported else {
                throw DoppelError(.unsupported, "ARKit tracks bodies on devices with an A12 chip and later")
            }
            guard let avatar else { throw DoppelError(.invalidArgument, "open an avatar, then drive it") }
            let made = try BodyDrive(driving: avatar)
            drive = made
            news.drive = made
            let configuration = ARBodyTrackingConfiguration()
            configuration.planeDetection = [.horizontal]
            session.run(configuration, options: [.resetTracking, .removeExistingAnchors])
        }
    }

    /// Turns the avatar on its spot.
    func turn(byRad yawRad: Float) { roomFromAvatar = roomFromAvatar * RigidPose(yawRad: yawRad) }

    /// The phone's camera, for a portrait view of this size. Nil until ARKit has a picture. Of the projection only
    /// the lens is used: no depth is shared with RealityKit.
    func camera(widthPx: Int, heightPx: Int) throws(DoppelError) -> Camera? {
        guard let camera = session.currentFrame?.camera else { return nil }
        let roomFromEye = RigidPose(camera.viewMatrix(for: .portrait)).inverse
        if !isPlaced { place(before: roomFromEye) }
        let projection = camera.projectionMatrix(
            for: .portrait, viewportSize: CGSize(width: widthPx, height: heightPx), zNear: 0.05, zFar: 100)
        return try Camera.from(
            projection: projection.floats, pose: roomFromEye, widthPx: widthPx, heightPx: heightPx
        ).camera
    }

    /// On the highest floor below the phone, or 1.4 m below it until a floor is known; 2 m ahead. It faces the phone; a driven one stands
    /// beside the person and faces as the person does.
    private func place(before roomFromEye: RigidPose) {
        let eye = roomFromEye.position
        let spot = (roomFromEye * RigidPose(position: SIMD3(drive == nil ? 0 : 0.8, 0, -2))).position
        let floors = session.currentFrame?.anchors.compactMap { ($0 as? ARPlaneAnchor)?.transform.columns.3.y } ?? []
        let floor = floors.filter { $0 < eye.y - 0.5 }.max()
        let yawRad = drive == nil ? atan2(eye.x - spot.x, eye.z - spot.z) : 0
        roomFromAvatar = RigidPose(yawRad: yawRad, position: SIMD3(spot.x, floor ?? eye.y - 1.4, spot.z))
        isPlaced = floor != nil
    }
}

/// ARKit's news, on ARKit's queue: bodies go to the tracker, which waits for nothing.
private final class News: NSObject, ARSessionDelegate, @unchecked Sendable {  // the lock guards the drive
    private let lock = NSLock()
    private var kept: BodyDrive?
    var drive: BodyDrive? {
        get { lock.withLock { kept } }
        set { lock.withLock { kept = newValue } }
    }

    func session(_ session: ARSession, didUpdate frame: ARFrame) {
        guard let drive, let body = frame.anchors.lazy.compactMap({ $0 as? ARBodyAnchor }).first else { return }
        // A frame with left and right swapped is dropped: the tracker counts it, and the next one comes.
        try? drive.update(body, timestampS: frame.timestamp)
    }
}
