// SPDX-License-Identifier: Apache-2.0
#if canImport(simd)
    import Doppel
    import simd

    extension RigidPose {
        /// The rotation and translation of a rigid matrix, such as `ARAnchor.transform`.
        public init(_ matrix: simd_float4x4) {
            let p = matrix.columns.3
            self.init(rotation: simd_quatf(matrix).vector, position: SIMD3(p.x, p.y, p.z))
        }
    }

    extension simd_float4x4 {
        /// Column by column.
        public var floats: [Float] {
            [columns.0, columns.1, columns.2, columns.3].flatMap { [$0.x, $0.y, $0.z, $0.w] }
        }
    }
#endif
