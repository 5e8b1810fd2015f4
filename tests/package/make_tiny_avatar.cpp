// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <cstring>
#include <fstream>

#include "sdk/format/avatar_file.h"
#include "tests/package/tiny_avatar.h"
#include "tests/unit/avatar/rigs.h"
#include "tests/unit/format/sample_expressions.h"

int main(int argc, char** argv) {
    const bool plain = argc == 3 && std::strcmp(argv[2], "--plain") == 0;    // without Draco
    const bool person = argc == 3 && std::strcmp(argv[2], "--person") == 0;  // a person in T-pose: joints, pose correctives, expressions
    if (argc != 2 && !plain && !person) return std::printf("usage: make_tiny_avatar OUT.glb [--plain | --person]\n"), 2;
    dpl::AvatarData avatar = dpl::test::tinyAvatar();
    if (person) {
        avatar.joints = dpl::test::personRig(0);
        avatar = dpl::test::withCorrectives(std::move(avatar), 3, {.reach = 1, .reachOffModes = 0.5f});
        std::fill(avatar.correctives.mean.begin(), avatar.correctives.mean.end(), 0.0f);
        avatar = dpl::test::withExpressions(std::move(avatar), 5, 3);
    }
    dpl::sortSplats(avatar);
    const auto bytes = dpl::writeAvatar(avatar, {.draco = !plain});
    if (!bytes) return std::printf("%s\n", bytes.error().message.c_str()), 1;
    std::ofstream out(argv[1], std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes->data()), std::streamsize(bytes->size()));
    return out.good() ? 0 : 1;
}
