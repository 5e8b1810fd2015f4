// SPDX-License-Identifier: Apache-2.0
// RealityKit: what this package uses of it. Declarations only, checked against the public documentation; see README.md.
import ARKit
import UIKit

@MainActor open class ARView: UIView {
    public enum CameraMode: Sendable { case ar, nonAR }
    public init(frame: CGRect, cameraMode: CameraMode, automaticallyConfigureSession: Bool) { fatalError() }
    public required init?(coder: NSCoder) { fatalError() }
    public var session: ARSession { get { fatalError() } set {} }
}
