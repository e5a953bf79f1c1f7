// SPDX-License-Identifier: MPL-2.0
#include "stability/shader_probe.h"

#include <glad/gl.h>

#include <span>

namespace isocast::stability {

std::vector<gl::ProgramKey> probe_programs() {
    return {{{"filtering/curvature_probe.comp"}, {}}};
}

std::vector<Eigen::Vector4f> run_curvature_probe(Device& device,
                                                 const std::vector<Eigen::Vector4f>& derivatives) {
    const std::size_t count = derivatives.size() / 4;
    std::vector<Eigen::Vector4f> out(3 * count);
    const gl::Buffer from(std::as_bytes(std::span(derivatives)), "derivatives");
    const gl::Buffer to(std::as_bytes(std::span(out)), "curvatures");
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, from.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, to.id());
    device.shaders.program(probe_programs().front()).use();
    glDispatchCompute(static_cast<GLuint>(count + 63) / 64, 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(to.id(), 0, static_cast<GLsizeiptr>(out.size() * sizeof(out[0])),
                            out.data());
    return out;
}

} // namespace isocast::stability
