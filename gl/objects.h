// OpenGL objects as move-only values.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace isocast::gl {

void delete_buffer(unsigned id) noexcept;
void delete_texture(unsigned id) noexcept;
void delete_framebuffer(unsigned id) noexcept;
void delete_vertex_array(unsigned id) noexcept;
void delete_program(unsigned id) noexcept;
void delete_query(unsigned id) noexcept;

/// The name of one GL object, deleted with its owner. Default-constructed it is empty: id() == 0.
template<void (*Delete)(unsigned) noexcept>
class Handle {
public:
    Handle() = default;
    explicit Handle(unsigned id) : id_(id) {}
    Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
    Handle& operator=(Handle&& other) noexcept {
        std::swap(id_, other.id_);
        return *this;
    }
    ~Handle() {
        if (id_ != 0) Delete(id_);
    }
    unsigned id() const { return id_; }
    bool is_empty() const { return id_ == 0; }

private:
    unsigned id_ = 0;
};

/// A buffer: of given contents for good, or of a size, to be written by pieces.
class Buffer {
public:
    Buffer() = default;
    Buffer(std::span<const std::byte> data, std::string_view label);
    /// Contents are undefined until written.
    /// throws  GlError if the GL has no memory for it
    static Buffer writable(std::int64_t byte_count, std::string_view label);
    unsigned id() const { return handle_.id(); }
    std::int64_t byte_count() const { return byte_count_; }

    /// Hands `write` the memory of a range to fill, by any thread, and gives it back to the GL.
    /// Earlier contents of the range are lost. Writable buffers only.
    void write(std::int64_t offset, std::int64_t byte_count,
               const std::function<void(std::span<std::byte>)>& write);

private:
    Handle<delete_buffer> handle_;
    std::int64_t byte_count_ = 0;
};

/// Formats that we use.
enum class Format {
    R16,
    R16f,
    R32f,
    R32i,
    R32ui,
    Rg32f,
    Rg32i,
    Rg32ui,
    Rgba16,
    Rgba16f,
    Rgba32f,
    Rgba32i,
    Rgba32ui,
    Rgba8,
    Depth32f
};

/// Bytes of one texel.
int byte_count(Format format);

/// A buffer that shaders read as an array of texels.
class BufferTexture {
public:
    BufferTexture() = default;
    /// throws  GlError if it has more texels than max_buffer_texels
    BufferTexture(const Buffer& buffer, Format format, std::string_view label);
    void bind_to_unit(unsigned unit) const;

private:
    Handle<delete_texture> handle_;
};

enum class Filter { Nearest, Linear };
enum class Wrap { Clamp, RepeatX, Repeat };
enum class Levels { One, All };

/// An immutable 2D or 3D texture, clamped to its edge.
class Texture {
public:
    Texture() = default;
    static Texture image(Format format, int width, int height, std::string_view label,
                         Filter filter = Filter::Nearest);
    /// A linearly filtered 2D texture with contents.
    ///
    /// rgba    4 floats a texel, x fastest
    /// levels  All: and averages of it, each half as large
    static Texture picture(Format format, int width, int height, std::span<const float> rgba,
                           Wrap wrap, std::string_view label, Levels levels = Levels::One);
    static Texture volume(Format format, int width, int height, int depth, Filter filter,
                          std::string_view label);

    unsigned id() const { return handle_.id(); }
    bool is_empty() const { return handle_.is_empty(); }
    int width() const { return size_[0]; }
    int height() const { return size_[1]; }
    int depth() const { return size_[2]; }
    std::int64_t byte_count() const;

    /// Replaces a box of a 3D texture of floats, halves or 16-bit numbers; texels as they are
    /// stored, x fastest.
    void upload_box(int x, int y, int z, int width, int height, int depth,
                    std::span<const std::byte> texels);

    /// All texels of a 2D texture as floats, 4 a texel, the bottom row first.
    void read_rgba(std::span<float> out) const;

    void bind_to_unit(unsigned unit) const;
    /// For shaders that read and write single texels.
    void bind_as_image(unsigned unit) const;
    /// R32i: the same number everywhere.
    void clear(int value);

private:
    Texture(unsigned target, Format format, int width, int height, int depth,
            std::string_view label, Filter filter = Filter::Nearest, int level_count = 1);

    Handle<delete_texture> handle_;
    Format format_ = Format::Rgba8;
    int size_[3] = {0, 0, 0};
    int level_count_ = 1;
};

/// A framebuffer with colour attachments 0, 1, … and perhaps a depth buffer.
class Framebuffer {
public:
    Framebuffer() = default;
    /// throws  GlError if the driver finds it incomplete
    Framebuffer(const std::vector<const Texture*>& colours, std::string_view label,
                const Texture* depth = nullptr);
    /// For shaders that write to buffers alone.
    static Framebuffer without_attachments(int width, int height, std::string_view label);
    unsigned id() const { return handle_.id(); }

    /// Draws go here from now on, over the whole of it.
    void bind() const;

private:
    Handle<delete_framebuffer> handle_;
    int width_ = 0;
    int height_ = 0;
};

enum class AttributeType { Float4, Int4 };

/// Vertex input: none, or one buffer of records.
class VertexArray {
public:
    VertexArray() = default;
    /// No attributes: the vertex shader makes its vertices from gl_VertexID.
    static VertexArray without_attributes(std::string_view label);
    /// The same, in the order of `indices` of 16 bits.
    static VertexArray indexed(const Buffer& indices, std::string_view label);
    /// Attribute 0: an ivec4 for each instance, tightly packed.
    static VertexArray instanced_ivec4(const Buffer& records, std::string_view label);
    /// Attributes 0, 1, …: 16 bytes each, one after the other, for each instance; vertices by
    /// `indices` of 16 bits.
    static VertexArray instanced(const Buffer& records, std::span<const AttributeType> attributes,
                                 const Buffer& indices, std::string_view label);
    void bind() const;

private:
    Handle<delete_vertex_array> handle_;
};

/// Names the GL calls in its scope for debuggers.
class DebugGroup {
public:
    explicit DebugGroup(std::string_view label);
    ~DebugGroup();
    DebugGroup(const DebugGroup&) = delete;
    DebugGroup& operator=(const DebugGroup&) = delete;
};

/// Greatest number of texels of a buffer texture.
std::int64_t max_buffer_texels();
/// Greatest extent of a 3D texture along each axis.
int max_volume_extent();
/// Greatest extent of a 2D texture and of a viewport.
int max_image_extent();

} // namespace isocast::gl
