// SPDX-License-Identifier: Apache-2.0
// A build without Vulkan: there is no plain frame, and opening says so.
#include "tests/baseline/plain_file.h"

namespace dpl {

struct PlainFile::State {};

PlainFile::PlainFile(std::unique_ptr<State> state, std::string name) : state_(std::move(state)), name_(std::move(name)) {}
PlainFile::PlainFile(PlainFile&&) noexcept = default;
PlainFile& PlainFile::operator=(PlainFile&&) noexcept = default;
PlainFile::~PlainFile() = default;

Result<PlainFile> PlainFile::open(std::span<const uint8_t>, PlainFill) {
    return fail(Code::Unsupported, "this build of Doppel is without Vulkan (DOPPEL_VULKAN=OFF)");
}
Status PlainFile::draw(std::span<const float>, const Vec3f&, std::span<const Cameraf>) {
    return fail(Code::Unsupported, "this build is without Vulkan");
}
Status PlainFile::read(std::span<std::vector<uint8_t>>) {
    return fail(Code::Unsupported, "this build is without Vulkan");
}
PlainStats PlainFile::stats() const {
    return {};
}

}  // namespace dpl
