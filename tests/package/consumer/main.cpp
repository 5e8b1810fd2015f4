// SPDX-License-Identifier: Apache-2.0
// The program of main.c with the C++ wrapper.
#include <doppel/doppel.hpp>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>

int main(int argc, char** argv) {
    if (argc != 2) return std::printf("usage: consumer_cpp AVATAR.glb\n"), 2;
    std::ifstream in(argv[1], std::ios::binary);
    const std::vector<uint8_t> bytes((std::istreambuf_iterator<char>(in)), {});
    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE, 1);
    if (!context) return std::printf("%s\n", context.error().message.c_str()), 1;
    auto avatar = context->loadAvatar(bytes);
    if (!avatar) return std::printf("%s\n", avatar.error().message.c_str()), 1;
    if (auto broken = context->loadAvatar(std::span(bytes).first(bytes.size() / 2))) return std::printf("half a file was accepted\n"), 1;
    if (auto posed = avatar->setPoseFromClip(0, 0.25); !posed) return std::printf("%s\n", posed.error().message.c_str()), 1;
    std::vector<uint8_t> pixels(64 * 64 * 4);
    DplCamera camera{};  // set by field: later versions add fields, and zero in them keeps the earlier behaviour
    camera.structSize = sizeof camera;
    camera.widthPx = camera.heightPx = 64;
    camera.fx = camera.fy = 60, camera.cx = camera.cy = 32;
    const float viewFromWorld[12] = {1, 0, 0, 0, 0, -1, 0, 1, 0, 0, -1, 3};
    std::copy(viewFromWorld, viewFromWorld + 12, camera.viewFromWorld);
    DplImage image{};
    image.structSize = sizeof image;
    image.flags = DPL_IMAGE_STRAIGHT_ALPHA;
    image.rgba = pixels.data(), image.rgbaBytes = pixels.size();
    if (auto drawn = avatar->render({&camera, 1}, {&image, 1}); !drawn) return std::printf("%s\n", drawn.error().message.c_str()), 1;
    const uint8_t* middle = &pixels[(28 * 64 + 32) * 4];
    std::printf("%s drew %d %d %d %d\n", context->rendererName().c_str(), middle[0], middle[1], middle[2], middle[3]);
    doppel::Avatar moved = std::move(*avatar);
    return moved.info() && middle[0] > 240 && middle[3] > 128 ? 0 : 1;
}
