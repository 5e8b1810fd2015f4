// SPDX-License-Identifier: Apache-2.0
// Memory of a texture of the software device, in the texel formats of Metal, so that what is stored is rounded as Metal rounds it.
#pragma once

#include <vector>

#include "sdk/backend/metal/mtl_seam.h"
#include "tests/metal/cpu/msl_entry.h"

namespace dpl::mtl {

bool isDepth(PixelFormat format);
/** Bytes of a texel in a copy to a buffer. 0: the software device does not know the format. */
uint32_t texelBytes(PixelFormat format);

class Pixels : public msl::Texture {
public:
    explicit Pixels(const TextureDesc& desc);
    glm::vec4 texel(uint32_t x, uint32_t y, uint32_t layer, uint32_t sample) const override;
    void store(uint32_t x, uint32_t y, uint32_t layer, uint32_t sample, glm::vec4 value);
    void clear(uint32_t layer, glm::vec4 value);
    /** What an attachment holds after StoreAction::DontCare, or before it is drawn with LoadAction::DontCare: values that nobody expects.
     */
    void spoil(uint32_t layer);
    /** Averages the samples of a layer into `to`. */
    void resolve(uint32_t layer, Pixels& to, uint32_t toLayer) const;
    const std::byte* row(uint32_t y, uint32_t layer) const { return at(0, y, layer, 0); }
    uint64_t bytes() const { return data_.size(); }

private:
    const std::byte* at(uint32_t x, uint32_t y, uint32_t layer, uint32_t sample) const {
        return data_.data() + (((size_t(layer) * heightPx + y) * widthPx + x) * samples + sample) * texelBytes_;
    }

    PixelFormat format_;
    uint32_t texelBytes_;
    std::vector<std::byte> data_;
};

}  // namespace dpl::mtl
