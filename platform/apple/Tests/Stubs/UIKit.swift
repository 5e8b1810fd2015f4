// SPDX-License-Identifier: Apache-2.0
// UIKit: what this package uses of it. Declarations only, checked against the public documentation; see README.md.
@_exported import Foundation

@MainActor open class UIResponder: NSObject {}

@MainActor open class UIView: UIResponder {
    public init(frame: CGRect) { fatalError() }
    public required init?(coder: NSCoder) { fatalError() }
    open var isOpaque: Bool { get { fatalError() } set {} }
    open func draw(_ rect: CGRect) {}
}

@MainActor open class UIApplication: UIResponder {
    public nonisolated class var didEnterBackgroundNotification: Notification.Name { fatalError() }
    public nonisolated class var willEnterForegroundNotification: Notification.Name { fatalError() }
    public nonisolated class var didReceiveMemoryWarningNotification: Notification.Name { fatalError() }
}

public enum UIInterfaceOrientation: Int, Sendable {
    case unknown, portrait, portraitUpsideDown, landscapeRight, landscapeLeft
}
