// SPDX-License-Identifier: Apache-2.0
// QuartzCore: what this package uses of it. Declarations only, checked against the public documentation; see README.md.
import Foundation
@_exported import Metal

public func CACurrentMediaTime() -> Double { fatalError() }

open class CALayer: NSObject {
    public var isOpaque = false
}

public protocol CAMetalDrawable: MTLDrawable {}
