// SPDX-License-Identifier: Apache-2.0
#if canImport(MetalKit) && (canImport(UIKit) || canImport(AppKit)) && !os(visionOS)
    import Doppel
    import Foundation
    import Metal
    import MetalKit
    import QuartzCore

    #if canImport(UIKit)
        import UIKit
        import os
    #endif

    /// What a DoppelView shows. Called on the main actor, once a frame.
    @MainActor public protocol AvatarScene: AnyObject {
        /// Poses avatars for a picture that is shown at displayTimeS (the clock of CACurrentMediaTime), and names those to draw.
        func avatars(displayTimeS: Double) -> [Avatar]
        /// The camera of a view of this size.
        func camera(widthPx: Int, heightPx: Int) throws(DoppelError) -> Camera
        /// The shadows on the floor of this picture, such as `contactShadow()` of the avatars. None, unless a scene says otherwise.
        func shadows(of avatars: [Avatar]) throws(DoppelError) -> [ContactShadow]
        /// A frame could not be drawn; the next one is tried. Called once for each new text.
        func problem(_ error: DoppelError)
    }

    extension AvatarScene {
        public func shadows(of avatars: [Avatar]) throws(DoppelError) -> [ContactShadow] { [] }
    }

    /// Draws avatars in a view on iOS and macOS. Nothing is drawn in the background; loads wait meanwhile.
    public final class DoppelView: MTKView {
        /// What is drawn into if `colorPixelFormat` was set to a format that cannot be.
        public static let usualFormat = MTLPixelFormat.bgra8Unorm_srgb

        public let stage: MetalStage
        public weak var avatarScene: (any AvatarScene)?
        private var lastProblem: DoppelError?
        private var shown: Avatar?
        /// By the app, before it went to the background.
        private var wasPaused = false
        private let tokens = NotificationTokens()

        /// transparent: the view below shows where no avatar is, such as a camera's picture.
        public init(stage: MetalStage, transparent: Bool = false) {
            self.stage = stage
            super.init(frame: .zero, device: stage.device)
            colorPixelFormat = DoppelView.usualFormat
            let grey = transparent ? 0 : 0.9
            clearColor = MTLClearColor(red: grey, green: grey, blue: grey, alpha: transparent ? 0 : 1)
            #if canImport(UIKit)
                isOpaque = !transparent
                watchTheApp()
            #else
                layer?.isOpaque = !transparent
            #endif
        }

        @available(*, unavailable)
        public required init(coder: NSCoder) { fatalError("DoppelView is made in code") }

        #if canImport(UIKit)
            private func watchTheApp() {
                tokens.add(UIApplication.didEnterBackgroundNotification) { [weak self] in self?.leaveTheScreen() }
                tokens.add(UIApplication.willEnterForegroundNotification) { [weak self] in self?.comeBack() }
                tokens.add(UIApplication.didReceiveMemoryWarningNotification) { [weak self] in self?.limitMemory(afterWarning: true) }
                limitMemory(afterWarning: false)
            }

            private func leaveTheScreen() {
                wasPaused = isPaused
                isPaused = true
            }

            private func comeBack() {
                isPaused = wasPaused
                limitMemory(afterWarning: false)
            }

            /// Loads to come must fit what the system leaves this app; after a warning, what is held now. See `MemoryRule`.
            private func limitMemory(afterWarning: Bool) {
                let resident = (try? shown?.frameStats().residentBytes) ?? 0
                let limit =
                    afterWarning
                    ? MemoryRule.limitAfterWarning(residentBytes: resident)
                    : MemoryRule.limit(residentBytes: resident, availableBytes: UInt64(os_proc_available_memory()))
                attempt { () throws(DoppelError) in try stage.context.setMemoryLimit(bytes: limit) }
            }
        #endif

        /// Called at the display's rate. A frame has the size that the view has by then; nothing is kept for the old one.
        public override func draw(_ rect: CGRect) {
            attempt { () throws(DoppelError) in try drawFrame() }
        }

        private func drawFrame() throws(DoppelError) {
            let width = Int(drawableSize.width), height = Int(drawableSize.height)
            guard let avatarScene, width > 0, height > 0 else { return }
            let pass = MetalPass(colour: colorPixelFormat, depth: depthStencilPixelFormat, samples: sampleCount)
            do {
                try stage.make(pass)
            } catch {
                if error.code == .unsupported { colorPixelFormat = DoppelView.usualFormat }
                throw error
            }
            let nowS = CACurrentMediaTime()
            let avatars = avatarScene.avatars(displayTimeS: nowS + 1 / Double(max(preferredFramesPerSecond, 1)))
            shown = avatars.first
            let camera = try avatarScene.camera(widthPx: width, heightPx: height)
            let shadows = try avatarScene.shadows(of: avatars)
            guard let frame = try stage.begin(avatars, from: [camera], nowS: nowS) else { return }
            // From here on the frame is committed whatever happens, so that its slot comes back.
            guard let descriptor = currentRenderPassDescriptor, let drawable = currentDrawable,
                let encoder = frame.commands.makeRenderCommandEncoder(descriptor: descriptor)
            else { return stage.commit(frame) }
            defer {
                encoder.endEncoding()
                stage.commit(frame, presenting: drawable)
            }
            try stage.drawShadows(shadows, from: [camera], into: encoder, pass: pass)
            try stage.compose(frame, into: encoder, pass: pass)
        }

        private func attempt(_ body: () throws(DoppelError) -> Void) {
            do {
                try body()
                lastProblem = nil
            } catch {
                if error != lastProblem { avatarScene?.problem(error) }
                lastProblem = error
            }
        }
    }

    /// Notifications that end with this object. They are delivered on the main thread.
    private final class NotificationTokens {
        private var tokens: [any NSObjectProtocol] = []

        @MainActor func add(_ name: Notification.Name, _ body: @escaping @MainActor @Sendable () -> Void) {
            tokens.append(
                NotificationCenter.default.addObserver(forName: name, object: nil, queue: .main) { _ in
                    MainActor.assumeIsolated { body() }
                })
        }

        deinit { for token in tokens { NotificationCenter.default.removeObserver(token) } }
    }
#endif
