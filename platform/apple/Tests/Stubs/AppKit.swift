// SPDX-License-Identifier: Apache-2.0
// AppKit: what this package uses of it. Declarations only, checked against the public documentation; see README.md.
@_exported import Foundation
import QuartzCore

@MainActor open class NSResponder: NSObject {}

@MainActor open class NSView: NSResponder {
    public init(frame: NSRect) { fatalError() }
    public required init?(coder: NSCoder) { fatalError() }
    open var layer: CALayer? { get { fatalError() } set {} }
    open func draw(_ dirtyRect: NSRect) {}
}
