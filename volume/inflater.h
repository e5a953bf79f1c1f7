// Compressed bytes read as a stream.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace isocast {

/// Reads what gzip (one or several members in a row) or zlib compressed, from front to back.
class Inflater {
public:
    /// name  of the file, for messages
    Inflater(std::span<const std::byte> compressed, std::string name);
    ~Inflater();

    /// The next out.size() bytes.
    /// throws  InputError that names the file if the stream is damaged or ends before
    void read(std::span<std::byte> out);
    void skip(std::uint64_t count);
    /// Whether nothing follows; also checks the stream's sum.
    /// throws  InputError if that is wrong
    bool is_at_end();

    /// No stream expands further: more bytes than this from `compressed_bytes` are a wrong size.
    static double most_bytes_from(std::uint64_t compressed_bytes);

private:
    std::size_t read_some(std::span<std::byte> out);

    struct State;
    std::unique_ptr<State> state_;
};

} // namespace isocast
