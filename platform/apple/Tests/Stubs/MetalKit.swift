// SPDX-License-Identifier: Apache-2.0
// MetalKit: what this package uses of it. Declarations only, checked against the public documentation; see README.md.
import Foundation
@_exported import Metal
import QuartzCore

#if canImport(UIKit)
    import UIKit
    public typealias PlatformView = UIView
#else
    import AppKit
    public typealias PlatformView = NSView
#endif

@MainActor open class MTKView: PlatformView {
    public init(frame: CGRect, device: (any MTLDevice)?) { fatalError() }
    public required init(coder: NSCoder) { fatalError() }
    open var colorPixelFormat: MTLPixelFormat { get { fatalError() } set {} }
    open var depthStencilPixelFormat: MTLPixelFormat { get { fatalError() } set {} }
    open var sampleCount: Int { get { fatalError() } set {} }
    open var clearColor: MTLClearColor { get { fatalError() } set {} }
    open var drawableSize: CGSize { get { fatalError() } set {} }
    open var preferredFramesPerSecond: Int { get { fatalError() } set {} }
    open var isPaused: Bool { get { fatalError() } set {} }
    open var currentRenderPassDescriptor: MTLRenderPassDescriptor? { fatalError() }
    open var currentDrawable: (any CAMetalDrawable)? { fatalError() }
}
