// SPDX-License-Identifier: Apache-2.0
// Metal: what this package uses of it. Declarations only, checked against the public documentation; see README.md.

public protocol MTLDevice: AnyObject, Sendable {
    var name: String { get }
    func makeCommandQueue() -> (any MTLCommandQueue)?
    func makeLibrary(source: String, options: MTLCompileOptions?) throws -> any MTLLibrary
    func makeRenderPipelineState(descriptor: MTLRenderPipelineDescriptor) throws -> any MTLRenderPipelineState
    func makeBuffer(bytes pointer: UnsafeRawPointer, length: Int, options: MTLResourceOptions) -> (any MTLBuffer)?
}

open class MTLCompileOptions { public init() {} }
public protocol MTLFunction: AnyObject {}
public protocol MTLLibrary: AnyObject {
    func makeFunction(name functionName: String) -> (any MTLFunction)?
}
public protocol MTLRenderPipelineState: AnyObject {}
public enum MTLAttributeFormat: UInt, Sendable { case float = 28, float2, float3, float4 }

public protocol MTLBuffer: AnyObject {
    var length: Int { get }
}
public struct MTLResourceOptions: OptionSet, Sendable {
    public let rawValue: UInt
    public init(rawValue: UInt) { self.rawValue = rawValue }
}
public enum MTLPrimitiveType: UInt, Sendable { case point, line, lineStrip, triangle, triangleStrip }
public enum MTLPrimitiveTopologyClass: UInt, Sendable { case unspecified, point, line, triangle }
public enum MTLBlendFactor: UInt, Sendable {
    case zero = 0
    case one = 1
    case sourceAlpha = 4
    case oneMinusSourceAlpha = 5
}

public final class MTLRenderPipelineColorAttachmentDescriptor {
    public init() {}
    public var pixelFormat = MTLPixelFormat.invalid
    public var isBlendingEnabled = false
    public var sourceRGBBlendFactor = MTLBlendFactor.one
    public var destinationRGBBlendFactor = MTLBlendFactor.zero
    public var sourceAlphaBlendFactor = MTLBlendFactor.one
    public var destinationAlphaBlendFactor = MTLBlendFactor.zero
}

public final class MTLRenderPipelineColorAttachmentDescriptorArray {
    private let first = MTLRenderPipelineColorAttachmentDescriptor()
    public init() {}
    public subscript(attachmentIndex: Int) -> MTLRenderPipelineColorAttachmentDescriptor! { get { first } set {} }
}

public final class MTLRenderPipelineDescriptor {
    public init() {}
    public var vertexFunction: (any MTLFunction)?
    public var fragmentFunction: (any MTLFunction)?
    public var rasterSampleCount = 1
    public var inputPrimitiveTopology = MTLPrimitiveTopologyClass.unspecified
    public var depthAttachmentPixelFormat = MTLPixelFormat.invalid
    public let colorAttachments: MTLRenderPipelineColorAttachmentDescriptorArray! = MTLRenderPipelineColorAttachmentDescriptorArray()
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

public protocol MTLRenderCommandEncoder: MTLCommandEncoder {
    func setRenderPipelineState(_ pipelineState: any MTLRenderPipelineState)
    func setViewport(_ viewport: MTLViewport)
    func setVertexBytes(_ bytes: UnsafeRawPointer, length: Int, index: Int)
    func setFragmentBytes(_ bytes: UnsafeRawPointer, length: Int, index: Int)
    func setFragmentBuffer(_ buffer: (any MTLBuffer)?, offset: Int, index: Int)
    func drawPrimitives(type primitiveType: MTLPrimitiveType, vertexStart: Int, vertexCount: Int, instanceCount: Int)
}

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
    public init(originX: Double, originY: Double, width: Double, height: Double, znear: Double, zfar: Double) {
        (self.originX, self.originY, self.width, self.height, self.znear, self.zfar) = (originX, originY, width, height, znear, zfar)
    }
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
