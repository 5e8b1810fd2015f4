// SPDX-License-Identifier: Apache-2.0
// simd: what this package uses of it. Declarations only, checked against the public documentation; see README.md.

public typealias simd_float4 = SIMD4<Float>

public struct simd_float4x4: Sendable {
    public var columns: (simd_float4, simd_float4, simd_float4, simd_float4)
    public init() { fatalError() }
}

public let matrix_identity_float4x4 = simd_float4x4()

public struct simd_quatf: Sendable {
    public var vector: simd_float4
    public init(_ rotationMatrix: simd_float4x4) { fatalError() }
}
