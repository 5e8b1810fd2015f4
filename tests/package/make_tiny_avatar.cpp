// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <cstring>
#include <fstream>

#include "sdk/format/avatar_file.h"
#include "tests/package/tiny_avatar.h"

int main(int argc, char** argv) {
    const bool plain = argc == 3 && std::strcmp(argv[2], "--plain") == 0;  // without Draco
    if (argc != 2 && !plain) return std::printf("usage: make_tiny_avatar OUT.glb [--plain]\n"), 2;
    dpl::AvatarData avatar = dpl::test::tinyAvatar();
    dpl::sortSplats(avatar);
    const auto bytes = dpl::writeAvatar(avatar, {.draco = !plain});
    if (!bytes) return std::printf("%s\n", bytes.error().message.c_str()), 1;
    std::ofstream out(argv[1], std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes->data()), std::streamsize(bytes->size()));
    return out.good() ? 0 : 1;
}
