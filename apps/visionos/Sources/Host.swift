// SPDX-License-Identifier: Apache-2.0
import Doppel
import DoppelUI
import Foundation

/// What window and room share: the avatar, where it stands, and the renderer. Window and compositor call it from threads of their own.
final class Host: ImmersiveScene, @unchecked Sendable {  // the lock guards `state`
    private struct State {
        var avatar: Avatar?
        var clipCount = 0
        var isPlaying = true
        var clipTimeS = 0.0
        var lastTimeS: Double?
        var place = RigidPose(position: SIMD3(0, 0, -1.5))
        var message: String?
    }

    private let lock = NSLock()
    private var state = State()
    let stage: MetalStage?
    private(set) var renderer: CompositorRenderer?

    init() {
        do {
            stage = try MetalStage()
        } catch {
            stage = nil
            state.message = error.message
        }
        renderer = stage.map { CompositorRenderer(stage: $0, scene: self) }
    }

    var message: String? { lock.withLock { state.message } }

    var isPlaying: Bool {
        get { lock.withLock { state.isPlaying } }
        set { lock.withLock { state.isPlaying = newValue } }
    }

    func show(_ avatar: Avatar) throws(DoppelError) {
        let clips = try avatar.info().clipCount
        lock.withLock {
            state.avatar = avatar
            state.clipCount = clips
            state.message = nil
        }
    }

    /// Moves the avatar over the floor of the room, metres, and turns it on its spot.
    func move(x: Float = 0, z: Float = 0, yawRad: Float = 0) {
        lock.withLock {
            state.place = RigidPose(position: SIMD3(x, 0, z)) * state.place * RigidPose(yawRad: yawRad)
        }
    }

    // MARK: ImmersiveScene

    func avatars(displayTimeS: Double) -> [Avatar] {
        let (avatar, place, timeS) = lock.withLock {
            if state.isPlaying { state.clipTimeS += displayTimeS - (state.lastTimeS ?? displayTimeS) }
            state.lastTimeS = displayTimeS
            return (state.avatar, state.place, state.clipCount > 0 ? state.clipTimeS : nil)
        }
        guard let avatar else { return [] }
        do {
            try avatar.setTransform(place)
            if let timeS { try avatar.setPose(clip: 0, timeS: timeS) }
        } catch {
            problem(error)
        }
        return [avatar]
    }

    /// By which it stands on the floor of the room.
    func shadows(of avatars: [Avatar]) throws(DoppelError) -> [ContactShadow] {
        guard let avatar = avatars.first, try avatar.info().jointCount > 0 else { return [] }
        return [try avatar.contactShadow()]
    }

    func problem(_ error: DoppelError) { lock.withLock { state.message = error.message } }
}
