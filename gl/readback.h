// Results that come back from the GL while it works on: mapped buffers and fences.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "gl/objects.h"

namespace isocast::gl {

/// A buffer that shaders write and the CPU reads through a mapping which lasts as long as it does.
class ReadbackBuffer {
public:
    ReadbackBuffer() = default;
    /// throws  GlError if the GL has no memory for it
    ReadbackBuffer(std::int64_t byte_count, std::string_view label);
    unsigned id() const { return handle_.id(); }
    std::int64_t byte_count() const { return byte_count_; }
    /// Sets all bytes to zero, after what was drawn before.
    void clear();
    /// For shaders' storage block of that number.
    void bind_to_storage(unsigned binding) const;
    /// What the shaders wrote before the last fence that was waited for.
    const std::byte* data() const { return data_; }

private:
    Handle<delete_buffer> handle_;
    const std::byte* data_ = nullptr; // unmapped with the buffer
    std::int64_t byte_count_ = 0;
};

/// A mark in the stream of GL commands.
class Fence {
public:
    Fence() = default;
    /// Behind all commands so far; what they wrote to mapped buffers is visible once it is passed.
    static Fence after_all_commands();
    Fence(Fence&& other) noexcept : sync_(std::exchange(other.sync_, nullptr)) {}
    Fence& operator=(Fence&& other) noexcept {
        std::swap(sync_, other.sync_);
        return *this;
    }
    ~Fence();

    /// Returns when the GL has passed the mark.
    /// throws  GlError if it never will
    void wait() const;

private:
    void* sync_ = nullptr; // GLsync
};

/// Greatest size of a shader storage block.
std::int64_t max_storage_bytes();

} // namespace isocast::gl
