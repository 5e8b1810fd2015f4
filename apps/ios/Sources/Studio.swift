// SPDX-License-Identifier: Apache-2.0
import Combine
import Doppel
import DoppelUI
import Foundation
import QuartzCore

/// What the app shows: one avatar, its clip, and the camera of fingers or of ARKit.
@MainActor
final class Studio: ObservableObject, AvatarScene {
    enum Mode: Hashable {
        /// Fingers turn the camera.
        case studio
        /// The avatar stands on the floor of the room that the camera sees.
        case room
        /// The avatar moves as the person does whom the camera sees.
        case drive
    }

    @Published var mode = Mode.studio { didSet { changeMode() } }
    @Published var isPlaying = true
    @Published private(set) var message: String?
    /// Of a running load.
    @Published private(set) var progress: Float?
    let stage: MetalStage?
    let room = Room()
    private static let fovYRad: Float = 0.7
    private var avatar: Avatar?
    private var orbit = Orbit(target: SIMD3(0, 1, 0), distanceM: 3)
    private var clipTimeS = 0.0
    private var lastTimeS: Double?
    private var loading: Task<Void, Never>?

    init() {
        do {
            let caches = FileManager.default.urls(for: .cachesDirectory, in: .userDomainMask).first
            stage = try MetalStage(cacheFolder: caches?.path)
        } catch {
            stage = nil
            message = error.message
        }
    }

    /// Loads a file that the user chose. The avatar before it stays until the new one is there.
    func load(_ file: URL) {
        guard let stage else { return }
        loading?.cancel()
        progress = 0
        loading = Task { [weak self] in
            let granted = file.startAccessingSecurityScopedResource()
            defer { if granted { file.stopAccessingSecurityScopedResource() } }
            do {
                let loaded = try await stage.context.avatar(contentsOf: file) { part in
                    Task { @MainActor in self?.report(part) }
                }
                try self?.show(loaded)
            } catch is CancellationError {
                // The user asked for it, or for another file.
            } catch {
                self?.message = "\(error)"
            }
            if !Task.isCancelled { self?.progress = nil }
        }
    }

    func cancelLoad() {
        loading?.cancel()
        progress = nil
    }

    private func report(_ part: Float) {
        if progress != nil { progress = part }
    }

    private func show(_ loaded: Avatar) throws(DoppelError) {
        let info = try loaded.info()
        orbit = Orbit(around: info, fovYRad: Studio.fovYRad)
        avatar = loaded
        message = info.splatCount < info.fileSplatCount ? "memory is short: \(info.splatCount) of \(info.fileSplatCount) splats" : nil
        changeMode()
    }

    private func changeMode() {
        do {
            try room.start(mode, driving: avatar)
        } catch {
            message = error.message
        }
    }

    func drag(x: Float, y: Float) {
        if mode == .studio { orbit.drag(x: x, y: y) } else { room.turn(byRad: x * .pi) }
    }

    func zoom(by factor: Float) {
        if mode == .studio { orbit.zoom(by: factor) }
    }

    // MARK: AvatarScene

    func avatars(displayTimeS: Double) -> [Avatar] {
        guard let avatar else { return [] }
        if isPlaying { clipTimeS += displayTimeS - (lastTimeS ?? displayTimeS) }
        lastTimeS = displayTimeS
        do {
            if mode == .drive, let drive = room.drive {
                try drive.pose(displayTimeS: displayTimeS)
            } else if try avatar.info().clipCount > 0 {
                try avatar.setPose(clip: 0, timeS: clipTimeS)
            }
        } catch {
            problem(error)
        }
        return [avatar]
    }

    func camera(widthPx: Int, heightPx: Int) throws(DoppelError) -> Camera {
        if mode != .studio, let camera = try room.camera(widthPx: widthPx, heightPx: heightPx) {
            try avatar?.setTransform(room.roomFromAvatar)
            return camera
        }
        try avatar?.setTransform(RigidPose())
        return try Camera(pose: orbit.eye, fovYRad: Studio.fovYRad, widthPx: widthPx, heightPx: heightPx)
    }

    /// By which it stands on the floor of the studio, or of the room.
    func shadows(of avatars: [Avatar]) throws(DoppelError) -> [ContactShadow] {
        guard let avatar = avatars.first, try avatar.info().jointCount > 0 else { return [] }
        return [try avatar.contactShadow()]
    }

    func problem(_ error: DoppelError) { message = error.message }
}
