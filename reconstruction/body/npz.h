// SPDX-License-Identifier: Apache-2.0
// Bounded reading of NumPy archives (.npz = zip of .npy): numbers only, never pickles.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

/** One array, converted to double, in C order. */
struct NpyArray {
    std::vector<size_t> shape;
    std::vector<double> values;
};

/** Entries of an .npz by name (without ".npy"), located but not yet unpacked. The bytes must outlive it. */
class NpzFile {
public:
    /** Checks the zip directory. CorruptData or Unsupported (zip64, encryption) with a sentence. */
    static Result<NpzFile> open(std::span<const uint8_t> bytes);

    bool has(const std::string& name) const { return entries_.count(name) != 0; }

    /** Unpacks one array of floats or integers. Refused: object arrays (they would need Python), big-endian data, more than `maxBytes`. */
    Result<NpyArray> read(const std::string& name, size_t maxBytes) const;

private:
    struct Entry {
        std::span<const uint8_t> stored;
        size_t plainBytes = 0;
        bool deflated = false;
    };
    std::map<std::string, Entry> entries_;
};

/** Parses one .npy file. */
Result<NpyArray> parseNpy(std::span<const uint8_t> bytes);

}  // namespace dpl
