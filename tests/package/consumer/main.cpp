// SPDX-License-Identifier: Apache-2.0
// The program of main.c with the C++ wrapper.
#include <doppel/doppel.hpp>

#include <cstdio>
#include <vector>

int main(int argc, char** argv) {
    if (argc != 2) return std::printf("usage: consumer_cpp AVATAR.glb\n"), 2;
    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE, 1);
    if (!context) return std::printf("%s\n", context.error().message.c_str()), 1;
    auto avatar = context->loadAvatarFile(argv[1]);
    if (!avatar) return std::printf("%s\n", avatar.error().message.c_str()), 1;
    const uint8_t head[] = {'g', 'l', 'T', 'F'};
    if (auto broken = context->loadAvatar(head)) return std::printf("four bytes were accepted\n"), 1;
    if (auto posed = avatar->setPoseFromClip(0, 0.25); !posed) return std::printf("%s\n", posed.error().message.c_str()), 1;
    std::vector<uint8_t> pixels(64 * 64 * 4);
    auto camera = doppel::Camera::lookAt({.eye = {0, 1, 3}, .target = {0, 1, 0}, .fovYRad = 0.98f, .widthPx = 64, .heightPx = 64});
    if (!camera) return std::printf("%s\n", camera.error().message.c_str()), 1;
    DplImage image{};  // set by field: later versions add fields, and zero in them keeps the earlier behaviour
    image.structSize = sizeof image;
    image.flags = DPL_IMAGE_STRAIGHT_ALPHA;
    image.rgba = pixels.data(), image.rgbaBytes = pixels.size();
    if (auto drawn = avatar->render(*camera, {&image, 1}); !drawn) return std::printf("%s\n", drawn.error().message.c_str()), 1;
    const uint8_t* middle = &pixels[(28 * 64 + 32) * 4];
    std::printf("%s drew %d %d %d %d\n", context->rendererName().c_str(), middle[0], middle[1], middle[2], middle[3]);
    doppel::Avatar moved = std::move(*avatar);
    return moved.info() && middle[0] > 240 && middle[3] > 128 ? 0 : 1;
}
