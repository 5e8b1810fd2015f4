// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/surface/lone_parts.h"

#include <algorithm>

namespace dpl {
namespace {

constexpr uint32_t kNoPart = UINT32_MAX;

struct Part {
    size_t pixels = 0;
    bool person = false;
};

}  // namespace

std::vector<uint8_t> loneParts(std::span<const uint8_t> drawn, std::span<const uint8_t> person, uint32_t widthPx, uint32_t heightPx) {
    const size_t pixels = size_t(widthPx) * heightPx;
    if (drawn.size() != pixels || person.size() != pixels) return {};
    std::vector<uint32_t> partOf(pixels, kNoPart);
    std::vector<Part> parts;
    std::vector<size_t> open;
    for (size_t first = 0; first < pixels; ++first) {
        if (!drawn[first] || partOf[first] != kNoPart) continue;
        const uint32_t own = uint32_t(parts.size());
        Part& part = parts.emplace_back();
        partOf[first] = own, open.assign(1, first);
        while (!open.empty()) {
            const size_t at = open.back();
            open.pop_back();
            ++part.pixels, part.person |= person[at] != 0;
            const uint32_t x = uint32_t(at % widthPx), y = uint32_t(at / widthPx);
            for (uint32_t ny = y > 0 ? y - 1 : 0; ny <= std::min(y + 1, heightPx - 1); ++ny)
                for (uint32_t nx = x > 0 ? x - 1 : 0; nx <= std::min(x + 1, widthPx - 1); ++nx) {
                    const size_t next = size_t(ny) * widthPx + nx;
                    if (drawn[next] && partOf[next] == kNoPart) partOf[next] = own, open.push_back(next);
                }
        }
    }
    std::vector<uint8_t> lone(pixels, 0);
    if (parts.empty()) return lone;
    const auto largest = std::max_element(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.pixels < b.pixels; });
    for (size_t i = 0; i < pixels; ++i)
        if (partOf[i] != kNoPart) lone[i] = &parts[partOf[i]] != &*largest && !parts[partOf[i]].person;
    return lone;
}

}  // namespace dpl
