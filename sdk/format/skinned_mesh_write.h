// SPDX-License-Identifier: Apache-2.0
// The part of an avatar's file that any glTF viewer shows: layers as meshes with colours, skeleton and clips
// (docs/formats/avatar.md). Internal. Only .cpp files include it, because the JSON header is slow to compile.
#pragma once

#include <span>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/glb_builder.h"
#include "sdk/format/gltf_mesh.h"

namespace dpl {

struct LayerOptions {
    bool draco = false;                 // needs a viewer that knows KHR_draco_mesh_compression
    std::span<const Vec3f> normals;     // one per vertex of the avatar, unit length, at rest; empty: none are written
    MeshTexture texture;                // of the vertices of the avatar, instead of their colours
    std::span<const MeshMorph> morphs;  // of the vertices of the avatar
};

/** Whether a morph moves a layer, whose mesh then has it as a target. */
bool movesLayer(const MeshMorph& morph, const LayerData& layer);

/** Adds a mesh for each layer, and their unlit material. The avatar has passed checkAvatarWithoutSplats() and snapAvatar(). Errors: Draco
 *  refuses a layer. */
Status addLayers(GlbBuilder& glb, const AvatarData& avatar, const LayerOptions& options);

/** Adds the scene: joints as nodes, the skin, a node for each layer, and the clips as animations. After addLayers(). */
void addSkeletonAndClips(GlbBuilder& glb, const AvatarData& avatar);

/** Unsupported: more bytes than every reader takes. */
Status checkGlbSize(const GlbBuilder& glb);

}  // namespace dpl
