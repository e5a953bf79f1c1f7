// SPDX-License-Identifier: MPL-2.0
#include "gl/readback.h"

#include "gl/errors.h"

#include <fmt/format.h>
#include <glad/gl.h>

namespace isocast::gl {

ReadbackBuffer::ReadbackBuffer(std::int64_t byte_count, std::string_view label)
    : byte_count_(byte_count) {
    unsigned id = 0;
    glCreateBuffers(1, &id);
    handle_ = Handle<delete_buffer>(id);
    glObjectLabel(GL_BUFFER, id, static_cast<GLsizei>(label.size()), label.data());
    constexpr GLbitfield access = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    glNamedBufferStorage(id, byte_count, nullptr, access);
    data_ = static_cast<const std::byte*>(glMapNamedBufferRange(id, 0, byte_count, access));
    if (!data_)
        throw GlError(
            fmt::format("no memory for {} MiB of '{}' on the GL side", byte_count >> 20, label));
}

void ReadbackBuffer::clear() {
    const std::uint32_t zero = 0;
    glClearNamedBufferData(id(), GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &zero);
}

void ReadbackBuffer::bind_to_storage(unsigned binding) const {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, id());
}

Fence Fence::after_all_commands() {
    glMemoryBarrier(GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    Fence fence;
    fence.sync_ = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    glFlush();
    return fence;
}

Fence::~Fence() {
    if (sync_) glDeleteSync(static_cast<GLsync>(sync_));
}

void Fence::wait() const {
    constexpr GLuint64 one_second = 1'000'000'000; // in ns
    GLenum status = GL_TIMEOUT_EXPIRED;
    while (status == GL_TIMEOUT_EXPIRED)
        status =
            glClientWaitSync(static_cast<GLsync>(sync_), GL_SYNC_FLUSH_COMMANDS_BIT, one_second);
    if (status == GL_WAIT_FAILED) throw GlError("waiting for the GL failed");
}

std::int64_t max_storage_bytes() {
    GLint64 bytes = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &bytes);
    return bytes;
}

} // namespace isocast::gl
