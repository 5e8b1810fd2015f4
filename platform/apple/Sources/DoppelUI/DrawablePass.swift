// SPDX-License-Identifier: Apache-2.0
#if canImport(CompositorServices) && !os(macOS)
    import CompositorServices
    import Metal

    /// A render pass into a drawable of visionOS: one with layers for both eyes ("layered"), or one for each view, in a texture of its own
    /// ("dedicated") or at its place in one texture ("shared").
    struct DrawablePass {
        let descriptor: MTLRenderPassDescriptor
        let kind: MetalPass
        /// The view of the pass; with layers the first of all.
        let view: Int
        let x, y: Int

        static func all(of drawable: LayerRenderer.Drawable) -> [DrawablePass] {
            let views = drawable.views
            let layered = views.count > 1 && drawable.colorTextures.count == 1 && drawable.colorTextures[0].arrayLength == views.count
            if layered { return [DrawablePass(drawable, view: 0, layers: views.count, clears: true)] }
            var cleared: Set<[Int]> = []  // texture and slice
            return views.indices.map { view in
                let map = views[view].textureMap
                let first = cleared.insert([map.textureIndex, map.sliceIndex]).inserted
                return DrawablePass(drawable, view: view, layers: 0, clears: first)
            }
        }

        private init(_ drawable: LayerRenderer.Drawable, view: Int, layers: Int, clears: Bool) {
            let map = drawable.views[view].textureMap
            let colour = drawable.colorTextures[map.textureIndex], depth = drawable.depthTextures[map.textureIndex]
            let slice = layers > 0 ? 0 : map.sliceIndex
            descriptor = MTLRenderPassDescriptor()
            descriptor.renderTargetArrayLength = layers
            descriptor.colorAttachments[0].texture = colour
            descriptor.colorAttachments[0].slice = slice
            descriptor.colorAttachments[0].loadAction = clears ? .clear : .load
            descriptor.colorAttachments[0].storeAction = .store
            descriptor.colorAttachments[0].clearColor = MTLClearColor(red: 0, green: 0, blue: 0, alpha: 0)
            descriptor.depthAttachment.texture = depth
            descriptor.depthAttachment.slice = slice
            descriptor.depthAttachment.loadAction = clears ? .clear : .load
            descriptor.depthAttachment.storeAction = .store
            descriptor.depthAttachment.clearDepth = 0  // reversed: 0 is far
            kind = MetalPass(colour: colour.pixelFormat, depth: depth.pixelFormat, layers: layers, writesDepth: true)
            self.view = view
            x = layers > 0 ? 0 : Int(map.viewport.originX)
            y = layers > 0 ? 0 : Int(map.viewport.originY)
        }
    }
#endif
