// SPDX-License-Identifier: Apache-2.0
// Metal: what this package uses of it. Declarations only, checked against the public documentation; see README.md.

public protocol MTLDevice: AnyObject, Sendable {
    var name: String { get }
    func makeCommandQueue() -> (any MTLCommandQueue)?
}

public func MTLCreateSystemDefaultDevice() -> (any MTLDevice)? { fatalError() }

public protocol MTLCommandQueue: AnyObject, Sendable {
    func makeCommandBuffer() -> (any MTLCommandBuffer)?
}

public protocol MTLDrawable: AnyObject {}

public protocol MTLCommandBuffer: AnyObject {
    func makeRenderCommandEncoder(descriptor: MTLRenderPassDescriptor) -> (any MTLRenderCommandEncoder)?
    func addCompletedHandler(_ block: @escaping @Sendable (any MTLCommandBuffer) -> Void)
    func present(_ drawable: any MTLDrawable)
    func commit()
}

public protocol MTLCommandEncoder: AnyObject {
    func endEncoding()
}

public protocol MTLRenderCommandEncoder: MTLCommandEncoder {}

public enum MTLPixelFormat: UInt, Sendable {
    case invalid = 0
    case rgba8Unorm = 70
    case rgba8Unorm_srgb = 71
    case bgra8Unorm = 80
    case bgra8Unorm_srgb = 81
    case rgba16Float = 115
    case depth32Float = 252
}

public protocol MTLTexture: AnyObject {
    var pixelFormat: MTLPixelFormat { get }
    var arrayLength: Int { get }
}

public struct MTLClearColor: Sendable {
    public init(red: Double, green: Double, blue: Double, alpha: Double) { fatalError() }
}

public struct MTLViewport: Sendable {
    public var originX, originY, width, height, znear, zfar: Double
}

public enum MTLLoadAction: UInt, Sendable { case dontCare, load, clear }
public enum MTLStoreAction: UInt, Sendable { case dontCare, store }

open class MTLRenderPassAttachmentDescriptor {
    public var texture: (any MTLTexture)?
    public var slice = 0
    public var loadAction = MTLLoadAction.dontCare
    public var storeAction = MTLStoreAction.dontCare
}

public final class MTLRenderPassColorAttachmentDescriptor: MTLRenderPassAttachmentDescriptor {
    public var clearColor: MTLClearColor { get { fatalError() } set {} }
}

public final class MTLRenderPassDepthAttachmentDescriptor: MTLRenderPassAttachmentDescriptor {
    public var clearDepth: Double { get { fatalError() } set {} }
}

public final class MTLRenderPassColorAttachmentDescriptorArray {
    public subscript(attachmentIndex: Int) -> MTLRenderPassColorAttachmentDescriptor! { get { fatalError() } set {} }
}

public final class MTLRenderPassDescriptor {
    public init() {}
    public var colorAttachments: MTLRenderPassColorAttachmentDescriptorArray { fatalError() }
    public var depthAttachment: MTLRenderPassDepthAttachmentDescriptor! { get { fatalError() } set {} }
    public var renderTargetArrayLength: Int { get { 0 } set {} }
}
