// SPDX-License-Identifier: Apache-2.0
#if canImport(Metal)
    import CDoppel
    import Doppel
    import Metal

    /// A context that draws in Metal frames of the app's: device, queue, slots in flight, composers, and what to do when the device is
    /// lost. One thread draws with it at a time; `context` may be used from any.
    public final class MetalStage: @unchecked Sendable {  // only the drawing thread touches what changes
        public let device: any MTLDevice
        public let context: DoppelContext
        private var queue: any MTLCommandQueue
        private let slots = FrameSlots()
        private var loss = DeviceLoss()
        private var composers: [MetalPass: UInt32] = [:]
        private let shadows = FloorShadows()

        /// device: nil for that of the system. cacheFolder: as for `DoppelContext`.
        public init(device given: (any MTLDevice)? = nil, cacheFolder: String? = nil) throws(DoppelError) {
            guard let device = given ?? MTLCreateSystemDefaultDevice() else {
                throw DoppelError(.unsupported, "this machine has no Metal device")
            }
            self.device = device
            queue = try MetalStage.newQueue(device)
            var mine = MetalStage.lent(device, queue)
            var info = DplContextInfo()
            info.structSize = UInt32(MemoryLayout<DplContextInfo>.size)
            var raw: DplContext?
            let result = withOptionalCString(cacheFolder) { folder in
                info.cacheFolder = folder
                return dplCreateMetalContext(&mine, &info, &raw)
            }
            try check(result)
            context = DoppelContext(owning: raw!)
        }

        private static func newQueue(_ device: any MTLDevice) throws(DoppelError) -> any MTLCommandQueue {
            guard let queue = device.makeCommandQueue() else { throw DoppelError(.device, "\(device.name) gives no command queue") }
            return queue
        }

        private static func lent(_ device: any MTLDevice, _ queue: any MTLCommandQueue) -> DplMetalDevice {
            var out = DplMetalDevice()
            out.structSize = UInt32(MemoryLayout<DplMetalDevice>.size)
            out.device = pointer(device)
            out.queue = pointer(queue)
            return out
        }

        /// Compiles what composes into passes of this kind, once. Call it before the first frame. Throws `.unsupported` for a format, a
        /// number of samples or layers that cannot be drawn into; the text says which.
        public func make(_ pass: MetalPass) throws(DoppelError) { _ = try composer(pass) }

        private func composer(_ pass: MetalPass) throws(DoppelError) -> UInt32 {
            if let known = composers[pass] { return known }
            var raw = pass.raw, made: UInt32 = 0
            try check(dplCreateMetalComposer(context.raw, &raw, &made))
            composers[pass] = made
            return made
        }

        /// Prepares avatars, in their current poses, for one or two views. Nil: leave this frame out, because three are in flight or the
        /// device is being replaced. waitS: how long to wait for a slot; 0 on a thread that must not wait. Without avatars the frame
        /// carries uploads only. After it, encode passes with `compose` and end with `commit`.
        public func begin(_ avatars: [Avatar], from cameras: [Camera], nowS: Double, waitS: Double = 0) throws(DoppelError) -> MetalFrame? {
            guard loss.mayDraw(nowS: nowS), let slot = slots.take(waitS: waitS) else { return nil }
            guard let commands = queue.makeCommandBuffer() else {
                slots.giveBack(slot)
                throw DoppelError(.device, "\(device.name) gives no command buffer")
            }
            do {
                try check(prepare(avatars, cameras, slot, commands))
            } catch {
                dplMetalDropSlot(context.raw, slot)
                slots.giveBack(slot)
                if error.code == .device, loss.failed() == .rebuild { try rebuild(nowS: nowS) }
                throw error
            }
            loss.drew()
            return MetalFrame(slot: slot, commands: commands, viewCount: avatars.isEmpty ? 0 : cameras.count)
        }

        private func prepare(_ avatars: [Avatar], _ cameras: [Camera], _ slot: UInt32, _ commands: any MTLCommandBuffer) -> DplResult {
            if avatars.isEmpty { return dplMetalUpload(context.raw, pointer(commands), slot) }
            let handles = avatars.map { Optional($0.raw) }
            let views = cameras.map(\.raw)
            return withExtendedLifetime(avatars) {
                dplMetalPrepare(context.raw, pointer(commands), slot, handles, UInt32(handles.count), views, UInt32(views.count), nil)
            }
        }

        /// A new queue, and composers again. Avatars stay.
        private func rebuild(nowS: Double) throws(DoppelError) {
            do {
                let fresh = try MetalStage.newQueue(device)
                var mine = MetalStage.lent(device, fresh)
                try check(dplRebuildMetal(context.raw, &mine))
                queue = fresh
                let passes = Array(composers.keys)
                composers = [:]
                for pass in passes { try make(pass) }
            } catch {
                loss.rebuildFailed(nowS: nowS)
                throw error
            }
        }

        /// Lays the picture of a view over the colour attachment of the pass, and its depth into the depth attachment if `depth` is given.
        /// With layers all views are composed at once. x, y: of the picture's top left corner, pixels.
        public func compose(
            _ frame: MetalFrame, into encoder: any MTLRenderCommandEncoder, pass: MetalPass, view: Int = 0, x: Int = 0, y: Int = 0,
            depth: Camera.StoredDepth? = nil
        ) throws(DoppelError) {
            if frame.viewCount == 0 { return }
            let composer = try composer(pass), view = UInt32(view), x = Int32(x), y = Int32(y)
            try check(dplMetalCompose(context.raw, composer, pointer(encoder), frame.slot, view, x, y))
            guard let depth else { return }
            try check(dplMetalComposeDepth(context.raw, composer, pointer(encoder), frame.slot, view, x, y, depth.scale, depth.offset))
        }

        /// Writes the splats of an avatar in its current pose into a buffer of the app's, for an engine that draws them itself. The frame
        /// need not draw the avatar. Offsets and strides of `elements` are multiples of 4. The buffer must live until the frame has run,
        /// and no encoder may be open. See `dplMetalWriteSplats`; experimental.
        @discardableResult
        public func writeSplats(
            of avatar: Avatar, _ elements: [BufferElement<SplatProperty>], into buffer: any MTLBuffer, in frame: MetalFrame,
            _ options: SplatOptions = SplatOptions()
        ) throws(DoppelError) -> Written {
            try withElements(elements) { raw, count throws(DoppelError) in
                var rows = DplMetalBuffer()
                rows.structSize = UInt32(MemoryLayout<DplMetalBuffer>.size)
                rows.elements = raw
                rows.elementCount = count
                rows.buffer = pointer(buffer)
                rows.bytes = UInt64(buffer.length)
                return try options.written { dplMetalWriteSplats(avatar.raw, pointer(frame.commands), frame.slot, $0, &rows, $1) }
            }
        }

        /// How many splats `writeSplats` writes.
        public func splatCount(of avatar: Avatar, _ options: SplatOptions = SplatOptions()) throws(DoppelError) -> Int {
            try options.written { dplMetalWriteSplats(avatar.raw, nil, 0, $0, nil, $1) }.count
        }

        /// Draws contact shadows into a pass, before `compose`. cameras: of the pass's view; with layers of all views. x, y: as for
        /// `compose`. Throws `.unsupported` where Metal does not compile the shader.
        public func drawShadows(
            _ given: [ContactShadow], from cameras: [Camera], into encoder: any MTLRenderCommandEncoder, pass: MetalPass, x: Int = 0,
            y: Int = 0
        ) throws(DoppelError) {
            try shadows.draw(given, from: cameras, on: device, into: encoder, pass: pass, x: x, y: y)
        }

        /// Commits the frame; its slot is free once the GPU has run it.
        public func commit(_ frame: MetalFrame, presenting drawable: (any MTLDrawable)? = nil) {
            let slots = slots, slot = frame.slot
            frame.commands.addCompletedHandler { _ in slots.giveBack(slot) }
            if let drawable { frame.commands.present(drawable) }
            frame.commands.commit()
        }

        /// A command buffer without a frame of Doppel's, for a picture that must be presented empty.
        public func emptyCommands() -> (any MTLCommandBuffer)? { queue.makeCommandBuffer() }
    }

    /// A frame between `begin` and `commit`.
    public struct MetalFrame {
        public let slot: UInt32
        public let commands: any MTLCommandBuffer
        /// 0: uploads only; nothing is composed.
        public let viewCount: Int
    }

    /// A kind of render pass, as `DplMetalPass`.
    public struct MetalPass: Hashable, Sendable {
        public var colour: MTLPixelFormat
        public var depth: MTLPixelFormat
        public var samples: Int
        /// 0: one pass for each view.
        public var layers: Int
        public var writesDepth: Bool

        public init(colour: MTLPixelFormat, depth: MTLPixelFormat = .invalid, samples: Int = 1,
            layers: Int = 0, writesDepth: Bool = false) {
            self.colour = colour
            self.depth = depth
            self.samples = samples
            self.layers = layers
            self.writesDepth = writesDepth
        }

        var raw: DplMetalPass {
            var out = DplMetalPass()
            out.structSize = UInt32(MemoryLayout<DplMetalPass>.size)
            out.colourFormat = UInt32(colour.rawValue)
            out.depthFormat = UInt32(depth.rawValue)
            out.samples = UInt32(samples)
            out.layers = UInt32(layers)
            out.writesDepth = writesDepth ? UInt32(DPL_DRAW_DEPTH.rawValue) : 0
            return out
        }
    }

    /// An object as the C interface takes it. The caller keeps it alive during the call.
    private func pointer(_ object: AnyObject) -> UnsafeMutableRawPointer { Unmanaged.passUnretained(object).toOpaque() }
#endif
