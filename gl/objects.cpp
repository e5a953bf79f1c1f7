// SPDX-License-Identifier: MPL-2.0
#include "gl/objects.h"

#include "gl/errors.h"

#include <fmt/format.h>
#include <glad/gl.h>

#include <sys/mman.h>

#include <algorithm>
#include <bit>
#include <cassert>

namespace isocast::gl {

namespace {

void set_label(GLenum kind, unsigned id, std::string_view label) {
    glObjectLabel(kind, id, static_cast<GLsizei>(label.size()), label.data());
}

struct FormatInfo {
    GLenum internal;
    GLenum channels;
    int floats;
    int bytes;
};

FormatInfo info(Format format) {
    switch (format) {
    case Format::R16:
        return {GL_R16, GL_RED, 1, 2};
    case Format::R16f:
        return {GL_R16F, GL_RED, 1, 2};
    case Format::R32f:
        return {GL_R32F, GL_RED, 1, 4};
    case Format::R32i:
        return {GL_R32I, GL_RED_INTEGER, 1, 4};
    case Format::R32ui:
        return {GL_R32UI, GL_RED_INTEGER, 1, 4};
    case Format::Rg32f:
        return {GL_RG32F, GL_RG, 2, 8};
    case Format::Rg32i:
        return {GL_RG32I, GL_RG_INTEGER, 2, 8};
    case Format::Rg32ui:
        return {GL_RG32UI, GL_RG_INTEGER, 2, 8};
    case Format::Rgba16:
        return {GL_RGBA16, GL_RGBA, 4, 8};
    case Format::Rgba32f:
        return {GL_RGBA32F, GL_RGBA, 4, 16};
    case Format::Rgba32i:
        return {GL_RGBA32I, GL_RGBA_INTEGER, 4, 16};
    case Format::Rgba32ui:
        return {GL_RGBA32UI, GL_RGBA_INTEGER, 4, 16};
    case Format::Rgba16f:
        return {GL_RGBA16F, GL_RGBA, 4, 8};
    case Format::Rgba8:
        return {GL_RGBA8, GL_RGBA, 4, 4};
    case Format::Depth32f:
        return {GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, 1, 4};
    }
    throw GlError("unknown texture format");
}

// GL_OUT_OF_MEMORY is the one error that release builds must ask for.
void throw_if_out_of_memory(std::int64_t bytes, std::string_view label) {
    if (glGetError() == GL_OUT_OF_MEMORY)
        throw GlError(
            fmt::format("no memory for {} MiB of '{}' on the GL side", bytes >> 20, label));
}

/// Asks for pages of 2 MiB where the GL's memory is the process's own, as that of software
/// rasterisers is: a first touch of 4 KiB costs microseconds, and so does a miss of the TLB. Where
/// it is a device's, the kernel refuses.
void use_huge_pages(void* memory, std::int64_t byte_count) {
    constexpr std::uintptr_t huge = std::uintptr_t{1} << 21;
    const auto begin = (reinterpret_cast<std::uintptr_t>(memory) + huge - 1) & ~(huge - 1);
    const auto end =
        (reinterpret_cast<std::uintptr_t>(memory) + static_cast<std::uintptr_t>(byte_count)) &
        ~(huge - 1);
    if (begin < end) madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
}

} // namespace

void delete_buffer(unsigned id) noexcept {
    glDeleteBuffers(1, &id);
}
void delete_texture(unsigned id) noexcept {
    glDeleteTextures(1, &id);
}
void delete_framebuffer(unsigned id) noexcept {
    glDeleteFramebuffers(1, &id);
}
void delete_vertex_array(unsigned id) noexcept {
    glDeleteVertexArrays(1, &id);
}
void delete_program(unsigned id) noexcept {
    glDeleteProgram(id);
}
void delete_query(unsigned id) noexcept {
    glDeleteQueries(1, &id);
}

Buffer::Buffer(std::span<const std::byte> data, std::string_view label)
    : byte_count_(static_cast<std::int64_t>(data.size())) {
    unsigned id = 0;
    glCreateBuffers(1, &id);
    handle_ = Handle<delete_buffer>(id);
    set_label(GL_BUFFER, id, label);
    // GL refuses buffers of no bytes; one byte stands for "empty".
    glNamedBufferStorage(id, std::max<GLsizeiptr>(1, static_cast<GLsizeiptr>(data.size())),
                         data.empty() ? nullptr : data.data(), 0);
    throw_if_out_of_memory(byte_count_, label);
}

Buffer Buffer::writable(std::int64_t byte_count, std::string_view label) {
    Buffer buffer;
    buffer.byte_count_ = std::max<std::int64_t>(1, byte_count); // GL refuses buffers of no bytes
    unsigned id = 0;
    glCreateBuffers(1, &id);
    buffer.handle_ = Handle<delete_buffer>(id);
    set_label(GL_BUFFER, id, label);
    glNamedBufferStorage(id, buffer.byte_count_, nullptr, GL_MAP_WRITE_BIT);
    throw_if_out_of_memory(buffer.byte_count_, label);
    return buffer;
}

void Buffer::write(std::int64_t offset, std::int64_t byte_count,
                   const std::function<void(std::span<std::byte>)>& write) {
    if (byte_count == 0) return;
    void* memory = glMapNamedBufferRange(id(), offset, byte_count,
                                         GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_RANGE_BIT);
    if (!memory) throw GlError(fmt::format("cannot map {} MiB of a buffer", byte_count >> 20));
    struct Unmap {
        unsigned id;
        ~Unmap() { glUnmapNamedBuffer(id); }
    };
    const Unmap unmap{id()};
    use_huge_pages(memory, byte_count);
    write({static_cast<std::byte*>(memory), static_cast<std::size_t>(byte_count)});
}

BufferTexture::BufferTexture(const Buffer& buffer, Format format, std::string_view label) {
    const std::int64_t texels = buffer.byte_count() / info(format).bytes;
    if (texels > max_buffer_texels())
        throw GlError(fmt::format("'{}' has {} texels; a buffer texture holds {}", label, texels,
                                  max_buffer_texels()));
    unsigned id = 0;
    glCreateTextures(GL_TEXTURE_BUFFER, 1, &id);
    handle_ = Handle<delete_texture>(id);
    set_label(GL_TEXTURE, id, label);
    glTextureBuffer(id, info(format).internal, buffer.id());
}

void BufferTexture::bind_to_unit(unsigned unit) const {
    glBindTextureUnit(unit, handle_.id());
}

int byte_count(Format format) {
    return info(format).bytes;
}

Texture::Texture(unsigned target, Format format, int width, int height, int depth,
                 std::string_view label, Filter filter, int level_count)
    : format_(format), size_{width, height, depth}, level_count_(level_count) {
    unsigned id = 0;
    glCreateTextures(target, 1, &id);
    handle_ = Handle<delete_texture>(id);
    set_label(GL_TEXTURE, id, label);
    if (target == GL_TEXTURE_3D)
        glTextureStorage3D(id, 1, info(format).internal, width, height, depth);
    else
        glTextureStorage2D(id, level_count, info(format).internal, width, height);
    throw_if_out_of_memory(byte_count(), label);
    const int way = filter == Filter::Linear ? GL_LINEAR : GL_NEAREST;
    glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, way);
    glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, way);
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
        glTextureParameteri(id, axis, GL_CLAMP_TO_EDGE);
}

Texture Texture::image(Format format, int width, int height, std::string_view label,
                       Filter filter) {
    return {GL_TEXTURE_2D, format, width, height, 1, label, filter};
}

Texture Texture::picture(Format format, int width, int height, std::span<const float> rgba,
                         Wrap wrap, std::string_view label, Levels levels) {
    assert(rgba.size() == 4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    const unsigned longest = static_cast<unsigned>(std::max(width, height));
    Texture texture(GL_TEXTURE_2D, format, width, height, 1, label, Filter::Linear,
                    levels == Levels::All ? std::bit_width(longest) : 1);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTextureSubImage2D(texture.id(), 0, 0, 0, width, height, GL_RGBA, GL_FLOAT, rgba.data());
    if (levels == Levels::All) {
        glGenerateTextureMipmap(texture.id());
        glTextureParameteri(texture.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    }
    if (wrap != Wrap::Clamp) glTextureParameteri(texture.id(), GL_TEXTURE_WRAP_S, GL_REPEAT);
    if (wrap == Wrap::Repeat) glTextureParameteri(texture.id(), GL_TEXTURE_WRAP_T, GL_REPEAT);
    return texture;
}

Texture Texture::volume(Format format, int width, int height, int depth, Filter filter,
                        std::string_view label) {
    return {GL_TEXTURE_3D, format, width, height, depth, label, filter};
}

std::int64_t Texture::byte_count() const {
    if (is_empty()) return 0;
    std::int64_t texels = 0;
    for (int level = 0; level < level_count_; ++level)
        texels += std::int64_t{std::max(size_[0] >> level, 1)} * std::max(size_[1] >> level, 1) *
                  size_[2];
    return texels * info(format_).bytes;
}

void Texture::upload_box(int x, int y, int z, int width, int height, int depth,
                         std::span<const std::byte> texels) {
    assert(texels.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                                static_cast<std::size_t>(depth) *
                                static_cast<std::size_t>(info(format_).bytes));
    const int channel_bytes = info(format_).bytes / info(format_).floats;
    const bool is_half = format_ == Format::R16f || format_ == Format::Rgba16f;
    glPixelStorei(GL_UNPACK_ALIGNMENT, channel_bytes);
    glTextureSubImage3D(id(), 0, x, y, z, width, height, depth, info(format_).channels,
                        channel_bytes == 4 ? GL_FLOAT
                        : is_half          ? GL_HALF_FLOAT
                                           : GL_UNSIGNED_SHORT,
                        texels.data());
}

void Texture::read_rgba(std::span<float> out) const {
    assert(out.size() ==
           static_cast<std::size_t>(width()) * static_cast<std::size_t>(height()) * 4);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    // llvmpipe (Mesa 22.3) waits for what the last framebuffer draws, but may hand out a texture
    // that one before still fills.
    glFinish();
    glGetTextureImage(id(), 0, GL_RGBA, GL_FLOAT, static_cast<GLsizei>(out.size_bytes()),
                      out.data());
}

void Texture::bind_to_unit(unsigned unit) const {
    glBindTextureUnit(unit, id());
}

void Texture::bind_as_image(unsigned unit) const {
    glBindImageTexture(unit, id(), 0, GL_FALSE, 0, GL_READ_WRITE, info(format_).internal);
}

void Texture::clear(int value) {
    assert(format_ == Format::R32i);
    glClearTexImage(id(), 0, GL_RED_INTEGER, GL_INT, &value);
}

Framebuffer::Framebuffer(const std::vector<const Texture*>& colours, std::string_view label,
                         const Texture* depth) {
    unsigned id = 0;
    glCreateFramebuffers(1, &id);
    handle_ = Handle<delete_framebuffer>(id);
    set_label(GL_FRAMEBUFFER, id, label);
    GLenum attachments[8];
    GLsizei count = 0;
    for (const Texture* colour : colours) {
        attachments[count] = GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(count);
        glNamedFramebufferTexture(id, attachments[count], colour->id(), 0);
        width_ = colour->width();
        height_ = colour->height();
        ++count;
    }
    glNamedFramebufferDrawBuffers(id, count, attachments);
    if (depth != nullptr) glNamedFramebufferTexture(id, GL_DEPTH_ATTACHMENT, depth->id(), 0);
    if (const GLenum status = glCheckNamedFramebufferStatus(id, GL_DRAW_FRAMEBUFFER);
        status != GL_FRAMEBUFFER_COMPLETE)
        throw GlError(fmt::format("framebuffer '{}' of {}x{} is incomplete (0x{:x})", label, width_,
                                  height_, status));
}

Framebuffer Framebuffer::without_attachments(int width, int height, std::string_view label) {
    unsigned id = 0;
    glCreateFramebuffers(1, &id);
    Framebuffer framebuffer;
    framebuffer.handle_ = Handle<delete_framebuffer>(id);
    set_label(GL_FRAMEBUFFER, id, label);
    glNamedFramebufferParameteri(id, GL_FRAMEBUFFER_DEFAULT_WIDTH, width);
    glNamedFramebufferParameteri(id, GL_FRAMEBUFFER_DEFAULT_HEIGHT, height);
    framebuffer.width_ = width;
    framebuffer.height_ = height;
    return framebuffer;
}

void Framebuffer::bind() const {
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, id());
    glViewport(0, 0, width_, height_);
}

VertexArray VertexArray::without_attributes(std::string_view label) {
    unsigned id = 0;
    glCreateVertexArrays(1, &id);
    VertexArray array;
    array.handle_ = Handle<delete_vertex_array>(id);
    set_label(GL_VERTEX_ARRAY, id, label);
    return array;
}

VertexArray VertexArray::indexed(const Buffer& indices, std::string_view label) {
    VertexArray array = without_attributes(label);
    glVertexArrayElementBuffer(array.handle_.id(), indices.id());
    return array;
}

VertexArray VertexArray::instanced_ivec4(const Buffer& records, std::string_view label) {
    VertexArray array = without_attributes(label);
    const unsigned id = array.handle_.id();
    glVertexArrayVertexBuffer(id, 0, records.id(), 0, 4 * sizeof(GLint));
    glVertexArrayAttribIFormat(id, 0, 4, GL_INT, 0);
    glVertexArrayAttribBinding(id, 0, 0);
    glVertexArrayBindingDivisor(id, 0, 1);
    glEnableVertexArrayAttrib(id, 0);
    return array;
}

VertexArray VertexArray::instanced(const Buffer& records, std::span<const AttributeType> attributes,
                                   const Buffer& indices, std::string_view label) {
    VertexArray array = without_attributes(label);
    const unsigned id = array.handle_.id();
    constexpr unsigned bytes = 16; // of an attribute
    glVertexArrayVertexBuffer(id, 0, records.id(), 0,
                              static_cast<GLsizei>(bytes * attributes.size()));
    glVertexArrayBindingDivisor(id, 0, 1);
    for (unsigned i = 0; i < attributes.size(); ++i) {
        if (attributes[i] == AttributeType::Int4)
            glVertexArrayAttribIFormat(id, i, 4, GL_INT, bytes * i);
        else
            glVertexArrayAttribFormat(id, i, 4, GL_FLOAT, GL_FALSE, bytes * i);
        glVertexArrayAttribBinding(id, i, 0);
        glEnableVertexArrayAttrib(id, i);
    }
    glVertexArrayElementBuffer(id, indices.id());
    return array;
}

void VertexArray::bind() const {
    glBindVertexArray(handle_.id());
}

DebugGroup::DebugGroup(std::string_view label) {
    glPushDebugGroup(GL_DEBUG_SOURCE_APPLICATION, 0, static_cast<GLsizei>(label.size()),
                     label.data());
}
DebugGroup::~DebugGroup() {
    glPopDebugGroup();
}

std::int64_t max_buffer_texels() {
    GLint64 texels = 0;
    glGetInteger64v(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    return texels;
}

int max_volume_extent() {
    GLint extent = 0;
    glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &extent);
    return extent;
}

int max_image_extent() {
    GLint texture = 0;
    GLint viewport[2] = {0, 0};
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &texture);
    glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
    return std::min({texture, viewport[0], viewport[1]});
}

} // namespace isocast::gl
