// SPDX-License-Identifier: Apache-2.0
// Writes sample files into a folder: the fuzz corpus, which is checked in, and the input of the glTF validator.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "sdk/format/gltf_mesh.h"
#include "sdk/format/gltf_splats.h"
#include "sdk/format/ply.h"
#include "tests/unit/format/one_pixel_png.h"
#include "tests/unit/format/sample_avatars.h"
#include "tests/unit/format/sample_correctives.h"
#include "tests/unit/format/sample_expressions.h"

namespace {

bool save(const std::filesystem::path& path, const dpl::Result<std::vector<uint8_t>>& bytes) {
    if (!bytes) return std::fprintf(stderr, "%s: %s\n", path.c_str(), bytes.error().message.c_str()), false;
    std::ofstream out(path, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes->data()), std::streamsize(bytes->size()));
    return bool(out);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]), 2;
    const std::filesystem::path folder = argv[1];
    std::filesystem::create_directories(folder);
    dpl::StaticSplatData splats;
    splats.position = {{0, 1, 0}, {0.5f, 1, 0}}, splats.rotation = {{1, 0, 0, 0}, {0.5f, 0.5f, 0.5f, 0.5f}};
    splats.scaleM = {{0.01f, 0.02f, 0.03f}, {0.1f, 0.1f, 0.001f}}, splats.opacity = {0.9f, 0.1f}, splats.sh.assign(2 * 12, 0.25f),
    splats.shDegree = 1;
    bool ok = save(folder / "tiny.glb", dpl::writeAvatar(dpl::test::tinyAvatar()));
    ok &= save(folder / "tiny_plain.glb", dpl::writeAvatar(dpl::test::tinyAvatar(), {.draco = false}));
    ok &= save(folder / "small.glb", dpl::writeAvatar(dpl::test::layeredAvatar(1, 1, 8, 3)));
    ok &= save(folder / "small_plain.glb", dpl::writeAvatar(dpl::test::layeredAvatar(1, 1, 8, 3), {.draco = false}));
    ok &= save(folder / "palette_plain.glb", dpl::writeAvatar(dpl::test::layeredAvatar(1, 1, 8, 3), {.draco = false, .shPalette = true}));
    ok &= save(folder / "compact_plain.glb",
               dpl::writeAvatar(dpl::test::withCorrectives(dpl::test::layeredAvatar(1, 1, 8, 5), 1, {.modes = 6, .nodes = 60}),
                                {.draco = false, .shPalette = true, .compact = true, .bits = {6, 5, 6, 4, 6}}));
    ok &= save(folder / "correctives.glb", dpl::writeAvatar(dpl::test::tinyCorrectedAvatar()));
    ok &= save(folder / "correctives_plain.glb", dpl::writeAvatar(dpl::test::tinyCorrectedAvatar(), {.draco = false}));
    ok &= save(folder / "motion.glb", dpl::writeAvatar(dpl::test::tinyMovingAvatar()));
    ok &= save(folder / "light.glb", dpl::writeAvatar(dpl::test::tinyLitAvatar()));
    ok &= save(folder / "motion_plain.glb", dpl::writeAvatar(dpl::test::tinyMovingAvatar(), {.draco = false, .compact = true}));
    dpl::AvatarData mapped = dpl::test::tinyAvatar();
    mapped.captureMap = dpl::test::sampleCaptureMap(mapped.joints.size());
    ok &= save(folder / "capture_map_plain.glb", dpl::writeAvatar(mapped, {.draco = false}));
    ok &= save(folder / "expressions.glb", dpl::writeAvatar(dpl::test::withExpressions(dpl::test::tinyCorrectedAvatar(), 1)));
    ok &=
        save(folder / "expressions_plain.glb", dpl::writeAvatar(dpl::test::withExpressions(dpl::test::tinyAvatar(), 1), {.draco = false}));
    const dpl::AvatarData layered = dpl::test::layeredAvatar(1, 1, 8, 3);
    const std::vector<dpl::Vec3f> normals(layered.mesh.restPositions.size(), dpl::Vec3f(0, 0, 1));
    const std::vector<dpl::Vec2f> uv(normals.size(), dpl::Vec2f(0.25f, 0.75f));
    const std::vector<uint8_t> image = dpl::test::onePixelPng();
    ok &= save(folder / "mesh.glb", dpl::writeGltfMesh(layered, normals, {uv, image}));
    ok &= save(folder / "mesh_draco.glb", dpl::writeGltfMesh(layered, normals, {uv, image}, {.draco = true}));
    ok &= save(folder / "splats.ply", dpl::writePly(splats));
    ok &= save(folder / "splats.glb", dpl::writeGltfSplats(splats));
    return ok ? 0 : 1;
}
