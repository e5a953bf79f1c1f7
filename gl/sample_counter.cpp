// SPDX-License-Identifier: MPL-2.0
#include "gl/sample_counter.h"

#include <glad/gl.h>

namespace isocast::gl {

SampleCounter::SampleCounter() {
    unsigned id = 0;
    glCreateQueries(GL_SAMPLES_PASSED, 1, &id);
    query_ = Handle<delete_query>(id);
}

void SampleCounter::start() {
    glBeginQuery(GL_SAMPLES_PASSED, query_.id());
}
void SampleCounter::stop() {
    glEndQuery(GL_SAMPLES_PASSED);
}

std::int64_t SampleCounter::count() const {
    GLuint64 count = 0;
    glGetQueryObjectui64v(query_.id(), GL_QUERY_RESULT, &count);
    return static_cast<std::int64_t>(count);
}

} // namespace isocast::gl
