// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/subject_upload.h"

#include <algorithm>

namespace dpl {
namespace {

/** Places of the ring: one for each frame in flight, one for the frame that comes next, and one that is being filled. */
constexpr size_t kPlaces = kAppSlots + 2;

}  // namespace

SubjectUpload::SubjectUpload(Backend& backend, std::vector<UploadPiece> pieces)
    : backend_(backend), pieces_(std::move(pieces)), buffers_(backend) {
    std::erase_if(pieces_, [](const UploadPiece& piece) { return piece.from.empty(); });
    for (const UploadPiece& piece : pieces_) allBytes_ += piece.from.size();
}

Status SubjectUpload::makeRing() {
    uint64_t largest = 0, slices = 0;
    for (const UploadPiece& piece : pieces_) {
        largest = std::max<uint64_t>(largest, piece.from.size());
        slices += (piece.from.size() + kCopiedBytesAFrame - 1) / kCopiedBytesAFrame;
    }
    placeBytes_ = (std::min(largest, kCopiedBytesAFrame) + 15) / 16 * 16;
    const size_t count = size_t(std::min<uint64_t>(slices, kPlaces));
    DPL_TRY(staging_, buffers_.create("staging ring", placeBytes_ * count, BufferMemory::Upload));
    places_.resize(count);
    given_ = count;
    return {};
}

Status SubjectUpload::queueGiven() {
    if (given_ == places_.size()) return {};
    Place& place = places_[given_];
    DPL_TRY(place.copy, backend_.queueCopy(staging_, given_ * placeBytes_, givenTo_, givenOffset_, place.bytes));
    given_ = places_.size();
    return {};
}

Result<double> SubjectUpload::next(UploadSlice& slice) {
    slice = {};
    if (doneBytes_ == allBytes_) return 1.0;
    if (!staging_) {
        DPL_RETURN_IF_ERROR(makeRing());
    }
    DPL_RETURN_IF_ERROR(queueGiven());
    for (Place& place : places_) {
        if (place.copy == 0) continue;
        DPL_TRY(const bool ran, backend_.hasRun(place.copy));
        if (!ran) continue;
        doneBytes_ += place.bytes;
        place = {};
    }
    if (piece_ < pieces_.size()) {
        const auto place = std::find_if(places_.begin(), places_.end(), [](const Place& p) { return p.copy == 0; });
        if (place != places_.end()) {
            const UploadPiece& piece = pieces_[piece_];
            place->bytes = std::min<uint64_t>(piece.from.size() - offset_, placeBytes_);
            given_ = size_t(place - places_.begin());
            givenTo_ = piece.to, givenOffset_ = offset_;
            slice = {backend_.mapped(staging_).subspan(given_ * placeBytes_, place->bytes), piece.from.subspan(offset_, place->bytes)};
            offset_ += place->bytes;
            if (offset_ == piece.from.size()) ++piece_, offset_ = 0;
        }
    }
    return double(doneBytes_) / double(allBytes_);
}

Status SubjectUpload::finish() {
    if (doneBytes_ == allBytes_) return {};
    for (const UploadPiece& piece : pieces_) {
        DPL_RETURN_IF_ERROR(backend_.write(piece.to, 0, piece.from));
    }
    doneBytes_ = allBytes_;
    return {};
}

}  // namespace dpl
