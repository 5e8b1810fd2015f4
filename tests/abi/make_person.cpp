// SPDX-License-Identifier: Apache-2.0
// Writes the avatar of call_everything.c: a person with humanoid bones, a clip and pose correctives.
#include <cstdio>
#include <fstream>

#include "sdk/format/avatar_file.h"
#include "tests/package/tiny_avatar.h"
#include "tests/unit/avatar/rigs.h"
#include "tests/unit/format/sample_correctives.h"

int main(int argc, char** argv) {
    if (argc != 2) return std::fprintf(stderr, "usage: %s FILE\n", argv[0]), 2;
    dpl::AvatarData person = dpl::test::tinyAvatar();
    person.joints = dpl::test::personRig(0.8f);
    person.captureMap.sides.assign(person.joints.size() * dpl::kCaptureSides, {});
    for (size_t s = 0; s < person.captureMap.sides.size(); s += dpl::kCaptureSides) person.captureMap.sides[s] = {0.002f, 0.004f, 7};
    dpl::sortSplats(person);
    const auto bytes = dpl::writeAvatar(dpl::test::withCorrectives(std::move(person), 1));
    if (!bytes) return std::fprintf(stderr, "%s\n", bytes.error().message.c_str()), 1;
    std::ofstream out(argv[1], std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes->data()), std::streamsize(bytes->size()));
    return out ? 0 : 1;
}
