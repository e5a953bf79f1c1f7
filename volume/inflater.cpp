// Compressed bytes read as a stream.
// SPDX-License-Identifier: MPL-2.0
#include "volume/inflater.h"

#include "volume/errors.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <limits>
#include <new>

namespace isocast {

struct Inflater::State {
    z_stream stream{};
    std::span<const std::byte> input; // what the stream has not been given yet
    std::string name;
    bool has_ended = false;

    ~State() { ::inflateEnd(&stream); }
};

Inflater::Inflater(std::span<const std::byte> compressed, std::string name)
    : state_(std::make_unique<State>()) {
    state_->input = compressed;
    state_->name = std::move(name);
    // 15 + 32: the largest window, and gzip or zlib by the first bytes.
    if (::inflateInit2(&state_->stream, 15 + 32) != Z_OK) throw std::bad_alloc();
}

Inflater::~Inflater() = default;

double Inflater::most_bytes_from(std::uint64_t compressed_bytes) {
    // zlib.net/zlib_tech.html: the limit of deflate is 1032 : 1; one block is given to the ends.
    return 1032.0 * static_cast<double>(compressed_bytes) + 65536;
}

/// Fills `out` as far as the stream reaches; returns how far.
std::size_t Inflater::read_some(std::span<std::byte> out) {
    constexpr std::size_t most = std::numeric_limits<uInt>::max(); // zlib counts in 32 bits
    z_stream& stream = state_->stream;
    std::span<const std::byte>& input = state_->input;
    std::size_t done = 0;
    while (done < out.size()) {
        if (stream.avail_in == 0 && !input.empty()) {
            const std::size_t count = std::min(input.size(), most);
            stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(input.data()));
            stream.avail_in = static_cast<uInt>(count);
            input = input.subspan(count);
        }
        if (state_->has_ended) {
            // Another member of a gzip file, or what is no part of the stream.
            if (stream.avail_in < 2 || stream.next_in[0] != 0x1f || stream.next_in[1] != 0x8b)
                return done;
            ::inflateReset(&stream);
            state_->has_ended = false;
        }
        stream.next_out = reinterpret_cast<Bytef*>(out.data() + done);
        const std::size_t room = std::min(out.size() - done, most);
        stream.avail_out = static_cast<uInt>(room);
        const int result = ::inflate(&stream, Z_NO_FLUSH);
        done += room - stream.avail_out;
        if (result == Z_STREAM_END) {
            state_->has_ended = true;
        } else if (result == Z_MEM_ERROR) {
            throw std::bad_alloc();
        } else if (result == Z_BUF_ERROR && stream.avail_in == 0 && input.empty()) {
            return done; // cut off
        } else if (result != Z_OK && result != Z_BUF_ERROR) {
            throw InputError(
                fmt::format("cannot read {}: its compressed samples are damaged ({})", state_->name,
                            stream.msg != nullptr ? stream.msg : "no zlib or gzip stream"));
        }
    }
    return done;
}

void Inflater::read(std::span<std::byte> out) {
    const std::size_t count = read_some(out);
    if (count < out.size())
        throw InputError(fmt::format("cannot read {}: its compressed samples are truncated: {} of "
                                     "{} bytes",
                                     state_->name, count, out.size()));
}

void Inflater::skip(std::uint64_t count) {
    std::array<std::byte, 4096> ignored;
    while (count > 0) {
        const auto part = static_cast<std::size_t>(std::min<std::uint64_t>(count, ignored.size()));
        read(std::span(ignored).first(part));
        count -= part;
    }
}

bool Inflater::is_at_end() {
    std::byte next{};
    if (read_some({&next, 1}) > 0) return false;
    if (!state_->has_ended)
        throw InputError(
            fmt::format("cannot read {}: its compressed samples are truncated", state_->name));
    return true;
}

} // namespace isocast
